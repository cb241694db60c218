// Unpacks a part of a level and converts it for the GPU: 8 bits for data of 8 bits, else half floats over the data's range.
import type { Vec3 } from "../../stream/dataset";
import { type PackedSamples, unpackedSamples } from "../../stream/packed_samples";
import type { SampleArray } from "../../stream/sample_array";
import { BlockRanges, samplesOf } from "./levels";

export interface SlabJob {
  packed: PackedSamples;
  counts: Vec3; // Samples of the slab along each axis.
  row: number; // Rows of the level before it.
  layer: number; // And layers.
  levelCounts: Vec3;
  texels: TexelRules;
}

// `range`: the values of texels 0 and 1.
export interface TexelRules {
  range: [number, number];
  isOfBytes: boolean;
  isOfIntegers: boolean; // All values are.
}

export interface Slab {
  texels: Uint8Array<ArrayBuffer> | Uint16Array<ArrayBuffer>;
  ranges: Pick<BlockRanges, "first" | "low" | "high">;
}

const noValue = 0xfbff; // The half float -65504, which linear interpolation keeps below all values.
const leastNormal = 2 ** -14;

// Rejects if they are not the samples of the slab.
export async function madeSlab({ packed, counts, row, layer, levelCounts, texels }: SlabJob): Promise<Slab> {
  const samples = await unpackedSamples(packed, samplesOf(counts));
  const { first, low, high } = rangesOf(samples, row, levelCounts, BlockRanges.layersOf(levelCounts, layer, counts[2]));
  return { texels: texelsOf(samples, texels), ranges: { first, low, high } };
}

function rangesOf(samples: SampleArray, row: number, levelCounts: Vec3, layers: [number, number]): BlockRanges {
  const ranges = new BlockRanges(levelCounts, ...layers);
  ranges.add(row, samples);
  return ranges;
}

function texelsOf(samples: SampleArray, { range: [low, high], isOfBytes, isOfIntegers }: TexelRules): Slab["texels"] {
  if (isOfBytes) return Uint8Array.from(samples, (value) => value - low);
  const texels = new Uint16Array(samples.length);
  const half = (value: number) => (Number.isNaN(value) ? noValue : halfOf((value - low) / (high - low)));
  if (!isOfIntegers) {
    for (let i = 0; i < samples.length; ++i) texels[i] = half(samples[i]);
    return texels;
  }
  const table = Uint16Array.from({ length: high - low + 1 }, (_, i) => half(low + i));
  for (let i = 0; i < samples.length; ++i) {
    const at = samples[i] - low;
    texels[i] = Number.isNaN(at) ? noValue : table[at];
  }
  return texels;
}

const float = new Float32Array(1);
const bits = new Uint32Array(float.buffer);

// The bits of the nearest half float of a value from 0 to 1.
export function halfOf(share: number): number {
  if (share < leastNormal) return Math.round(share / 2 ** -24);
  float[0] = share;
  return (bits[0] - (112 << 23) + 0xfff + ((bits[0] >>> 13) & 1)) >>> 13;
}
