// The arrays of samples and cells in a prepared file; the same as in server/core/spectrum/prepared_volume.hpp.
import type { DatasetInfo } from "../protocol/messages";
import type { Vec3 } from "../stream/dataset";

export const coarseSpacing = 8;

// A box of points or cells in units of 8 grid steps, x fastest.
export interface Extent {
  low: number; // On all axes.
  count: Vec3;
}

// The grid points at multiples of 8 with samples.
export function coarseExtent({ margin, dims }: DatasetInfo): Extent {
  const low = Math.ceil(margin / coarseSpacing);
  return { low, count: dims.map((n) => Math.max(0, Math.floor((margin + n - 1) / coarseSpacing) - low + 1)) as Vec3 };
}

// The closed cells of 8 grid steps with samples.
export function cellExtent({ margin, dims }: DatasetInfo): Extent {
  const low = Math.floor(Math.max(0, margin - 1) / coarseSpacing);
  return { low, count: dims.map((n) => Math.floor((margin + n - 1) / coarseSpacing) - low + 1) as Vec3 };
}

export function sizeOf({ count: [x, y, z] }: Extent): number {
  return x * y * z;
}

export function indexIn({ low, count }: Extent, x: number, y: number, z: number): number {
  return x - low + count[0] * (y - low + count[1] * (z - low));
}
