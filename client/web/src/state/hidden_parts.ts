// Which components of a surface are hidden: small ones, single ones that were picked, or all but the largest.
import type { Vec3 } from "../stream/dataset";

export interface HiddenParts {
  minComponent: number; // Samples: components whose bounding box has a shorter diagonal. 0: none.
  // World coordinates: the component nearest to each place. It is the same one in steps of any error, as long as the
  // places of another component are farther away than the error.
  places: readonly Vec3[];
  largestOnly?: boolean; // Only the other component with the largest box is shown, whatever the step; absent: false.
}

export const nothingHidden: HiddenParts = { minComponent: 0, places: [] };

export function isNothingHidden({ minComponent, places, largestOnly }: HiddenParts): boolean {
  return minComponent === 0 && places.length === 0 && !largestOnly;
}

export function hidesTheSame(a: HiddenParts, b: HiddenParts): boolean {
  return a.minComponent === b.minComponent && !!a.largestOnly === !!b.largestOnly && String(a.places) === String(b.places);
}

// The hidden parts of a surface of the settings.
export function hiddenPartsOf(surface: { minComponent?: number; hiddenParts?: readonly Vec3[]; largestOnly?: boolean }): HiddenParts {
  const { minComponent = 0, hiddenParts = [], largestOnly = false } = surface;
  return { minComponent, places: hiddenParts, largestOnly };
}
