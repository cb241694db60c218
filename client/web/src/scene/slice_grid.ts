// The pixels of a slice across the box of the data, and what lies at them.
import type { Vec3 } from "../stream/dataset";
import type { SliceGrid, SliceValues } from "../stream/questions";

export const mostPixels = 768; // Per side: about as fine as a picture shows it.

// `at`: 0 to 1 along the axis of the world. Pixels are square and no finer than `spacing`.
export function sliceGrid(low: Vec3, high: Vec3, axis: number, at: number, spacing: number): SliceGrid {
  const [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
  const step = Math.max(spacing, (high[u] - low[u]) / mostPixels, (high[v] - low[v]) / mostPixels);
  const pixels = (along: number) => Math.max(1, Math.round((high[along] - low[along]) / step));
  const [width, height] = [pixels(u), pixels(v)];
  const origin = [...low] as Vec3;
  origin[axis] = low[axis] + at * (high[axis] - low[axis]);
  const [right, down]: [Vec3, Vec3] = [[0, 0, 0], [0, 0, 0]];
  right[u] = (high[u] - low[u]) / width;
  down[v] = (high[v] - low[v]) / height;
  origin[u] += right[u] / 2;
  origin[v] += down[v] / 2;
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
