// A region in the scene: a box or a ball with draggable handles. A box's faces move along their
// axis, a ball's outer handle changes its radius, and the center moves the whole region.
import * as THREE from "three";
import { mergeGeometries } from "three/examples/jsm/utils/BufferGeometryUtils.js";

import type { Region } from "../state/settings";
import type { Vec3 } from "../stream/dataset";
import { disposeTree } from "./dispose_tree";
import { layers } from "./layers";
import type { Stage } from "./stage";

interface Handle {
  mesh: THREE.Mesh;
  place: (region: Region) => Vec3;
  axis: THREE.Vector3 | null; // Null: moves in the view plane.
  dragged: (region: Region, to: Vec3) => Region;
}

const color = 0x4fb3ff;

export class RegionHandles {
  private readonly group = new THREE.Group();
  private region: Region | null = null;
  private handles: Handle[] = [];
  private grabbed: { handle: Handle; plane: THREE.Plane; offset: THREE.Vector3 } | null = null;

  constructor(
    private readonly stage: Stage,
    canvas: HTMLCanvasElement,
    private readonly changed: (region: Region, isDragging: boolean) => void,
    private readonly isFilled = true, // Otherwise, only handles and outlines, which are not in exported pictures.
  ) {
    stage.scene.add(this.group);
    // Before the camera's controls.
    canvas.addEventListener("pointerdown", (event) => this.grab(event), { capture: true });
    canvas.addEventListener("pointermove", (event) => {
      this.drag(event);
      canvas.style.cursor = event.buttons === 0 && this.handleAt(event.offsetX, event.offsetY) !== null ? "grab" : "";
    });
    const end = (event: PointerEvent) => {
      if (!this.grabbed) return;
      this.grabbed = null;
      this.stage.controls.enabled = true;
      canvas.releasePointerCapture(event.pointerId);
      if (this.region) this.changed(this.region, false);
    };
    canvas.addEventListener("pointerup", end);
    canvas.addEventListener("pointercancel", end);
    stage.whenDrawn(() => this.keepSize());
  }

  get isGrabbed(): boolean {
    return this.grabbed !== null;
  }

  show(region: Region | null): void {
    if (region === this.region) return;
    const isOtherKind = region?.kind !== this.region?.kind;
    this.region = region;
    if (isOtherKind) this.build();
    if (region) this.place(region);
    this.stage.invalidate();
  }

  private build(): void {
    disposeTree(this.group);
    this.handles = [];
    if (!this.region) return;
    const shape = this.region.kind === "box" ? new THREE.BoxGeometry(1, 1, 1) : new THREE.SphereGeometry(1, 48, 32);
    const glass = new THREE.Mesh(
      shape,
      new THREE.MeshBasicMaterial({ color: color, transparent: true, opacity: 0.1, depthWrite: false, side: THREE.DoubleSide }),
    );
    glass.renderOrder = 2;
    const edges = this.region.kind === "box" ? new THREE.LineSegments(new THREE.EdgesGeometry(shape), lineMaterial()) : rings();
    edges.renderOrder = 3;
    glass.layers.set(layers.marks);
    edges.layers.set(this.isFilled ? layers.marks : layers.overlay);
    // Faint where a surface hides them.
    const outline = new THREE.LineSegments(edges.geometry, lineMaterial(0.3, false));
    outline.renderOrder = 3;
    outline.layers.set(layers.overlay);
    glass.visible = this.isFilled;
    this.group.add(glass, edges, outline);
    this.handles = this.region.kind === "box" ? boxHandles() : ballHandles();
    this.group.add(...this.handles.map(({ mesh }) => mesh));
  }

  private place(region: Region): void {
    for (const part of this.group.children.slice(0, 3)) {
      if (region.kind === "box") {
        part.position.set(...middle(region.low, region.high));
        part.scale.set(...(region.high.map((v, i) => Math.max(1e-9, v - region.low[i])) as Vec3));
      } else {
        part.position.set(...region.center);
        part.scale.setScalar(Math.max(1e-9, region.radius));
      }
    }
    for (const { mesh, place } of this.handles) mesh.position.set(...place(region));
    this.keepSize();
  }

  // Handles have a constant size on the screen.
  private keepSize(): void {
    const { camera } = this.stage;
    const perPixel = this.stage.worldLengthOf(1) / camera.position.distanceTo(this.stage.controls.target);
    for (const { mesh } of this.handles) {
      mesh.scale.setScalar(7 * perPixel * camera.position.distanceTo(mesh.position));
    }
  }

  private handleAt(x: number, y: number): Handle | null {
    let nearest: Handle | null = null;
    let least = 16;
    for (const handle of this.handles) {
      const at = this.stage.project(handle.mesh.position);
      const distance = at ? Math.hypot(at.x - x, at.y - y) : Infinity;
      if (distance < least) {
        least = distance;
        nearest = handle;
      }
    }
    return nearest;
  }

