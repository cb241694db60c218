// Handles of the clip plane: its outline on the box of the data, a handle at its center that moves it along its normal,
// and another one that rotates it around the first like a trackball.
import * as THREE from "three";

import type { DatasetInfo } from "../protocol/messages";
import type { Settings } from "../state/settings";
import { type Vec3, worldBox } from "../stream/dataset";
import { clipPlane, cutNormal, movedCut, rotatedCut } from "./cut_plane";
import { HandleDragging, handleMesh, lineMaterial } from "./handle_dragging";
import { layers } from "./layers";
import { cutCorners, perpendicularTo } from "./slice_grid";
import type { Stage } from "./stage";

type Shown = Pick<Settings, "clip" | "clipAt" | "clipFlipped" | "clipNormal">;

interface Grabbed {
  isTurning: boolean;
  x: number; // The pointer's start, in CSS pixels.
  y: number;
  normal: THREE.Vector3;
  middle: THREE.Vector3;
  isFlipped: boolean;
}

const armLength = 64; // CSS pixels between the handles.

export class CutHandles {
  private readonly group = new THREE.Group();
  private readonly dragging: HandleDragging;
  private readonly mover = handleMesh(true);
  private readonly turner = handleMesh();
  private readonly lines = new THREE.LineSegments(new THREE.BufferGeometry(), lineMaterial());
  private shown: Shown | null = null; // Null: no clipping.
  private info: DatasetInfo | null = null;
  private middle = new THREE.Vector3(); // The central handle, on the plane.
  private outline: THREE.Vector3[] = []; // Two places per line.
  private grabbed: Grabbed | null = null;

  constructor(
    private readonly stage: Stage,
    canvas: HTMLCanvasElement,
    private readonly changed: (changes: Partial<Settings>, isDragging: boolean) => void,
  ) {
    this.group.visible = false;
    this.lines.layers.set(layers.overlay);
    this.lines.frustumCulled = false;
    this.group.add(this.lines, this.mover, this.turner);
    stage.scene.add(this.group);
    this.dragging = new HandleDragging(stage, canvas, {
      handles: () => (this.shown ? [this.mover, this.turner] : []),
      grab: (handle, event) => this.grab(handle === this.turner, event),
      drag: (event, isDragging) => this.drag(event, this.grabbed!, isDragging),
    });
    stage.whenDrawn(() => this.place());
  }

  get isGrabbed(): boolean {
    return this.dragging.isGrabbed;
  }

  show({ clip, clipAt, clipFlipped, clipNormal }: Shown, info: DatasetInfo | null): void {
    const isOtherPlace = info?.name !== this.info?.name;
    const now = clip === "off" || !info ? null : { clip, clipAt, clipFlipped, clipNormal };
    if (!isOtherPlace && JSON.stringify(now) === JSON.stringify(this.shown)) return;
    const isNew = isOtherPlace || !this.shown;
    this.shown = now;
    this.info = info;
    this.group.visible = now !== null;
    if (now && info) this.follow(now, info, isNew);
    this.place();
    this.stage.invalidate();
  }

  // Keeps the central handle close to its previous place.
  private follow(shown: Shown, info: DatasetInfo, isNew: boolean): void {
    const { low, high } = worldBox(info);
    if (isNew)
      this.middle
        .set(...low)
        .add(new THREE.Vector3(...high))
        .multiplyScalar(0.5);
    const plane = clipPlane({ ...shown, clipFlipped: false }, info)!;
    plane.projectPoint(this.middle.clone(), this.middle);
    const normal = plane.normal.toArray();
    const corners = cutCorners(low, high, normal, -plane.constant);
    const [right, down] = perpendicularTo(normal).map((side) => new THREE.Vector3(...side));
    const center = corners.reduce((sum, corner) => sum.add(new THREE.Vector3(...corner)), new THREE.Vector3()).divideScalar(Math.max(1, corners.length));
    const around = corners
      .map((corner) => new THREE.Vector3(...corner))
      .map((place) => {
        const from = place.clone().sub(center);
        return { place, angle: Math.atan2(from.dot(down), from.dot(right)) };
      })
      .sort((a, b) => a.angle - b.angle);
    this.outline = around.flatMap(({ place }, i) => [place, around[(i + 1) % around.length].place]);
  }

