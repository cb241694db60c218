// A click on the surface tells the place in world coordinates and samples; the next one measures the
// distance. Escape, or the cross, forgets both; a click beside the surface means nothing.
import * as THREE from "three";

import { counted, h, inDigits } from "../panel/dom";
import type { HalfSpace } from "../mesh/ray";
import type { DatasetInfo } from "../protocol/messages";
import {
  type Affine, applied, inverse, latticeToIndex, latticeToWorld, lengthText, type Vec3, voxelLength, worldName,
} from "../stream/dataset";
import type { ShownSurface } from "../shown_surface";
import type { TilePool } from "../workers/tile_pool";
import type { Stage } from "./stage";

interface Picked {
  world: Vec3;
  index: Vec3;
}

export class Picking {
  readonly element = h("div", { class: "picked", hidden: true, "aria-live": "polite" });
  readonly labels = h("div", { class: "pick-labels", "aria-hidden": "true" });
  private picks: Picked[] = [];
  private readonly dots: HTMLElement[] = [];
  private readonly line: THREE.Line;
  private press: { x: number; y: number } | null = null;

  constructor(
    private readonly stage: Stage,
    private readonly canvas: HTMLCanvasElement,
    private readonly pool: TilePool,
    private readonly shown: () => {
      surface: ShownSurface;
      ids: readonly string[];
      clip: THREE.Plane | null;
    } | null,
    private readonly isBusy: () => boolean,
  ) {
    this.line = new THREE.Line(
      new THREE.BufferGeometry(),
      new THREE.LineBasicMaterial({ color: 0xffd24a, depthTest: false }),
    );
    this.line.renderOrder = 5;
    this.line.frustumCulled = false;
    stage.scene.add(this.line);
    canvas.addEventListener("pointerdown", (event) => {
      this.press = event.button === 0 && !isBusy() ? { x: event.offsetX, y: event.offsetY } : null;
    });
    canvas.addEventListener("pointerup", (event) => {
      const { press } = this;
      this.press = null;
      if (!press || this.isBusy()) return;
      if (Math.hypot(press.x - event.offsetX, press.y - event.offsetY) > 4) return;
      void this.pick(event.offsetX, event.offsetY);
    });
    stage.whenDrawn(() => this.follow());
  }

  forget(): void {
    this.picks = [];
    this.tell();
  }

  private async pick(x: number, y: number): Promise<void> {
    const shown = this.shown();
    if (!shown) return;
    const { info, resolution } = shown.surface;
    const ray = this.stage.rayAt(x, y);
    const toWorld = latticeToWorld(info, resolution);
    const back = inverse(toWorld);
    const origin = applied(back, ray.origin.toArray());
    const ahead = applied(back, ray.origin.clone().add(ray.direction).toArray());
    const direction = ahead.map((value, axis) => value - origin[axis]);
    const kept = shown.clip && inLattice(shown.clip, toWorld);
    const hit = await this.pool.pick([...shown.ids], { origin, direction, kept }).catch(() => null);
    if (!hit) return;
    if (this.picks.length === 2) this.picks = [];
    this.picks.push({
      world: applied(toWorld, hit.point),
      index: applied(latticeToIndex(info, resolution), hit.point),
    });
    this.tell(info);
  }

  private tell(info: DatasetInfo | null = null): void {
    const [a, b] = this.picks;
    this.element.hidden = !a;
    this.labels.replaceChildren();
    this.dots.length = 0;
    if (a) {
      const place = (name: string, { world, index }: Picked) =>
        h("p", {}, h("b", {}, name), ` ${worldName(info!)} ${world.map((v) => inDigits(v, 5)).join(", ")}`,
          h("span", {}, ` sample ${index.map((v) => v.toFixed(1)).join(", ")}`));
      const close = h("button", { type: "button", "aria-label": "Forget the picked points" }, "×");
      close.addEventListener("click", () => {
        this.forget();
        this.canvas.focus();
      });
      this.element.replaceChildren(close, place("A", a), ...(b ? [place("B", b)] : []));
      const distance = b ? Math.hypot(...a.world.map((v, i) => v - b.world[i])) : 0;
      this.element.append(
        b
          ? h("p", { class: "distance" }, `A to B: ${lengthText(distance, info!, 4)}`,
              h("span", {}, ` (${counted(distance / voxelLength(info!), "voxel", 4)})`))
          : h("p", { class: "hint" }, "Click another point to measure."),
      );
      for (const name of b ? ["A", "B"] : ["A"]) {
        const dot = h("span", { class: "dot" }, name);
        this.dots.push(dot);
        this.labels.append(dot);
      }
    }
    this.line.visible = Boolean(b);
    if (b) this.line.geometry.setFromPoints([new THREE.Vector3(...a.world), new THREE.Vector3(...b.world)]);
    this.stage.invalidate();
  }

  private follow(): void {
    this.picks.forEach(({ world }, i) => {
      const at = this.stage.project(new THREE.Vector3(...world));
      this.dots[i].hidden = !at;
      if (at) this.dots[i].style.transform = `translate(${at.x}px, ${at.y}px)`;
    });
  }
}

// The half-space of the world that a plane keeps, in the coordinates that `toWorld` starts from.
function inLattice({ normal, constant }: THREE.Plane, toWorld: Affine): HalfSpace {
  const n = normal.toArray();
  const dot = (at: number) => n[0] * toWorld[at] + n[1] * toWorld[at + 1] + n[2] * toWorld[at + 2];
  return { normal: [dot(0), dot(3), dot(6)], constant: dot(9) + constant };
}
