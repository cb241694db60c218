// Values of a prepared file's field at places: slices and probes, with the rules of server/core/sampling.
import { CoordinateSystem, create, Interpolation, type Probe, type ProbedPlace, ProbedPlaceSchema, type Slice, SliceDetail } from "../protocol/messages";
import { type Affine, applied, inverse, type Vec3 } from "../stream/dataset";
import type { SampleArray } from "../stream/sample_array";
import { coarseExtent, coarseSpacing } from "./level_extents";
import type { PreparedVolume } from "./prepared_file";
import { brickSide } from "./sample_bricks";

type SampleAt = (x: number, y: number, z: number) => number;

const maxPixels = 2 ** 21;
const maxPlaces = 1024;
const maxSliceBricks = 16384; // Larger slices use every eighth sample.
const snapDistance = 1e-6; // Nearer places are treated as on the sample.

export interface SampledSlice {
  values: Float32Array; // Layer by layer and row by row; NaN where there is no field.
  spacing: number; // 1; or 8: from every eighth sample.
}

// Rejects with one sentence.
export async function sampledSlice(volume: PreparedVolume, slice: Slice): Promise<SampledSlice> {
  const { width, height, coordinates, interpolation, detail } = slice;
  const layers = Math.max(1, slice.layers);
  const size = width * height * layers;
  if (!(width >= 1 && height >= 1 && size <= maxPixels)) throw new Error(`A slice has 1 to ${maxPixels} pixels.`);
  const { info } = volume;
  if (isBoxOfSamples(slice, info.dims)) return { values: await boxOfSamples(volume, slice), spacing: 1 };
  const toIndex: Affine = coordinates === CoordinateSystem.INDEX ? [1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0] : inverse(info.indexToWorld);
  const step = (vector: readonly number[]) => applied([...toIndex.slice(0, 9), 0, 0, 0], vector);
  const [origin, right, down] = [applied(toIndex, slice.origin), step(slice.right), step(slice.down)];
  const inward = layers > 1 ? step(slice.inward) : [0, 0, 0];
  // Visits the pixels in the data.
  const each = (act: (pixel: number, x: number, y: number, z: number) => void) => {
    const place = (axis: number, column: number, row: number, layer: number) =>
      snapped(origin[axis] + column * right[axis] + row * down[axis] + layer * inward[axis]);
    const isInside = (at: number, axis: number) => at >= 0 && at <= info.dims[axis] - 1;
    for (let pixel = 0; pixel < size; ++pixel) {
      const [column, row, layer] = [pixel % width, Math.floor(pixel / width) % height, Math.floor(pixel / (width * height))];
      const [x, y, z] = [place(0, column, row, layer), place(1, column, row, layer), place(2, column, row, layer)];
      if (isInside(x, 0) && isInside(y, 1) && isInside(z, 2)) act(pixel, x, y, z);
    }
  };
  const values = new Float32Array(size).fill(Number.NaN);
  const valueAt = interpolation === Interpolation.NEAREST ? nearestValue : linearValue;
  const { low, count } = coarseExtent(info);
  const hasCoarse = detail !== SliceDetail.FULL && Math.min(...count) > 0;
  let isCoarse = hasCoarse && (detail === SliceDetail.COARSE || Math.min(Math.hypot(...right), Math.hypot(...down)) >= coarseSpacing / 2);
  const bricks = new BrickSet(volume);
  if (!isCoarse) each((_, x, y, z) => bricks.add(x, y, z));
  isCoarse ||= hasCoarse && bricks.size > maxSliceBricks;
  if (isCoarse) {
    const unit = (at: number, axis: number) => Math.min(Math.max((at + info.margin) / coarseSpacing - low, 0), count[axis] - 1);
    const sample: SampleAt = (x, y, z) => volume.coarse[x + count[0] * (y + count[1] * z)];
    each((pixel, x, y, z) => (values[pixel] = valueAt(sample, unit(x, 0), unit(y, 1), unit(z, 2))));
    return { values, spacing: coarseSpacing };
  }
  const sample = await bricks.samples();
  each((pixel, x, y, z) => (values[pixel] = valueAt(sample, x, y, z)));
  return { values, spacing: 1 };
}

