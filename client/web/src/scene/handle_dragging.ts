// Meshes in the scene that the pointer drags, before the camera's controls receive it.
import * as THREE from "three";
import { layers } from "./layers";
import type { Stage } from "./stage";

export interface Dragging {
  handles: () => readonly THREE.Object3D[]; // Those that are shown.
  grab: (handle: THREE.Object3D, event: PointerEvent) => void;
  drag: (event: PointerEvent, isDragging: boolean) => void; // At the end with `isDragging` false.
}

const reach = 14; // CSS pixels around a handle that belong to it.
const radius = 7; // CSS pixels.
export const handleColor = 0x4fb3ff;

export class HandleDragging {
  isGrabbed = false;
  private isOver = false;

  constructor(
    private readonly stage: Stage,
    canvas: HTMLCanvasElement,
    private readonly dragging: Dragging,
  ) {
    canvas.addEventListener("pointerdown", (event) => this.grab(event), { capture: true });
    canvas.addEventListener("pointermove", (event) => {
      if (this.isGrabbed) return dragging.drag(event, true);
      const isOver = event.buttons === 0 && this.handleAt(event) !== null;
      if (isOver !== this.isOver) canvas.style.cursor = isOver ? "grab" : "";
      this.isOver = isOver;
    });
    const end = (event: PointerEvent) => {
      if (!this.isGrabbed) return;
      canvas.releasePointerCapture(event.pointerId);
      dragging.drag(event, false);
      this.isGrabbed = false;
      stage.controls.enabled = true;
    };
    canvas.addEventListener("pointerup", end);
    canvas.addEventListener("pointercancel", end);
  }

  // Gives the handles a constant size on the screen.
  keepSize(): void {
    for (const handle of this.dragging.handles()) handle.scale.setScalar(radius * this.stage.worldLengthAt(handle.position));
  }

  private grab(event: PointerEvent): void {
    const handle = event.button === 0 ? this.handleAt(event) : null;
    if (!handle) return;
    event.stopImmediatePropagation();
    (event.target as Element).setPointerCapture(event.pointerId);
    this.stage.controls.enabled = false;
    this.isGrabbed = true;
    this.dragging.grab(handle, event);
  }

  private handleAt({ offsetX, offsetY }: PointerEvent): THREE.Object3D | null {
    let nearest: THREE.Object3D | null = null;
    let least = reach;
    for (const handle of this.dragging.handles()) {
      const at = this.stage.project(handle.position);
      const distance = at ? Math.hypot(at.x - offsetX, at.y - offsetY) : Infinity;
      if (distance < least) [nearest, least] = [handle, distance];
    }
    return nearest;
  }
}

export function handleMesh(isMiddle = false): THREE.Mesh {
  const mesh = new THREE.Mesh(
    isMiddle ? new THREE.OctahedronGeometry(1.25) : new THREE.SphereGeometry(1, 16, 12),
    // Transparent, to be drawn in front of everything, including wireframes.
    new THREE.MeshBasicMaterial({ color: isMiddle ? 0xffffff : handleColor, depthTest: false, transparent: true }),
  );
  mesh.renderOrder = 4;
  mesh.layers.set(layers.overlay);
  return mesh;
}

export function lineMaterial(opacity = 0.9, depthTest = true): THREE.LineBasicMaterial {
  return new THREE.LineBasicMaterial({ color: handleColor, transparent: true, opacity, depthTest });
}
