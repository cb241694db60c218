// Which components of a surface are hidden: small ones, and single ones that were picked.
import type { Vec3 } from "../stream/dataset";

export interface HiddenParts {
  minComponent: number; // Samples: components whose bounding box has a shorter diagonal. 0: none.
  // World coordinates: the component nearest to each place. It is the same one in steps of any error, as long as the
  // places of another component are farther away than the error.
  places: readonly Vec3[];
}

export const nothingHidden: HiddenParts = { minComponent: 0, places: [] };

export function isNothingHidden({ minComponent, places }: HiddenParts): boolean {
  return minComponent === 0 && places.length === 0;
}

export function hidesTheSame(a: HiddenParts, b: HiddenParts): boolean {
  return a.minComponent === b.minComponent && String(a.places) === String(b.places);
}

// The hidden parts of a surface of the settings.
export function hiddenPartsOf({ minComponent = 0, hiddenParts = [] }: { minComponent?: number; hiddenParts?: readonly Vec3[] }): HiddenParts {
  return { minComponent, places: hiddenParts };
}
