// Functions of a DatasetInfo: lengths, coordinate maps, where surfaces may end.
import type { DataBorder } from "../mesh/boundary_matcher";
import { type DatasetInfo, SampleType, WorldSpace } from "../protocol/messages";
import { inResolution } from "../shared/numbers";

export type Vec3 = [number, number, number];

// Columns of x, y and z, then the translation: three numbers each.
export type Affine = readonly number[];

export function applied(map: Affine, p: readonly number[]): Vec3 {
  const row = (i: number) => map[i] * p[0] + map[3 + i] * p[1] + map[6 + i] * p[2] + map[9 + i];
  return [row(0), row(1), row(2)];
}

export function inverse(map: Affine): Affine {
  const [a, b, c, d, e, f, g, h, i] = map;
  const linear = [e * i - f * h, c * h - b * i, b * f - c * e, f * g - d * i, a * i - c * g, c * d - a * f, d * h - e * g, b * g - a * h, a * e - b * d].map(
    (value) => value / determinant(map),
  );
  const back = [...linear, 0, 0, 0];
  const t = applied(back, map.slice(9));
  return [...linear, -t[0], -t[1], -t[2]];
}

// Returns the volume of one voxel in cubed world units.
export function voxelVolume({ indexToWorld }: DatasetInfo): number {
  return Math.abs(determinant(indexToWorld));
}

function determinant([a, b, c, d, e, f, g, h, i]: Affine): number {
  return a * (e * i - f * h) - d * (b * i - c * h) + g * (b * f - c * e);
}

// Returns the length of one voxel in world units.
export function voxelLength(info: DatasetInfo): number {
  return Math.min(...info.spacing);
}

// Returns the distance between samples along each world axis; that of a voxel where no axis of the grid is parallel to it.
export function worldSpacing(info: DatasetInfo): Vec3 {
  const m = info.indexToWorld;
  return [0, 1, 2].map((row) => {
    const parts = [m[row], m[3 + row], m[6 + row]].map(Math.abs).sort((a, b) => b - a);
    return parts[1] <= 1e-4 * parts[0] ? parts[0] : voxelLength(info);
  }) as Vec3;
}

// Returns the coordinate of the sample next to a world coordinate, within the data.
export function nearestSample(info: DatasetInfo, axis: number, at: number): number {
  const { low, high } = worldBox(info);
  const spacing = worldSpacing(info)[axis];
  const last = Math.round((high[axis] - low[axis]) / spacing);
  return low[axis] + spacing * Math.min(last, Math.max(0, Math.round((at - low[axis]) / spacing)));
}

// Returns the longest diagonal of a cell of eight samples, in world units.
export function longestCellDiagonal({ indexToWorld: m }: DatasetInfo): number {
  const lengths = [1, -1].flatMap((j) => [1, -1].map((k) => Math.hypot(...[0, 1, 2].map((row) => m[row] + j * m[3 + row] + k * m[6 + row]))));
  return Math.max(...lengths);
}

// Returns the largest displacement of a vertex by rounding to the lattice, in world units: one lattice step along the
// longest edge, since vertices are never at the ends of their edges.
export function latticeRoundingWorld(info: DatasetInfo, resolution: number): number {
  return longestCellDiagonal(info) / 2 ** resolution;
}

// "1.5 mm", or "1.5 units" if the unit is unknown.
export function lengthText(length: number, { lengthUnit }: Pick<DatasetInfo, "lengthUnit">, digits = 3): string {
  const number = Number(length.toPrecision(digits));
  return `${number} ${lengthUnit || (number === 1 ? "unit" : "units")}`;
}

// Returns the display name of world coordinates, by their axes if known.
export function worldName({ space }: Pick<DatasetInfo, "space">): string {
  return { [WorldSpace.LPS]: "LPS", [WorldSpace.RAS]: "RAS", [WorldSpace.UNSPECIFIED]: "world" }[space] ?? "world";
}

export function latticeToIndex(info: DatasetInfo, resolution: number): Affine {
  const step = 2 ** -resolution;
  return [step, 0, 0, 0, step, 0, 0, 0, step, -info.margin, -info.margin, -info.margin];
}

export function latticeToWorld(info: DatasetInfo, resolution: number): Affine {
  const step = 2 ** -resolution;
  const shift = [-info.margin, -info.margin, -info.margin];
  const linear = info.indexToWorld.slice(0, 9).map((value) => value * step);
  return [...linear, ...applied(info.indexToWorld, shift)];
}

// Returns the bounding box of all samples.
export function worldBox({ indexToWorld, dims }: DatasetInfo): { low: Vec3; high: Vec3 } {
  return boxOfCorners(
    indexToWorld,
    [0, 0, 0],
    dims.map((n) => n - 1),
  );
}

// Returns a sentence for each way in which the dataset may differ from what was measured.
export function reservationsOf({ assumed, rounding }: DatasetInfo): string[] {
  return [
    ...(assumed ? [`Its file does not state ${assumed}: assumed, so lengths and places may be wrong.`] : []),
    ...(rounding ? [`Its samples were rounded to 32-bit floats (${rounding}); surfaces are those of the rounded samples.`] : []),
  ];
}

