// The samples of a uniform level in octree cubes, of the bricks that the surface crosses alone: what
// server/extraction/detail/level_samples.cpp does for sample shells.
//
// Bricks that touch no crossed cell are not read: their samples get any value on the same side, or are void where others are.
import type { PlainBox } from "../mesh/plain_box";
import type { OctreeCube } from "../mesh/tile_mesh";
import type { Vec3 } from "../stream/dataset";
import { arrayType, type SampleArray } from "../stream/sample_array";
import { type Cells, type CrossedCells, cellsOf } from "./crossed_cells";
import { coarseExtent, coarseSpacing, indexIn } from "./level_extents";
import type { PreparedVolume } from "./prepared_file";
import { brickSide } from "./sample_bricks";

type Box = Pick<PlainBox, "layers"> & { first: Vec3; last: Vec3 }; // Samples of the data, in spacings.

export class LevelSamples {
  private readonly volume: PreparedVolume;

  // `spacing`: 1, 2, 4 or 8.
  constructor(
    private readonly crossed: CrossedCells,
    readonly spacing: number,
  ) {
    this.volume = crossed.volume;
  }

  // Returns the bricks that read() needs.
  bricks(cube: OctreeCube): number[] {
    const bricks: number[] = [];
    const box = this.crossedPart(cube);
    if (box && this.spacing < coarseSpacing) this.visitBricks(cube, box, (brick, _, isNeeded) => isNeeded && bricks.push(brick));
    return bricks;
  }

  // Returns null if nothing is crossed.
  read(cube: OctreeCube, bricks: ReadonlyMap<number, SampleArray>): Pick<PlainBox, "samples" | "origin" | "count" | "layers"> | null {
    const box = this.crossedPart(cube);
    if (!box) return null;
    const size = box.first.map((first, axis) => box.last[axis] - first + 1) as Vec3;
    const samples = new (arrayType(this.volume.info.type))(size[0] * size[1] * size[2]);
    if (this.spacing === coarseSpacing) this.readCoarse(box, size, samples);
    else this.readBricks(cube, box, size, samples, bricks);
    const layer = (axis: number, high: number) => (box.layers >> (2 * axis + high)) & 1;
    const origin = box.first.map((first, axis) => first - layer(axis, 0)) as Vec3;
    const count = size.map((n, axis) => n + layer(axis, 0) + layer(axis, 1)) as Vec3;
    return { samples, origin, count, layers: box.layers };
  }

  // Returns the samples around the crossed cells of the cube; null: no cell with a value at all corners.
  private crossedPart(cube: OctreeCube): Box | null {
    const whole = this.levelBox(cube);
    if (!whole) return null;
    const found: Cells = { first: [Infinity, Infinity, Infinity], last: [-Infinity, -Infinity, -Infinity] };
    this.crossed.visit(cellsOf(cube), (...cell) => {
      cell.forEach((at, axis) => {
        found.first[axis] = Math.min(found.first[axis], at);
        found.last[axis] = Math.max(found.last[axis], at);
      });
      return false;
    });
    const perCell = coarseSpacing / this.spacing;
    const box: Box = { first: [0, 0, 0], last: [0, 0, 0], layers: 0 };
    for (let axis = 0; axis < 3; ++axis) {
      const [low, high] = [perCell * found.first[axis], perCell * (found.last[axis] + 1)];
      box.first[axis] = Math.max(whole.first[axis], low);
      box.last[axis] = Math.min(whole.last[axis], high);
      const bits = (low < box.first[axis] ? 1 : 0) | (high > box.last[axis] ? 2 : 0);
      const layers = (whole.layers >> (2 * axis)) & bits;
      box.layers |= layers << (2 * axis);
      if (!(box.last[axis] - box.first[axis] + 1 + (layers & 1) + (layers >> 1) >= 2)) return null;
    }
    return box;
  }

  // The cube's samples of the data, and the layers around it that close the surface.
  private levelBox({ exponent, x, y, z }: OctreeCube): Box | null {
    const { margin, dims, outside } = this.volume.info;
    const cells = 2 ** exponent / this.spacing;
    const box: Box = { first: [0, 0, 0], last: [0, 0, 0], layers: 0 };
    for (const [axis, at] of [x, y, z].entries()) {
      const [low, high] = [at * cells, (at + 1) * cells];
      const first = Math.max(low, Math.ceil(margin / this.spacing));
      const last = Math.min(high, Math.floor((margin + dims[axis] - 1) / this.spacing));
      if (last < first) return null;
      box.first[axis] = first;
      box.last[axis] = last;
      if (outside !== undefined) box.layers |= ((first > low ? 1 : 0) | (last < high ? 2 : 0)) << (2 * axis);
    }
    return box;
  }