// Whether it consists of samples, row by row along x, in fewer steps than those of the coarse ones: as volumes request them.
function isBoxOfSamples({ coordinates, interpolation, origin, right, down, inward, width, height, layers }: Slice, dims: readonly number[]): boolean {
  const step = right[0];
  const isAligned = [right, down, layers > 1 ? inward : [0, 0, step]].every((vector, axis) => [0, 1, 2].every((at) => vector[at] === (at === axis ? step : 0)));
  const ends = [width, height, Math.max(1, layers)].map((count, axis) => origin[axis] + (count - 1) * step);
  return (
    coordinates === CoordinateSystem.INDEX &&
    interpolation === Interpolation.NEAREST &&
    isAligned &&
    Number.isInteger(step) &&
    step >= 1 &&
    step < coarseSpacing &&
    origin.every((at, axis) => Number.isInteger(at) && at >= 0 && ends[axis] < dims[axis])
  );
}

async function boxOfSamples({ bricks }: PreparedVolume, { origin, right: [step], width, height, layers }: Slice): Promise<Float32Array> {
  const counts = [width, height, Math.max(1, layers)];
  const values = new Float32Array(counts[0] * counts[1] * counts[2]);
  const [low, high] = [origin.map((at) => Math.floor(at / brickSide)), origin.map((at, axis) => Math.floor((at + (counts[axis] - 1) * step) / brickSide))];
  const places: Vec3[] = [];
  for (let k = low[2]; k <= high[2]; ++k) for (let j = low[1]; j <= high[1]; ++j) for (let i = low[0]; i <= high[0]; ++i) places.push([i, j, k]);
  const unpacked = await bricks.unpack(places.map((place) => bricks.index(...place)));
  for (const place of places) {
    const samples = unpacked.get(bricks.index(...place))!;
    const [nx, ny] = bricks.extent(...place);
    const first = place.map((at, axis) => Math.max(0, Math.ceil((at * brickSide - origin[axis]) / step)));
    const end = place.map((at, axis) => Math.min(counts[axis], Math.ceil(((at + 1) * brickSide - origin[axis]) / step)));
    const inBrick = (pixel: number, axis: number) => origin[axis] + pixel * step - place[axis] * brickSide;
    for (let z = first[2]; z < end[2]; ++z) {
      for (let y = first[1]; y < end[1]; ++y) {
        const row = nx * (inBrick(y, 1) + ny * inBrick(z, 2)) + inBrick(0, 0);
        const to = width * (y + height * z);
        for (let x = first[0]; x < end[0]; ++x) values[to + x] = samples[row + x * step];
      }
    }
  }
  return values;
}

// Rejects with one sentence.
export async function probedPlaces(volume: PreparedVolume, { places, coordinates }: Probe): Promise<ProbedPlace[]> {
  const { info } = volume;
  if (places.length % 3 !== 0 || places.length < 3 || places.length > 3 * maxPlaces) throw new Error(`A probe has 1 to ${maxPlaces} places.`);
  const toIndex = inverse(info.indexToWorld);
  const all = Array.from({ length: places.length / 3 }, (_, i) => places.slice(3 * i, 3 * i + 3)).map((place) =>
    coordinates === CoordinateSystem.INDEX
      ? { index: place as Vec3, world: applied(info.indexToWorld, place) }
      : { index: applied(toIndex, place), world: place as Vec3 },
  );
  const isInData = (index: Vec3) => index.every((at, axis) => snapped(at) >= 0 && snapped(at) <= info.dims[axis] - 1);
  const bricks = new BrickSet(volume);
  for (const { index } of all) for (const place of [index, ...neighbors(index).flat()]) if (isInData(place)) bricks.add(...(place.map(snapped) as Vec3));
  const sample = await bricks.samples();
  const value = (index: Vec3) => (isInData(index) ? linearValue(sample, ...(index.map(snapped) as Vec3)) : Number.NaN);
  return all.map(({ index, world }) => {
    const here = value(index);
    if (Number.isNaN(here)) return create(ProbedPlaceSchema, { world, index });
    const slopes = neighbors(index).map(([below, above]) => slope(value(below), here, value(above)));
    const gradient = [0, 1, 2].map((axis) => slopes.reduce((sum, one, i) => sum + one * toIndex[3 * axis + i], 0));
    return create(ProbedPlaceSchema, { world, index, value: here, gradient });
  });
}