// Returns the resolution of coordinates that are kept: a thousandth of a voxel, below which they have only rounding errors.
export function coordinateResolution(info: DatasetInfo): number {
  return 1e-3 * voxelLength(info);
}

// Coordinates are shown to a hundredth of a voxel: "12.34, 5400000.5, 7".
export function placeText(place: readonly number[], info: DatasetInfo): string {
  return place.map((value) => inResolution(value, 1e-2 * voxelLength(info))).join(", ");
}

// "12.5 mm": a coordinate along an axis.
export function coordinateText(value: number, info: DatasetInfo): string {
  return `${placeText([value], info)} ${info.lengthUnit || "units"}`;
}

// Values that are shown have a ten-thousandth of the range of the data.
export function valueText(value: number, { min, max }: Pick<DatasetInfo, "min" | "max">): string {
  return inResolution(value, (max - min) / 1e4);
}

// Returns a box around the samples of a label; null: unknown.
export function labelBox({ indexToWorld, member }: DatasetInfo): { low: Vec3; high: Vec3 } | null {
  const box = member?.label?.box ?? [];
  return box.length === 6
    ? boxOfCorners(
        indexToWorld,
        box.slice(0, 3).map((v) => v - 0.5),
        box.slice(3).map((v) => v + 0.5),
      )
    : null;
}

// Returns the world bounding box of a box of sample indices.
function boxOfCorners(indexToWorld: Affine, least: readonly number[], greatest: readonly number[]): { low: Vec3; high: Vec3 } {
  const low: Vec3 = [Infinity, Infinity, Infinity];
  const high: Vec3 = [-Infinity, -Infinity, -Infinity];
  for (let corner = 0; corner < 8; ++corner) {
    const index = least.map((at, axis) => (corner & (1 << axis) ? greatest[axis] : at));
    applied(indexToWorld, index).forEach((value, axis) => {
      low[axis] = Math.min(low[axis], value);
      high[axis] = Math.max(high[axis], value);
    });
  }
  return { low, high };
}

// Whether both have a sample at the same places, within a thousandth of a voxel.
export function hasSameGrid(a: DatasetInfo, b: DatasetInfo): boolean {
  const isSameSize = a.dims.every((count, axis) => count === b.dims[axis]);
  const [one, other] = [worldBox(a), worldBox(b)];
  const isNear = (x: Vec3, y: Vec3) => x.every((at, axis) => Math.abs(at - y[axis]) <= 1e-3 * voxelLength(a));
  return isSameSize && worldDifference(a, b) === null && isNear(one.low, other.low) && isNear(one.high, other.high);
}

// Whether all samples of `part` lie in the box of the other's, within half a sample of the coarser, in the same
// coordinates: unknown ones are not known to be the same.
export function isPartOf(part: DatasetInfo, whole: DatasetInfo): boolean {
  const [inner, outer] = [worldBox(part), worldBox(whole)];
  const slack = worldSpacing(part).map((step, axis) => 0.501 * Math.max(step, worldSpacing(whole)[axis]));
  return (
    part.space === whole.space &&
    part.lengthUnit === whole.lengthUnit &&
    slack.every((by, axis) => inner.low[axis] >= outer.low[axis] - by && inner.high[axis] <= outer.high[axis] + by)
  );
}

// Returns why a field of `b` has no values on surfaces of `a`, or null if both may be in one world.
export function worldDifference(a: DatasetInfo, b: DatasetInfo): string | null {
  const differ = <T>(x: T, y: T) => Boolean(x) && Boolean(y) && x !== y;
  if (differ(a.space, b.space)) return `its world axes are ${worldName(b)}, those of "${a.name}" are ${worldName(a)}`;
  if (differ(a.lengthUnit, b.lengthUnit)) return `its unit of length is ${b.lengthUnit}, that of "${a.name}" is ${a.lengthUnit}`;
  const [one, other] = [worldBox(a), worldBox(b)];
  const isApart = one.low.some((low, axis) => low > other.high[axis] || one.high[axis] < other.low[axis]);
  return isApart ? `it is at another position than "${a.name}": their bounding boxes do not overlap` : null;
}

// Computes the same as data_border in common/dataset/dataset_info.cpp, which gives the reasons.
export function dataBorder(info: DatasetInfo, resolution: number, topologyTolerance: number, finestSpacing: number): DataBorder {
  const step = 2 ** resolution;
  const anywhere = info.voidSamples > 0n;
  if (info.outside !== undefined) {
    const side = 2 ** info.gridExponent * step;
    return { low: [0, 0, 0], high: [side, side, side], inset: 0, anywhere };
  }
  const low = info.margin * step;
  const high = info.dims.map((n) => low + (n - 1) * step) as Vec3;
  let longest = finestSpacing;
  for (let s = 1; s <= topologyTolerance && s <= 2 ** info.gridExponent; s *= 2) {
    longest = Math.max(longest, 2 * s);
  }
  return { low: [low, low, low], high, inset: (longest - 1) * step, anywhere };
}

export function sampleTypeName(type: SampleType): string {
  return SampleType[type]?.toLowerCase().replace("sample_type_", "") ?? "?";
}