  private readCoarse({ first }: Box, size: Vec3, into: SampleArray): void {
    const extent = coarseExtent(this.volume.info);
    let to = 0;
    for (let z = 0; z < size[2]; ++z) {
      for (let y = 0; y < size[1]; ++y) {
        const from = indexIn(extent, first[0], first[1] + y, first[2] + z);
        into.set(this.volume.coarse.subarray(from, from + size[0]), to);
        to += size[0];
      }
    }
  }

  private readBricks(cube: OctreeCube, box: Box, size: Vec3, into: SampleArray, unpacked: ReadonlyMap<number, SampleArray>): void {
    const { bricks, info } = this.volume;
    const { spacing } = this;
    this.visitBricks(cube, box, (brick, part, isNeeded) => {
      const samples = isNeeded ? unpacked.get(brick)! : null;
      const fill = samples ? 0 : this.valueBeside(cube, part.first);
      const origin = part.brick.map((at) => at * brickSide + info.margin);
      const [nx, ny] = bricks.extent(...part.brick);
      for (let z = part.first[2]; z <= part.last[2]; ++z) {
        for (let y = part.first[1]; y <= part.last[1]; ++y) {
          const to = part.first[0] - box.first[0] + size[0] * (y - box.first[1] + size[1] * (z - box.first[2]));
          const width = part.last[0] - part.first[0] + 1;
          const from = spacing * part.first[0] - origin[0] + nx * (spacing * y - origin[1] + ny * (spacing * z - origin[2]));
          if (!samples) into.fill(fill, to, to + width);
          else if (spacing === 1) into.set(samples.subarray(from, from + width), to);
          else for (let x = 0; x < width; ++x) into[to + x] = samples[from + spacing * x];
        }
      }
    });
  }

  // Returns the least sample of a cell with this point in the cube.
  private valueBeside(cube: OctreeCube, point: Vec3): number {
    if (this.volume.info.voidSamples > 0n) return Number.NaN;
    const { last } = cellsOf(cube);
    return this.crossed.leastIn(point.map((at, axis) => Math.min(Math.floor((at * this.spacing) / coarseSpacing), last[axis])) as Vec3);
  }

  private visitBricks(cube: OctreeCube, box: Box, act: (brick: number, part: { brick: Vec3; first: Vec3; last: Vec3 }, isNeeded: boolean) => void): void {
    const { bricks, info } = this.volume;
    const { spacing } = this;
    const brickOf = (at: number) => Math.floor((at * spacing - info.margin) / brickSide);
    const [low, high] = [box.first.map(brickOf), box.last.map(brickOf)];
    for (let z = low[2]; z <= high[2]; ++z) {
      for (let y = low[1]; y <= high[1]; ++y) {
        for (let x = low[0]; x <= high[0]; ++x) {
          const brick: Vec3 = [x, y, z];
          const begin = brick.map((at) => at * brickSide + info.margin);
          const first = begin.map((at, axis) => Math.max(Math.ceil(at / spacing), box.first[axis])) as Vec3;
          const last = begin.map((at, axis) => Math.min(Math.floor((at + brickSide - 1) / spacing), box.last[axis])) as Vec3;
          act(bricks.index(x, y, z), { brick, first, last }, this.touchesCrossed(cube, first, last));
        }
      }
    }
  }

  // Returns whether a crossed cell of the cube, including its border, has a sample from `first` to `last`.
  private touchesCrossed(cube: OctreeCube, first: Vec3, last: Vec3): boolean {
    const cells = cellsOf(cube);
    const around = {
      first: first.map((at, axis) => Math.max(Math.ceil((at * this.spacing) / coarseSpacing) - 1, cells.first[axis])) as Vec3,
      last: last.map((at, axis) => Math.min(Math.floor((at * this.spacing) / coarseSpacing), cells.last[axis])) as Vec3,
    };
    return this.crossed.visit(around, () => true);
  }
}