// The places one sample below and above, along each axis.
function neighbors(index: Vec3): [Vec3, Vec3][] {
  return [0, 1, 2].map((axis) => [-1, 1].map((step) => index.map((at, i) => (i === axis ? at + step : at)) as Vec3) as [Vec3, Vec3]);
}

function slope(below: number, here: number, above: number): number {
  if (!Number.isNaN(below) && !Number.isNaN(above)) return 0.5 * (above - below);
  if (!Number.isNaN(above)) return above - here;
  return Number.isNaN(below) ? 0 : here - below;
}

function snapped(at: number): number {
  const nearest = Math.round(at);
  return Math.abs(at - nearest) <= snapDistance ? nearest : at;
}

// The bricks of the samples around some places.
export class BrickSet {
  private readonly bricks = new Set<number>();

  constructor(private readonly volume: PreparedVolume) {}

  get size(): number {
    return this.bricks.size;
  }

  get all(): number[] {
    return [...this.bricks];
  }

  // Adds those of the eight samples around a place in the data.
  add(x: number, y: number, z: number): void {
    const brick = (at: number) => Math.floor(at / brickSide);
    const [toX, toY, toZ] = [brick(Math.ceil(x)), brick(Math.ceil(y)), brick(Math.ceil(z))];
    for (let k = brick(z); k <= toZ; ++k) {
      for (let j = brick(y); j <= toY; ++j) for (let i = brick(x); i <= toX; ++i) this.bricks.add(this.volume.bricks.index(i, j, k));
    }
  }

  async samples(): Promise<SampleAt> {
    const { bricks, info } = this.volume;
    const all = await bricks.unpack([...this.bricks]);
    let last = -1;
    let samples!: SampleArray;
    return (x, y, z) => {
      const [i, j, k] = [Math.floor(x / brickSide), Math.floor(y / brickSide), Math.floor(z / brickSide)];
      const brick = bricks.index(i, j, k);
      if (brick !== last) samples = all.get((last = brick))!;
      const [nx, ny] = [Math.min(brickSide, info.dims[0] - i * brickSide), Math.min(brickSide, info.dims[1] - j * brickSide)];
      return samples[(x % brickSide) + nx * ((y % brickSide) + ny * (z % brickSide))];
    };
  }
}

function nearestValue(at: SampleAt, x: number, y: number, z: number): number {
  return at(Math.floor(x + 0.5), Math.floor(y + 0.5), Math.floor(z + 0.5));
}

// Trilinear. Ignores samples with weight 0; NaN if another one is void.
function linearValue(at: SampleAt, x: number, y: number, z: number): number {
  const [lowX, lowY, lowZ] = [Math.floor(x), Math.floor(y), Math.floor(z)];
  const [toX, toY, toZ] = [x - lowX, y - lowY, z - lowZ];
  let value = 0;
  for (let k = 0; k <= (toZ > 0 ? 1 : 0); ++k) {
    for (let j = 0; j <= (toY > 0 ? 1 : 0); ++j) {
      const weight = (j ? toY : 1 - toY) * (k ? toZ : 1 - toZ);
      for (let i = 0; i <= (toX > 0 ? 1 : 0); ++i) value += (i ? toX : 1 - toX) * weight * at(lowX + i, lowY + j, lowZ + k);
    }
  }
  return value;
}
