// The parts of a surface that is too large for a page: cubes with all samples near the eye, and with every second, fourth
// or eighth where others are farther away or out of sight.
import type { OctreeCube } from "../mesh/tile_mesh";
import type { ThresholdView } from "../protocol/messages";
import { applied, voxelLength } from "../stream/dataset";
import type { CrossedCells } from "./crossed_cells";
import { coarseSpacing } from "./level_extents";
import { LevelSamples } from "./level_samples";

export const tileCells = 64; // Along a tile's side, in its spacing.

export interface LevelCube {
  cube: OctreeCube;
  spacing: number; // 1, 2, 4 or 8.
}

const outOfSight = 8; // So much farther away it counts.
const growths = [-12, 3]; // Exponents of 2: spacings per voxel of distance.
const bisections = 12;

// Returns cubes that the surface crosses; those that touch differ at most by a factor of 2 in spacing. About `maxBricks` have
// another spacing than 8.
export function cubesByView(crossed: CrossedCells, view: ThresholdView, maxBricks: number, cells = tileCells): LevelCube[] {
  const tree = new CubeTree(crossed, cells);
  const distance = distanceTo(view, crossed);
  const near = Math.min(...crossed.cubes(tree.finest).map(distance));
  const pixel = (2 * view.tolerancePixels * Math.tan((view.fieldOfView * Math.PI) / 360)) / view.heightPixels;
  // Spacings grow with the distance from the nearest part, so that they differ in every view.
  const best = (growth: number) => tree.leaves((cube) => Math.max(pixel * distance(cube), growth * (distance(cube) - near)));
  const exact = best(0);
  if (exact.bricks <= maxBricks) return exact.leaves;
  let [low, high] = growths;
  let found = best(2 ** high);
  for (let i = 0; i < bisections; ++i) {
    const middle = (low + high) / 2;
    const next = best(2 ** middle);
    if (next.bricks <= maxBricks) [found, high] = [next, middle];
    else low = middle;
  }
  return found.leaves;
}

// Returns the finer ones of these cubes that touch a cube, by the cubes' keys.
export function finerBeside({ cube, spacing }: LevelCube, leaves: ReadonlyMap<string, LevelCube>): OctreeCube[] {
  const found: OctreeCube[] = [];
  if (spacing === 1) return found;
  const { exponent, x, y, z } = cube;
  for (let k = 2 * z - 1; k <= 2 * z + 2; ++k) {
    for (let j = 2 * y - 1; j <= 2 * y + 2; ++j) {
      for (let i = 2 * x - 1; i <= 2 * x + 2; ++i) {
        const beside = leaves.get(keyOf({ exponent: exponent - 1, x: i, y: j, z: k }));
        if (beside && beside.spacing < spacing) found.push(beside.cube);
      }
    }
  }
  return found;
}

export function keyOf({ exponent, x, y, z }: OctreeCube): string {
  return `${exponent} ${x} ${y} ${z}`;
}

function parentOf({ exponent, x, y, z }: OctreeCube, levels: number): OctreeCube {
  return { exponent: exponent + levels, x: x >> levels, y: y >> levels, z: z >> levels };
}

// The cubes that a surface crosses, of all spacings.
class CubeTree {
  private readonly roots: OctreeCube[];
  private readonly bricks = new Map<string, number>(); // In each cube, by its key; those in several count in one.
  readonly finest: number; // Exponents.
  private readonly coarsest: number;

  constructor(crossed: CrossedCells, cells: number) {
    this.coarsest = Math.min(crossed.volume.info.gridExponent, Math.log2(cells * coarseSpacing));
    this.finest = Math.max(Math.log2(coarseSpacing), Math.min(Math.log2(cells), this.coarsest - Math.log2(coarseSpacing)));
    this.roots = crossed.cubes(this.coarsest);
    const samples = new LevelSamples(crossed, 1);
    const counted = new Set<number>();
    for (const cube of crossed.cubes(this.finest)) {
      const before = counted.size;
      for (const brick of samples.bricks(cube)) counted.add(brick);
      const count = counted.size - before;
      for (let up = 0; this.finest + up <= this.coarsest; ++up) {
        const key = keyOf(parentOf(cube, up));
        this.bricks.set(key, (this.bricks.get(key) ?? 0) + count);
      }
    }
  }

