// The samples of a uniform level in octree cubes, of the bricks that the surface crosses alone: what
// server/extraction/detail/level_samples.cpp does for sample shells.
//
// Every crossed edge lies in a closed cell of 8 grid steps whose range has values on both sides of the isovalue. Bricks
// that touch no such cell are not read: their samples get any value on the same side, or are void where others are.
import type { PlainBox } from "../mesh/plain_box";
import type { OctreeCube } from "../mesh/tile_mesh";
import type { Vec3 } from "../stream/dataset";
import { cellExtent, coarseExtent, coarseSpacing, type Extent, indexIn } from "./level_extents";
import type { PreparedVolume } from "./prepared_file";
import { arrayType, type SampleArray } from "./sample_array";
import { brickSide } from "./sample_bricks";

export const shellCells = 64; // Cells of the level along a tile's side.

type Box = Pick<PlainBox, "layers"> & { first: Vec3; last: Vec3 }; // Samples of the data, in spacings.
type Cells = { first: Vec3; last: Vec3 };

export class LevelSamples {
  private readonly cells: Extent;
  private readonly crossed: Uint8Array; // By cell.

  // `spacing`: 1, 2, 4 or 8.
  constructor(
    private readonly volume: PreparedVolume,
    private readonly isovalue: number,
    readonly spacing: number,
  ) {
    this.cells = cellExtent(volume.info);
    this.crossed = this.findCrossed();
  }

  // Returns the number of crossed cells in the cubes.
  crossedCells(cubes: readonly OctreeCube[]): number {
    let count = 0;
    for (const cube of cubes) this.visit(cellsOf(cube), () => ++count < 0);
    return count;
  }

  // Returns the cubes that the surface crosses.
  cubes(): OctreeCube[] {
    const exponent = Math.min(this.volume.info.gridExponent, Math.log2(shellCells * this.spacing));
    const side = 2 ** exponent / coarseSpacing; // In cells.
    const found = new Map<string, OctreeCube>();
    const { low, count } = this.cells;
    this.visit({ first: [low, low, low], last: count.map((n) => low + n - 1) as Vec3 }, (x, y, z) => {
      const [i, j, k] = [x, y, z].map((cell) => Math.floor(cell / side));
      found.set(`${i} ${j} ${k}`, { exponent, x: i, y: j, z: k });
      return false;
    });
    return [...found.values()];
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

  // Cells beyond the data have the value outside, too.
  private findCrossed(): Uint8Array {
    const { info, ranges } = this.volume;
    const { low, count } = this.cells;
    const crossed = new Uint8Array(count[0] * count[1] * count[2]);
    const isBeyond = (cell: number, axis: number) => coarseSpacing * cell < info.margin || coarseSpacing * (cell + 1) > info.margin + info.dims[axis] - 1;
    const outside = info.outside === undefined ? undefined : Math.fround(info.outside);
    let i = 0;
    for (let z = low; z < low + count[2]; ++z) {
      for (let y = low; y < low + count[1]; ++y) {
        const isRowBeyond = isBeyond(z, 2) || isBeyond(y, 1);
        for (let x = low; x < low + count[0]; ++x, ++i) {
          let least = ranges[2 * i];
          let greatest = ranges[2 * i + 1];
          if (!(least <= greatest)) continue; // All are void.
          if (outside !== undefined && (isRowBeyond || isBeyond(x, 0))) {
            least = Math.min(least, outside);
            greatest = Math.max(greatest, outside);
          }
          crossed[i] = !(least > this.isovalue) && greatest > this.isovalue ? 1 : 0;
        }
      }
    }
    return crossed;
  }

  // Visits crossed cells until `act` returns true; returns whether it did.
  private visit({ first, last }: Cells, act: (x: number, y: number, z: number) => boolean): boolean {
    const { low, count } = this.cells;
    const [from, to] = [first.map((at) => Math.max(at, low)), last.map((at, axis) => Math.min(at, low + count[axis] - 1))];
    for (let z = from[2]; z <= to[2]; ++z) {
      for (let y = from[1]; y <= to[1]; ++y) {
        const row = indexIn(this.cells, 0, y, z);
        for (let x = from[0]; x <= to[0]; ++x) if (this.crossed[row + x] && act(x, y, z)) return true;
      }
    }
    return false;
  }

  // Returns the samples around the crossed cells of the cube; null: no cell with a value at all corners.
  private crossedPart(cube: OctreeCube): Box | null {
    const whole = this.levelBox(cube);
    if (!whole) return null;
    const found: Cells = { first: [Infinity, Infinity, Infinity], last: [-Infinity, -Infinity, -Infinity] };
    this.visit(cellsOf(cube), (...cell) => {
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
    const { info, ranges } = this.volume;
    if (info.voidSamples > 0n) return Number.NaN;
    const { last } = cellsOf(cube);
    const cell = point.map((at, axis) => Math.min(Math.floor((at * this.spacing) / coarseSpacing), last[axis])) as Vec3;
    return ranges[2 * indexIn(this.cells, ...cell)];
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
    return this.visit(around, () => true);
  }
}

// The cells of 8 grid steps in a cube of at least that side.
function cellsOf({ exponent, x, y, z }: OctreeCube): Cells {
  const side = Math.max(1, 2 ** exponent / coarseSpacing);
  return { first: [x * side, y * side, z * side], last: [(x + 1) * side - 1, (y + 1) * side - 1, (z + 1) * side - 1] };
}
