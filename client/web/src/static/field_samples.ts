// Values of a prepared file's field at places: slices and probes, with the rules of server/core/sampling.
import { CoordinateSystem, create, type Probe, type ProbedPlace, ProbedPlaceSchema, type Slice, SliceDetail } from "../protocol/messages";
import { applied, inverse, type Vec3 } from "../stream/dataset";
import { coarseExtent, coarseSpacing, indexIn } from "./level_extents";
import type { PreparedVolume } from "./prepared_file";
import { brickSide } from "./sample_bricks";

type SampleAt = (x: number, y: number, z: number) => number;

const maxPixels = 2 ** 21;
const maxPlaces = 1024;
const maxSliceBricks = 16384; // Larger slices use every eighth sample.
const snapDistance = 1e-6; // Nearer places are treated as on the sample.

export interface SampledSlice {
  values: Float32Array; // Row by row; NaN where there is no field.
  spacing: number; // 1; or 8: from every eighth sample.
}

// Rejects with one sentence.
export async function sampledSlice(volume: PreparedVolume, slice: Slice): Promise<SampledSlice> {
  const { width, height } = slice;
  if (!(width >= 1 && height >= 1 && width * height <= maxPixels)) throw new Error(`A slice has 1 to ${maxPixels} pixels.`);
  const toIndex = slice.coordinates === CoordinateSystem.INDEX ? null : inverse(volume.info.indexToWorld);
  const origin = toIndex ? applied(toIndex, slice.origin) : slice.origin;
  const step = (vector: readonly number[]) => (toIndex ? applied([...toIndex.slice(0, 9), 0, 0, 0], vector) : vector);
  const [right, down] = [step(slice.right), step(slice.down)];
  const each = (act: (pixel: number, place: Vec3) => void) => {
    for (let row = 0, pixel = 0; row < height; ++row) {
      for (let column = 0; column < width; ++column, ++pixel) act(pixel, [0, 1, 2].map((i) => snapped(origin[i] + column * right[i] + row * down[i])) as Vec3);
    }
  };
  const values = new Float32Array(width * height).fill(Number.NaN);
  const fill = (at: SampleAt, place: (index: Vec3) => Vec3) =>
    each((pixel, index) => isInData(volume, index) && (values[pixel] = linearValue(at, place(index))));
  const isCoarse = slice.detail !== SliceDetail.FULL && Math.min(...coarseExtent(volume.info).count) > 0;
  const isApart = Math.min(Math.hypot(...right), Math.hypot(...down)) >= coarseSpacing / 2;
  if (isCoarse && (isApart || slice.detail === SliceDetail.COARSE)) return fillCoarse();
  const bricks = new Set<number>();
  each((_, index) => isInData(volume, index) && addBricks(volume, index, bricks));
  if (isCoarse && bricks.size > maxSliceBricks) return fillCoarse();
  fill(await fineSamples(volume, bricks), (index) => index);
  return { values, spacing: 1 };

  function fillCoarse(): SampledSlice {
    const extent = coarseExtent(volume.info);
    const unit = (index: Vec3) =>
      index.map((at, axis) => Math.min(Math.max((at + volume.info.margin) / coarseSpacing - extent.low, 0), extent.count[axis] - 1)) as Vec3;
    fill((x, y, z) => volume.coarse[indexIn({ ...extent, low: 0 }, x, y, z)], unit);
    return { values, spacing: coarseSpacing };
  }
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
  const bricks = new Set<number>();
  for (const { index } of all)
    for (const place of [index, ...neighbors(index).flat()]) if (isInData(volume, place)) addBricks(volume, place.map(snapped) as Vec3, bricks);
  const at = await fineSamples(volume, bricks);
  const value = (index: Vec3) => (isInData(volume, index) ? linearValue(at, index.map(snapped) as Vec3) : Number.NaN);
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

function isInData({ info: { dims } }: PreparedVolume, index: Vec3): boolean {
  return index.every((place, axis) => snapped(place) >= 0 && snapped(place) <= dims[axis] - 1);
}

// Adds the bricks of the samples around the place.
function addBricks({ bricks }: PreparedVolume, index: Vec3, into: Set<number>): void {
  const [low, high] = [index.map((at) => Math.floor(Math.floor(at) / brickSide)), index.map((at) => Math.floor(Math.ceil(at) / brickSide))];
  for (let z = low[2]; z <= high[2]; ++z) for (let y = low[1]; y <= high[1]; ++y) for (let x = low[0]; x <= high[0]; ++x) into.add(bricks.index(x, y, z));
}

async function fineSamples({ bricks }: PreparedVolume, needed: ReadonlySet<number>): Promise<SampleAt> {
  await bricks.fetch([...needed]);
  await bricks.unpack([...needed]);
  return (x, y, z) => {
    const brick = [x, y, z].map((at) => Math.floor(at / brickSide)) as Vec3;
    const [nx, ny] = bricks.extent(...brick);
    return bricks.at(bricks.index(...brick))[(x % brickSide) + nx * ((y % brickSide) + ny * (z % brickSide))];
  };
}

// Trilinear. Ignores samples with weight 0; NaN if another one is void.
function linearValue(at: SampleAt, place: Vec3): number {
  const low = place.map(Math.floor);
  const beyond = place.map((one, axis) => one - low[axis]);
  let value = 0;
  for (let z = 0; z <= (beyond[2] > 0 ? 1 : 0); ++z) {
    for (let y = 0; y <= (beyond[1] > 0 ? 1 : 0); ++y) {
      const weight = (y ? beyond[1] : 1 - beyond[1]) * (z ? beyond[2] : 1 - beyond[2]);
      for (let x = 0; x <= (beyond[0] > 0 ? 1 : 0); ++x) value += (x ? beyond[0] : 1 - beyond[0]) * weight * at(low[0] + x, low[1] + y, low[2] + z);
    }
  }
  return value;
}
