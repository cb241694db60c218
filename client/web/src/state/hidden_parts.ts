// The hidden components of a surface: small ones, individually picked ones, or all but the largest.
import type { Vec3 } from "../stream/dataset";
import type { MinComponent } from "./settings";

export interface HiddenParts {
  minComponent: number; // In samples: components whose bounding box has a shorter diagonal are hidden. 0: none.
  // World coordinates. Hides the component nearest to each place; it is the same in steps of any error, as long as all
  // other components are farther from the place than the error.
  places: readonly Vec3[];
  largestOnly?: boolean; // Shows only the remaining component with the largest bounding box; absent: false.
}

export const nothingHidden: HiddenParts = { minComponent: 0, places: [] };

export function hidesNothing({ minComponent, places, largestOnly }: HiddenParts): boolean {
  return minComponent === 0 && places.length === 0 && !largestOnly;
}

export function isSameHiddenParts(a: HiddenParts, b: HiddenParts): boolean {
  return a.minComponent === b.minComponent && !!a.largestOnly === !!b.largestOnly && String(a.places) === String(b.places);
}

// Returns the hidden parts of a surface in the settings.
export function hiddenPartsOf({ minComponent = 0, hiddenParts = [] }: { minComponent?: MinComponent; hiddenParts?: readonly Vec3[] }): HiddenParts {
  const largestOnly = minComponent === "largest";
  return { minComponent: largestOnly ? 0 : minComponent, places: hiddenParts, largestOnly };
}
