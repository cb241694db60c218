// The levels of a volume: every eighth sample along each axis at first, then every fourth, every second and all, as far
// as the budget allows.
import type { DatasetInfo } from "../../protocol/messages";
import type { Vec3 } from "../../stream/dataset";
import type { SampleBox } from "../../stream/dataset_queries";
import type { SampleArray } from "../../stream/sample_array";

export interface Level {
  step: number; // Every step-th sample along each axis, from the first on.
  counts: Vec3; // Samples along each axis.
}

export const blockSide = 8; // Cells of a block, the unit in which empty space is skipped.
const firstStep = 8;
const soon = 1 << 17; // So few samples need no coarser ones before them.
const fast = 250; // Milliseconds of a level that is not small.
const slabSamples = 1 << 20;

export interface VolumeBudget {
  samples: number;
  side: number; // The longest side of a texture.
}

export function levelOf({ dims }: Pick<DatasetInfo, "dims">, step: number): Level {
  return { step, counts: dims.map((n) => Math.floor((n - 1) / step) + 1) as Vec3 };
}

// Returns the levels to show, coarsest first; the last is the finest within the budget.
export function levelsOf(info: Pick<DatasetInfo, "dims">, budget: VolumeBudget): Level[] {
  const fits = ({ counts }: Level) => samplesOf(counts) <= budget.samples && Math.max(...counts) <= budget.side;
  let coarsest = firstStep;
  while (!fits(levelOf(info, coarsest))) coarsest *= 2;
  const all: Level[] = [];
  for (let step = coarsest; step >= 1 && fits(levelOf(info, step)); step /= 2) all.push(levelOf(info, step));
  return all.filter((_, at) => at + 1 >= all.length || samplesOf(all[at + 1].counts) > soon);
}

// Returns the index of the level that follows one which took some milliseconds: the last, if it comes soon after all.
export function nextLevel(levels: readonly Level[], at: number, milliseconds: number): number {
  const isFast = samplesOf(levels[at].counts) > soon && milliseconds <= fast;
  return isFast ? Math.max(at + 1, levels.length - 1) : at + 1;
}

// Returns boxes of whole layers, or of rows of one, about a million samples each, that together are the level, or as much of
// it from a sample on.
export function slabsOf({ step, counts: [width, height, depth] }: Level, [left, top, front]: Vec3 = [0, 0, 0]): SampleBox[] {
  const rows = Math.max(1, Math.min(height, Math.floor(slabSamples / width)));
  const layers = Math.max(1, Math.floor(slabSamples / (width * height)));
  const slabs: SampleBox[] = [];
  for (let z = 0; z < depth; z += layers) {
    for (let y = 0; y < height; y += rows) {
      const first: Vec3 = [left, top + y * step, front + z * step];
      slabs.push({ first, step, counts: [width, Math.min(rows, height - y), Math.min(layers, depth - z)] });
    }
  }
  return slabs;
}

export function samplesOf(counts: Vec3): number {
  return counts[0] * counts[1] * counts[2];
}

// The ranges of values in the cells of blocks: of block (i, j, k), the cells 8 i to 8 i + 7 along x, and so on. A cell has
// the samples at its ends.
export class BlockRanges {
  readonly blocks: Vec3; // Of the whole level.
  readonly low: Float32Array;
  readonly high: Float32Array;

  // `first`, `end`: the layers of blocks along z that are held; default: all.
  constructor(
    private readonly counts: Vec3,
    readonly first = 0,
    end = Infinity,
  ) {
    this.blocks = counts.map((n) => Math.max(1, Math.ceil((n - 1) / blockSide))) as Vec3;
    const [across, down, layers] = this.blocks;
    const size = across * down * (Math.min(layers, end) - first);
    this.low = new Float32Array(size).fill(Infinity);
    this.high = new Float32Array(size).fill(-Infinity);
  }

  // Returns the layers that samples from layer `z` on belong to, as for the constructor.
  static layersOf(counts: Vec3, z: number, layers: number): [first: number, end: number] {
    const blocks = Math.max(1, Math.ceil((counts[2] - 1) / blockSide));
    return [blocksAt(z, blocks)[0], (blocksAt(z + layers - 1, blocks).at(-1) ?? 0) + 1];
  }

  // Adds the values of rows, which may be NaN; `first` counts the rows before them.
  add(first: number, values: SampleArray): void {
    const [width, height] = this.counts;
    const [across, down] = this.blocks;
    for (let begin = 0, row = first; begin < values.length; begin += width, ++row) {
      for (const k of blocksAt(Math.floor(row / height), this.blocks[2])) {
        for (const j of blocksAt(row % height, down)) this.addRow(across * (j + down * (k - this.first)), values, begin);
      }
    }
  }

  merge({ first, low, high }: Pick<BlockRanges, "first" | "low" | "high">): void {
    const offset = this.blocks[0] * this.blocks[1] * (first - this.first);
    for (let i = 0; i < low.length; ++i) {
      this.low[offset + i] = Math.min(this.low[offset + i], low[i]);
      this.high[offset + i] = Math.max(this.high[offset + i], high[i]);
    }
  }

  private addRow(block: number, values: SampleArray, begin: number): void {
    const [width] = this.counts;
    for (let i = 0; i < this.blocks[0]; ++i) {
      let [low, high] = [this.low[block + i], this.high[block + i]];
      const end = begin + Math.min(width, (i + 1) * blockSide + 1);
      for (let at = begin + i * blockSide; at < end; ++at) {
        const value = values[at];
        if (value < low) low = value;
        if (value > high) high = value;
      }
      this.low[block + i] = low;
      this.high[block + i] = high;
    }
  }
}

// A sample between two blocks belongs to both.
function blocksAt(at: number, count: number): number[] {
  const after = Math.min(count - 1, Math.floor(at / blockSide));
  return at % blockSide === 0 && at > 0 && after === at / blockSide ? [after - 1, after] : [after];
}