  // Returns cubes that are as fine as `spacingAt` permits, or finer beside others.
  leaves(spacingAt: (cube: OctreeCube) => number): { leaves: LevelCube[]; bricks: number } {
    const leaves = new Map<string, LevelCube>();
    const add = (cube: OctreeCube): void => {
      const spacing = 2 ** (cube.exponent - this.finest);
      if (spacing > 1 && spacing > spacingAt(cube)) this.octants(cube).forEach(add);
      else leaves.set(keyOf(cube), { cube, spacing });
    };
    this.roots.forEach(add);
    this.balance(leaves);
    const all = [...leaves.values()];
    const isRead = ({ spacing }: LevelCube) => spacing < coarseSpacing;
    return { leaves: all, bricks: all.filter(isRead).reduce((sum, { cube }) => sum + this.bricks.get(keyOf(cube))!, 0) };
  }

  private balance(leaves: Map<string, LevelCube>): void {
    const queue = [...leaves.values()];
    for (let leaf = queue.pop(); leaf; leaf = queue.pop()) {
      const { exponent, x, y, z } = leaf.cube;
      for (let i = 0; i < 27; ++i) {
        const beside = { exponent, x: x + (i % 3) - 1, y: y + (Math.floor(i / 3) % 3) - 1, z: z + Math.floor(i / 9) - 1 };
        for (let up = this.coarsest - exponent; up >= 2; --up) {
          const coarse = parentOf(beside, up);
          if (!leaves.delete(keyOf(coarse))) continue;
          for (const cube of this.octants(coarse)) {
            const half = { cube, spacing: 2 ** (cube.exponent - this.finest) };
            leaves.set(keyOf(cube), half);
            queue.push(half);
          }
        }
      }
    }
  }

  // Those with a crossed cell.
  private octants({ exponent, x, y, z }: OctreeCube): OctreeCube[] {
    const all = Array.from({ length: 8 }, (_, i) => ({ exponent: exponent - 1, x: 2 * x + (i & 1), y: 2 * y + ((i >> 1) & 1), z: 2 * z + (i >> 2) }));
    return all.filter((cube) => this.bricks.has(keyOf(cube)));
  }
}

// Returns the distance from the eye to a cube in voxels, larger out of sight.
function distanceTo({ eye, fieldOfView, frustum }: ThresholdView, { volume: { info } }: CrossedCells): (cube: OctreeCube) => number {
  const minus = (a: readonly number[], b: readonly number[]) => a.map((at, axis) => at - b[axis]);
  const ahead = minus(frustum?.lookAt ?? eye, eye);
  const halfAngle = Math.atan(Math.tan((fieldOfView * Math.PI) / 360) * Math.hypot(1, frustum?.aspect || 1));
  const longest = Math.max(...info.spacing);
  return ({ exponent, x, y, z }) => {
    const side = 2 ** exponent;
    const center = applied(
      info.indexToWorld,
      [x, y, z].map((at) => (at + 0.5) * side - info.margin),
    );
    const way = minus(center, eye);
    const [far, radius] = [Math.hypot(...way), (Math.sqrt(3) / 2) * side * longest];
    if (far <= radius) return 0;
    const cosine = way.reduce((sum, at, axis) => sum + at * ahead[axis], 0) / far / Math.hypot(...ahead);
    const isSeen = Math.hypot(...ahead) === 0 || Math.acos(Math.min(1, Math.max(-1, cosine))) - Math.asin(radius / far) <= halfAngle;
    return ((far - radius) / voxelLength(info)) * (isSeen ? 1 : outOfSight);
  };
}
