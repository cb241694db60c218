// Picks places on surfaces and slices: of the places under the pointer that are not clipped, the most visible one.
// Clicks that miss do nothing.
import type * as THREE from "three";

import type { HalfSpace } from "../mesh/ray";
import type { DatasetInfo } from "../protocol/messages";
import { type Affine, applied, inverse, latticeToIndex, latticeToWorld, type Vec3 } from "../stream/dataset";
import type { ShownTiles } from "../surfaces/shown_surface";
import type { TilePool } from "../workers/tile_pool";
import type { Hit } from "../workers/worker_messages";
import type { Stage } from "./stage";

export interface Picked {
  world: Vec3;
  index: Vec3; // In samples.
  info: DatasetInfo;
  surface: { tiles: ShownTiles; hit: Hit } | null; // Null: on the slice.
}

export interface Pickable {
  info: DatasetInfo | null; // The dataset of the slice's samples.
  tiles: ShownTiles[];
  clip: readonly THREE.Plane[]; // The half-spaces that remain visible.
  slice: (ray: THREE.Ray) => Vec3 | null;
}

export class Picking {
  private press: { x: number; y: number } | null = null;

  constructor(
    private readonly stage: Stage,
    canvas: HTMLCanvasElement,
    private readonly pool: TilePool,
    private readonly shown: () => Pickable,
    private readonly isBusy: () => boolean,
    private readonly picked: (place: Picked) => void,
  ) {
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
  }

  // `x` and `y`: CSS pixels from the canvas's corner.
  async pick(x: number, y: number): Promise<void> {
    const found = await this.find(x, y);
    if (found) this.picked(found);
  }

  // Returns the most visible place; null: nothing is there.
  async find(x: number, y: number): Promise<Picked | null> {
    const { tiles, clip, info, slice } = this.shown();
    const ray = this.stage.rayAt(x, y);
    const onSlice = info && slice(ray);
    const found = await Promise.all(tiles.map((one) => this.hitOf(one, ray, clip)));
    const hits = found.filter((one) => one !== null);
    if (onSlice) hits.push({ world: onSlice, index: applied(inverse(info.indexToWorld), onSlice), info, surface: null });
    const distance = ({ world }: Picked) => Math.hypot(...world.map((v, i) => v - ray.origin.toArray()[i]));
    hits.sort((a, b) => distance(a) - distance(b));
    return mostVisible(hits.map((place) => ({ place, opacity: place.surface?.tiles.opacity ?? 1 })));
  }

  private async hitOf(tiles: ShownTiles, ray: THREE.Ray, clip: readonly THREE.Plane[]): Promise<Picked | null> {
    const { info, resolution } = tiles.shown;
    const toWorld = latticeToWorld(info, resolution);
    const back = inverse(toWorld);
    const origin = applied(back, ray.origin.toArray());
    const ahead = applied(back, ray.origin.clone().add(ray.direction).toArray());
    const direction = ahead.map((value, axis) => value - origin[axis]);
    const halfSpaces = clip.map((plane) => halfSpaceInLattice(plane, toWorld));
    const hit = await this.pool.call("pick", tiles.drawn, { origin, direction, clip: halfSpaces }).catch(() => null);
    return (
      hit && {
        world: applied(toWorld, hit.point),
        index: applied(latticeToIndex(info, resolution), hit.point),
        info,
        surface: { tiles, hit },
      }
    );
  }
}

// Returns the place with the largest contribution to the pixel's color, so that clicks pass through nearly transparent
// surfaces. Requires places sorted from near to far. Null: there is none.
export function mostVisible<Place>(hits: { place: Place; opacity: number }[]): Place | null {
  let best: Place | null = null;
  let largest = 0;
  let light = 1; // The light that passes the previous places.
  for (const { place, opacity } of hits) {
    if (light * opacity > largest) {
      best = place;
      largest = light * opacity;
    }
    light *= 1 - opacity;
  }
  return best;
}

// Returns a plane's half-space in the source coordinates of `toWorld`.
export function halfSpaceInLattice({ normal, constant }: THREE.Plane, toWorld: Affine): HalfSpace {
  const n = normal.toArray();
  const dot = (at: number) => n[0] * toWorld[at] + n[1] * toWorld[at + 1] + n[2] * toWorld[at + 2];
  return { normal: [dot(0), dot(3), dot(6)], constant: dot(9) + constant };
}
