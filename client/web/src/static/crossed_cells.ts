// The closed cells of 8 grid steps whose range has values on both sides of the isovalue. Every crossed edge of any spacing up
// to 8 lies in one, so other cells need no samples.
import type { OctreeCube } from "../mesh/tile_mesh";
import type { Vec3 } from "../stream/dataset";
import { cellExtent, coarseSpacing, type Extent, indexIn } from "./level_extents";
import type { PreparedVolume } from "./prepared_file";

export type Cells = { first: Vec3; last: Vec3 };

export class CrossedCells {
  private readonly extent: Extent;
  private readonly crossed: Uint8Array; // By cell.

  constructor(
    readonly volume: PreparedVolume,
    readonly isovalue: number,
  ) {
    this.extent = cellExtent(volume.info);
    this.crossed = this.find();
  }

  // Visits crossed cells until `act` returns true; returns whether it did.
  visit({ first, last }: Cells, act: (x: number, y: number, z: number) => boolean): boolean {
    const { low, count } = this.extent;
    const [from, to] = [first.map((at) => Math.max(at, low)), last.map((at, axis) => Math.min(at, low + count[axis] - 1))];
    for (let z = from[2]; z <= to[2]; ++z) {
      for (let y = from[1]; y <= to[1]; ++y) {
        const row = indexIn(this.extent, 0, y, z);
        for (let x = from[0]; x <= to[0]; ++x) if (this.crossed[row + x] && act(x, y, z)) return true;
      }
    }
    return false;
  }

  // Returns the number of those in the cubes.
  countIn(cubes: readonly OctreeCube[]): number {
    let count = 0;
    for (const cube of cubes) this.visit(cellsOf(cube), () => ++count < 0);
    return count;
  }

  // Returns the cubes of 2^exponent grid steps, at least 8, that contain some.
  cubes(exponent: number): OctreeCube[] {
    const side = 2 ** exponent / coarseSpacing; // In cells.
    const found = new Map<string, OctreeCube>();
    const { low, count } = this.extent;
    this.visit({ first: [low, low, low], last: count.map((n) => low + n - 1) as Vec3 }, (x, y, z) => {
      const [i, j, k] = [x, y, z].map((cell) => Math.floor(cell / side));
      found.set(`${i} ${j} ${k}`, { exponent, x: i, y: j, z: k });
      return false;
    });
    return [...found.values()];
  }

  leastIn(cell: Vec3): number {
    return this.volume.ranges[2 * indexIn(this.extent, ...cell)];
  }

  // Cells beyond the data have the value outside, too.
  private find(): Uint8Array {
    const { info, ranges } = this.volume;
    const { low, count } = this.extent;
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
}

// The cells in a cube of at least their side.
export function cellsOf({ exponent, x, y, z }: OctreeCube): Cells {
  const side = Math.max(1, 2 ** exponent / coarseSpacing);
  return { first: [x * side, y * side, z * side], last: [(x + 1) * side - 1, (y + 1) * side - 1, (z + 1) * side - 1] };
}
