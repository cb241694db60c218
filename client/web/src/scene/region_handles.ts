// A region in the scene: a box or a ball with draggable handles. A box's faces move along their
// axis, a ball's outer handle changes its radius, and the center moves the whole region.
import * as THREE from "three";
import { mergeGeometries } from "three/examples/jsm/utils/BufferGeometryUtils.js";

import type { BallRegion, BoxRegion, Region } from "../state/settings";
import type { Vec3 } from "../stream/dataset";
import { disposeTree } from "./dispose_tree";
import { HandleDragging, handleColor, handleMesh, lineMaterial } from "./handle_dragging";
import { layers } from "./layers";
import type { Stage } from "./stage";

interface Handle<Shape = Region> {
  mesh: THREE.Mesh;
  axis: THREE.Vector3 | null; // Null: moves in the view plane.
  place(region: Shape): Vec3;
  dragged(region: Shape, to: Vec3): Shape;
}

export class RegionHandles {
  private readonly group = new THREE.Group();
  private readonly dragging: HandleDragging;
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
    this.dragging = new HandleDragging(stage, canvas, {
      handles: () => this.handles.map(({ mesh }) => mesh),
      grab: (mesh, event) => this.grab(this.handles.find((one) => one.mesh === mesh)!, event),
      drag: (event, isDragging) => (isDragging ? this.drag(event) : this.region && this.changed(this.region, false)),
    });
    stage.whenDrawn(() => this.dragging.keepSize());
  }

  get isGrabbed(): boolean {
    return this.dragging.isGrabbed;
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
      new THREE.MeshBasicMaterial({ color: handleColor, transparent: true, opacity: 0.1, depthWrite: false, side: THREE.DoubleSide }),
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
    this.handles = (this.region.kind === "box" ? boxHandles() : ballHandles()) as Handle[]; // Of the same kind as the region.
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
    this.dragging.keepSize();
  }

  private grab(handle: Handle, event: PointerEvent): void {
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

function boxHandles(): Handle<BoxRegion>[] {
  const ofFace = (axis: number, side: "low" | "high"): Handle<BoxRegion> => ({
    mesh: handleMesh(),
    axis: new THREE.Vector3().setComponent(axis, 1),
    place: (region) => {
      const at = middle(region.low, region.high);
      at[axis] = region[side][axis];
      return at;
    },
    dragged: (region, to) => {
      const moved = [...region[side]] as Vec3;
      moved[axis] = side === "low" ? Math.min(to[axis], region.high[axis]) : Math.max(to[axis], region.low[axis]);
      return { ...region, [side]: moved };
    },
  });
  const whole: Handle<BoxRegion> = {
    mesh: handleMesh(true),
    axis: null,
    place: ({ low, high }) => middle(low, high),
    dragged: (region, to) => {
      const at = middle(region.low, region.high);
      const moved = (corner: Vec3) => corner.map((v, i) => v + to[i] - at[i]) as Vec3;
      return { ...region, low: moved(region.low), high: moved(region.high) };
    },
  };
  return [...[0, 1, 2].flatMap((axis) => [ofFace(axis, "low"), ofFace(axis, "high")]), whole];
}

function ballHandles(): Handle<BallRegion>[] {
  return [
    { mesh: handleMesh(true), axis: null, place: ({ center }) => center, dragged: (region, to) => ({ ...region, center: to }) },
    {
      mesh: handleMesh(),
      axis: new THREE.Vector3(1, 0, 0),
      place: ({ center: [x, y, z], radius }) => [x + radius, y, z],
      dragged: (region, to) => ({ ...region, radius: Math.max(0, to[0] - region.center[0]) }),
    },
  ];
}

function rings(): THREE.LineSegments {
  const ring = new THREE.EdgesGeometry(new THREE.CircleGeometry(1, 96));
  const all = mergeGeometries([ring, ring.clone().rotateX(Math.PI / 2), ring.clone().rotateY(Math.PI / 2)]);
  return new THREE.LineSegments(all, lineMaterial());
}

function middle(low: Vec3, high: Vec3): Vec3 {
  return low.map((value, axis) => (value + high[axis]) / 2) as Vec3;
}