  // Handles have a constant size and distance on the screen; the second one lies farthest to the right or up in the
  // plane.
  private place(): void {
    if (!this.shown) return;
    const normal = new THREE.Vector3(...cutNormal(this.shown)!);
    const sides = this.axesOfCamera().map((side) => side.projectOnPlane(normal));
    const side = sides[0].lengthSq() > 0.25 ? sides[0] : sides[1];
    this.mover.position.copy(this.middle);
    this.turner.position.copy(this.middle).addScaledVector(side.normalize(), armLength * this.stage.worldLengthAt(this.middle));
    this.dragging.keepSize();
    this.lines.geometry.dispose();
    // The GPU's 32-bit numbers count from the plane's center.
    const places = [...this.outline, this.mover.position, this.turner.position].map((place) => place.clone().sub(this.middle));
    this.lines.position.copy(this.middle);
    this.lines.geometry = new THREE.BufferGeometry().setFromPoints(places);
  }

  private grab(isTurning: boolean, event: PointerEvent): void {
    if (!this.shown) return;
    this.grabbed = {
      isTurning,
      x: event.offsetX,
      y: event.offsetY,
      normal: new THREE.Vector3(...cutNormal(this.shown)!),
      middle: this.middle.clone(),
      isFlipped: this.shown.clipFlipped,
    };
  }

  private drag(event: PointerEvent, grabbed: Grabbed, isDragging: boolean): void {
    const { info } = this;
    if (!info) return;
    const [x, y] = [event.offsetX - grabbed.x, event.offsetY - grabbed.y];
    const { normal, middle } = grabbed;
    const along = normal.toArray();
    if (grabbed.isTurning) {
      if (isDragging && x === 0 && y === 0) return;
      const [right, up] = this.axesOfCamera().map((axis) => axis.toArray());
      return this.changed(rotatedCut(trackballRotation(along, right, up, x, y), middle.toArray(), grabbed.isFlipped, info), isDragging);
    }
    const place = middle.clone().addScaledVector(normal, this.along(grabbed, x, y));
    this.changed(movedCut(along, place.toArray(), info), isDragging);
  }

  // Right and up in the picture.
  private axesOfCamera(): THREE.Vector3[] {
    const { quaternion } = this.stage.camera;
    return [new THREE.Vector3(1, 0, 0), new THREE.Vector3(0, 1, 0)].map((axis) => axis.applyQuaternion(quaternion));
  }

  // Returns the distance along the normal for a pointer movement. When looking along the normal, up is away.
  private along({ normal, middle }: Grabbed, x: number, y: number): number {
    const unit = this.stage.worldLengthOf(1);
    const from = this.stage.project(middle);
    const to = this.stage.project(middle.clone().addScaledVector(normal, 20 * unit));
    const [u, v] = from && to ? [(to.x - from.x) / 20, (to.y - from.y) / 20] : [0, 0];
    if (Math.hypot(u, v) >= 0.25) return (unit * (x * u + y * v)) / (u * u + v * v);
    const ahead = this.stage.camera.getWorldDirection(new THREE.Vector3());
    return -y * unit * Math.sign(ahead.dot(normal) || 1);
  }
}

// Rotates a direction like a trackball around the axes `right` and `up`, for a movement in CSS pixels right and down.
export function trackballRotation(direction: Vec3, right: Vec3, up: Vec3, x: number, y: number): Vec3 {
  const axis = new THREE.Vector3(...up)
    .multiplyScalar(x)
    .addScaledVector(new THREE.Vector3(...right), y)
    .normalize();
  return new THREE.Vector3(...direction)
    .applyAxisAngle(axis, Math.hypot(x, y) / 120)
    .normalize()
    .toArray();
}
