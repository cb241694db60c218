// The pixel grid of a slice through the box of the data.
import type { Vec3 } from "../stream/dataset";
import type { SliceGrid, SliceValues } from "../stream/dataset_queries";

export const maxPixels = 768; // Per side; about the resolution of a view.

// A world axis in its direction (1) or against it (-1).
export interface Direction {
  axis: number;
  sign: 1 | -1;
}

// The orientation of an axis-aligned plane on the screen.
export interface PlaneAxes {
  axis: number;
  right: Direction;
  down: Direction;
}

export function axisNormal(axis: "x" | "y" | "z"): Vec3 {
  return [..."xyz"].map((one) => (one === axis ? 1 : 0)) as Vec3;
}

// `at`: 0 to 1 along the unit vector `normal`, over the box. Pixels are square and no finer than `spacing`.
export function sliceGrid(low: Vec3, high: Vec3, normal: Vec3, at: number, spacing: number): SliceGrid {
  const axis = normal.indexOf(1);
  if (axis < 0) return obliqueGrid(low, high, normal, at, spacing);
  const [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
  return planeGrid(low, high, { axis, right: { axis: u, sign: 1 }, down: { axis: v, sign: 1 } }, low[axis] + at * (high[axis] - low[axis]), spacing);
}

// Returns the grid in screen orientation. `at`: the world coordinate along its axis.
export function planeGrid(low: Vec3, high: Vec3, plane: PlaneAxes, at: number, spacing: number): SliceGrid {
  const extent = ({ axis }: Direction) => high[axis] - low[axis];
  const step = Math.max(spacing, extent(plane.right) / maxPixels, extent(plane.down) / maxPixels);
  const pixels = (along: Direction) => Math.max(1, Math.round(extent(along) / step));
  const [width, height] = [pixels(plane.right), pixels(plane.down)];
  const origin = [...low] as Vec3;
  origin[plane.axis] = at;
  const side = (along: Direction, count: number): Vec3 => {
    const one: Vec3 = [0, 0, 0];
    one[along.axis] = (along.sign * extent(along)) / count;
    origin[along.axis] = (along.sign > 0 ? low : high)[along.axis] + one[along.axis] / 2;
    return one;
  };
  const [right, down] = [side(plane.right, width), side(plane.down, height)];
  return { origin, right, down, width, height };
}

// Returns the least and greatest distance of the box along a unit vector.
export function extentAlong(low: Vec3, high: Vec3, normal: Vec3): { from: number; to: number } {
  const ends = normal.map((part, axis) => [part * low[axis], part * high[axis]].sort((a, b) => a - b));
  return { from: ends.reduce((sum, [least]) => sum + least, 0), to: ends.reduce((sum, [, most]) => sum + most, 0) };
}

// Returns the corners, in any order, of the polygon in which the plane normal * place = `distance` cuts the box.
export function cutCorners(low: Vec3, high: Vec3, normal: Vec3, distance: number): Vec3[] {
  const corners: Vec3[] = [];
  for (let edge = 0; edge < 12; ++edge) {
    const axis = edge >> 2;
    const place = low.map((from, other) => (other !== axis && (edge >> ((other - axis + 5) % 3)) & 1 ? high[other] : from)) as Vec3;
    const along = normal[axis] * (high[axis] - low[axis]);
    const share = (distance - dot(normal, place)) / along;
    if (!(share >= -1e-9 && share <= 1 + 1e-9)) continue;
    place[axis] += share * (high[axis] - low[axis]);
    corners.push(place);
  }
  return corners;
}

// Returns two unit vectors perpendicular to `normal`: right and down.
export function perpendicularTo(normal: Vec3): [Vec3, Vec3] {
  const least = normal.map(Math.abs).reduce((best, part, axis, all) => (part < all[best] ? axis : best), 0);
  const across = cross(normal, [0, 1, 2].map((axis) => (axis === least ? 1 : 0)) as Vec3);
  const length = Math.hypot(...across);
  const right = across.map((part) => part / length) as Vec3;
  return [right, cross(normal, right)];
}

function obliqueGrid(low: Vec3, high: Vec3, normal: Vec3, at: number, spacing: number): SliceGrid {
  const { from, to } = extentAlong(low, high, normal);
  const distance = from + at * (to - from);
  const corners = cutCorners(low, high, normal, distance);
  const ranges = perpendicularTo(normal).map((side) => {
    const places = corners.length > 0 ? corners.map((corner) => dot(side, corner)) : [0];
    return { side, first: Math.min(...places), extent: Math.max(...places) - Math.min(...places) };
  });
  const step = Math.max(spacing, ...ranges.map(({ extent }) => extent / maxPixels));
  const [across, below] = ranges.map((range) => {
    const pixels = Math.max(1, Math.round(range.extent / step));
    const one = Math.max(range.extent, 1e-9 * step) / pixels;
    return { ...range, pixels, one, step: range.side.map((part) => part * one) as Vec3 };
  });
  const origin = normal.map((part, i) =>
    distance * part + (across.first + across.one / 2) * across.side[i] + (below.first + below.one / 2) * below.side[i]) as Vec3;
  return { origin, right: across.step, down: below.step, width: across.pixels, height: below.pixels };
}

export function dot(a: Vec3, b: Vec3): number {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

function cross(a: Vec3, b: Vec3): Vec3 {
  return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
}

// Returns the value of the pixel that contains a place of the plane; NaN outside the slice.
export function valueAt({ grid, values }: SliceValues, place: Vec3): number {
  const { origin, right, down, width, height } = grid;
  const along = (step: Vec3) => {
    const square = step.reduce((sum, part) => sum + part * part, 0);
    return Math.round(step.reduce((sum, part, i) => sum + part * (place[i] - origin[i]), 0) / square);
  };
  const [x, y] = [along(right), along(down)];
  return x >= 0 && x < width && y >= 0 && y < height ? values[y * width + x] : NaN;
}
