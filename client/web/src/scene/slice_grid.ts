// The pixel grid of a slice through the box of the data.
import { cross, dot, minus } from "../shared/vectors";
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

// `at`: 0 to 1 along the unit vector `normal`, over the box. `spacing`: the least distance of pixels, along world axes.
// The centers of the first and last pixels are on the border of the box, as samples are.
export function sliceGrid(low: Vec3, high: Vec3, normal: Vec3, at: number, spacing: Vec3): SliceGrid {
  const axis = normal.indexOf(1);
  if (axis < 0) return obliqueGrid(low, high, normal, at, Math.min(...spacing));
  const [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
  return planeGrid(low, high, { axis, right: { axis: u, sign: 1 }, down: { axis: v, sign: 1 } }, low[axis] + at * (high[axis] - low[axis]), spacing);
}

// Returns the grid in screen orientation. `at`: the world coordinate along its axis.
export function planeGrid(low: Vec3, high: Vec3, plane: PlaneAxes, at: number, spacing: Vec3): SliceGrid {
  const origin = [...low] as Vec3;
  origin[plane.axis] = at;
  const side = ({ axis, sign }: Direction): [Vec3, number] => {
    const [count, one] = pixelsOf(high[axis] - low[axis], spacing[axis]);
    const step: Vec3 = [0, 0, 0];
    step[axis] = sign * one;
    origin[axis] = (sign > 0 ? low : high)[axis];
    return [step, count];
  };
  const [[right, width], [down, height]] = [side(plane.right), side(plane.down)];
  return { origin, right, down, width, height };
}

// Returns the part of the box around `center` of which a plane's view shows the shares `seen` to the right and downwards,
// and half as much around it. It is whole along sides whose samples are all pixels.
export function seenPart(
  box: { low: Vec3; high: Vec3 },
  { right, down }: PlaneAxes,
  center: Vec3,
  seen: readonly [number, number],
  spacing: Vec3,
): { low: Vec3; high: Vec3 } {
  const [low, high]: Vec3[] = [[...box.low], [...box.high]];
  for (const [i, { axis }] of [right, down].entries()) {
    const extent = box.high[axis] - box.low[axis];
    if (extent / spacing[axis] < maxPixels) continue;
    // On a grid of quarters of what is seen, so that not every movement needs other samples.
    const quarter = Math.max(1, Math.round((extent * seen[i]) / spacing[axis] / 4)) * spacing[axis];
    const middle = Math.round((center[axis] - box.low[axis]) / quarter);
    low[axis] = Math.max(box.low[axis], box.low[axis] + (middle - 3) * quarter);
    high[axis] = Math.min(box.high[axis], box.low[axis] + (middle + 3) * quarter);
  }
  return { low, high };
}

// Returns how many pixels span a length from the center of the first to that of the last, and their distance.
function pixelsOf(extent: number, spacing: number): [number, number] {
  const count = Math.min(maxPixels, Math.round(extent / spacing) + 1);
  return [count, count > 1 ? extent / (count - 1) : spacing];
}

// Returns the corners of a grid's pixel centers: of the first and last pixel of the first row, then of the last row.
export function gridCorners({ origin, right, down, width, height }: SliceGrid): Vec3[] {
  const center = (x: number, y: number) => origin.map((part, i) => part + x * right[i] + y * down[i]) as Vec3;
  return [center(0, 0), center(width - 1, 0), center(0, height - 1), center(width - 1, height - 1)];
}

// Returns the least and greatest distance of the box along a unit vector.
export function extentAlong(low: Vec3, high: Vec3, normal: Vec3): { from: number; to: number } {
  const ends = normal.map((part, axis) => [part * low[axis], part * high[axis]].sort((a, b) => a - b));
  return { from: ends.reduce((sum, [least]) => sum + least, 0), to: ends.reduce((sum, [, greatest]) => sum + greatest, 0) };
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
  const [across, below] = ranges.map((range) => {
    const [pixels, one] = pixelsOf(range.extent, spacing);
    return { ...range, pixels, step: range.side.map((part) => part * one) as Vec3 };
  });
  const origin = normal.map((part, i) => distance * part + across.first * across.side[i] + below.first * below.side[i]) as Vec3;
  return { origin, right: across.step, down: below.step, width: across.pixels, height: below.pixels };
}

// Returns the value of the pixel nearest to a place of the plane; NaN outside the pixels' centers.
export function valueAt({ grid, values }: SliceValues, place: Vec3): number {
  const { origin, right, down, width, height } = grid;
  const along = (step: Vec3) => dot(step, minus(place, origin)) / dot(step, step);
  const [x, y] = [along(right), along(down)];
  const isInside = (at: number, count: number) => at > -1e-6 && at < count - 1 + 1e-6;
  return isInside(x, width) && isInside(y, height) ? values[Math.round(y) * width + Math.round(x)] : NaN;
}