  private grab(event: PointerEvent): void {
    const handle = event.button === 0 ? this.handleAt(event.offsetX, event.offsetY) : null;
    if (!handle) return;
    event.stopImmediatePropagation();
    (event.target as Element).setPointerCapture(event.pointerId);
    this.stage.controls.enabled = false;
    const { camera } = this.stage;
    const normal = camera.getWorldDirection(new THREE.Vector3());
    if (handle.axis) {
      // The plane through the axis that faces the eye most.
      normal.addScaledVector(handle.axis, -normal.dot(handle.axis));
      if (normal.lengthSq() < 1e-6) normal.copy(camera.up);
      normal.normalize();
    }
    const plane = new THREE.Plane().setFromNormalAndCoplanarPoint(normal, handle.mesh.position);
    const at = this.stage.rayAt(event.offsetX, event.offsetY).intersectPlane(plane, new THREE.Vector3());
    const offset = at ? handle.mesh.position.clone().sub(at) : new THREE.Vector3();
    this.grabbed = { handle, plane, offset };
  }

  private drag(event: PointerEvent): void {
    if (!this.grabbed || !this.region) return;
    const { handle, plane, offset } = this.grabbed;
    const at = this.stage.rayAt(event.offsetX, event.offsetY).intersectPlane(plane, new THREE.Vector3());
    if (!at) return;
    at.add(offset);
    if (handle.axis) {
      const start = handle.mesh.position;
      at.copy(start.clone().addScaledVector(handle.axis, at.sub(start).dot(handle.axis)));
    }
    this.changed(handle.dragged(this.region, at.toArray()), true);
  }
}

function boxHandles(): Handle[] {
  const handles: Handle[] = [];
  for (let axis = 0; axis < 3; ++axis) {
    for (const side of ["low", "high"] as const) {
      handles.push({
        mesh: handleMesh(),
        axis: new THREE.Vector3().setComponent(axis, 1),
        place: (region) => {
          if (region.kind !== "box") return [0, 0, 0];
          const at = middle(region.low, region.high);
          at[axis] = region[side][axis];
          return at;
        },
        dragged: (region, to) => {
          if (region.kind !== "box") return region;
          const moved = [...region[side]] as Vec3;
          moved[axis] = side === "low" ? Math.min(to[axis], region.high[axis]) : Math.max(to[axis], region.low[axis]);
          return { ...region, [side]: moved };
        },
      });
    }
  }
  handles.push({
    mesh: handleMesh(true),
    axis: null,
    place: (region) => (region.kind === "box" ? middle(region.low, region.high) : [0, 0, 0]),
    dragged: (region, to) => {
      if (region.kind !== "box") return region;
      const at = middle(region.low, region.high);
      const moved = (corner: Vec3) => corner.map((v, i) => v + to[i] - at[i]) as Vec3;
      return { ...region, low: moved(region.low), high: moved(region.high) };
    },
  });
  return handles;
}

function ballHandles(): Handle[] {
  const centerOf = (region: Region): Vec3 => (region.kind === "ball" ? region.center : [0, 0, 0]);
  return [
    {
      mesh: handleMesh(true),
      axis: null,
      place: centerOf,
      dragged: (region, to) => (region.kind === "ball" ? { ...region, center: to } : region),
    },
    {
      mesh: handleMesh(),
      axis: new THREE.Vector3(1, 0, 0),
      place: (region) => {
        const [x, y, z] = centerOf(region);
        return [x + (region.kind === "ball" ? region.radius : 0), y, z];
      },
      dragged: (region, to) => (region.kind === "ball" ? { ...region, radius: Math.max(0, to[0] - region.center[0]) } : region),
    },
  ];
}

export function handleMesh(isMiddle = false): THREE.Mesh {
  const mesh = new THREE.Mesh(
    isMiddle ? new THREE.OctahedronGeometry(1.25) : new THREE.SphereGeometry(1, 16, 12),
    // Transparent, to be drawn in front of everything, including wireframes.
    new THREE.MeshBasicMaterial({ color: isMiddle ? 0xffffff : color, depthTest: false, transparent: true }),
  );
  mesh.renderOrder = 4;
  mesh.layers.set(layers.overlay);
  return mesh;
}

export function lineMaterial(opacity = 0.9, depthTest = true): THREE.LineBasicMaterial {
  return new THREE.LineBasicMaterial({ color: color, transparent: true, opacity, depthTest });
}

function rings(): THREE.LineSegments {
  const ring = new THREE.EdgesGeometry(new THREE.CircleGeometry(1, 96));
  const all = mergeGeometries([ring, ring.clone().rotateX(Math.PI / 2), ring.clone().rotateY(Math.PI / 2)]);
  return new THREE.LineSegments(all, lineMaterial());
}

function middle(low: Vec3, high: Vec3): Vec3 {
  return low.map((value, axis) => (value + high[axis]) / 2) as Vec3;
}
