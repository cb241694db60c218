// The pixels of a slice across the box of the data, and what lies at them.
import type { Vec3 } from "../stream/dataset";
import type { SliceGrid, SliceValues } from "../stream/dataset_queries";

export const mostPixels = 768; // Per side: about as fine as a picture shows it.

// An axis of the world, in its direction (1) or against it (-1).
export interface Direction {
  axis: number;
  sign: 1 | -1;
}

// How a plane across an axis of the world lies on the screen.
export interface PlaneSides {
  axis: number;
  right: Direction;
  down: Direction;
}

// `at`: 0 to 1 along the axis of the world. Pixels are square and no finer than `spacing`.
export function sliceGrid(low: Vec3, high: Vec3, axis: number, at: number, spacing: number): SliceGrid {
  const [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
  return planeGrid(low, high, { axis, right: { axis: u, sign: 1 }, down: { axis: v, sign: 1 } }, low[axis] + at * (high[axis] - low[axis]), spacing);
}

// The same as it lies on the screen. `at`: the world coordinate along its axis.
export function planeGrid(low: Vec3, high: Vec3, plane: PlaneSides, at: number, spacing: number): SliceGrid {
  const extent = ({ axis }: Direction) => high[axis] - low[axis];
  const step = Math.max(spacing, extent(plane.right) / mostPixels, extent(plane.down) / mostPixels);
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

// The value of the pixel that a place of the plane lies in; NaN beyond the slice.
export function valueAt({ grid, values }: SliceValues, place: Vec3): number {
  const { origin, right, down, width, height } = grid;
  const along = (step: Vec3) => {
    const square = step.reduce((sum, part) => sum + part * part, 0);
    return Math.round(step.reduce((sum, part, i) => sum + part * (place[i] - origin[i]), 0) / square);
  };
  const [x, y] = [along(right), along(down)];
  return x >= 0 && x < width && y >= 0 && y < height ? values[y * width + x] : NaN;
}
