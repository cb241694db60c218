// Hides the picked connected part of a surface.

import { rounded } from "../shared/numbers";
import type { Settings } from "../state/settings";
import { maxHiddenParts } from "../state/settings";
import { withSurface } from "../state/surfaces";
import type { Vec3 } from "../stream/dataset";

// The change of settings, or the reason for none.
export type PartsChange = { change: Partial<Settings> } | { refusal: string };

// Hides the component nearest to a place in the world, which is kept with this resolution.
export function withoutPart(settings: Settings, surface: number, place: Vec3, resolution: number): PartsChange {
  const { hiddenParts } = settings.surfaces[surface];
  if (hiddenParts.length >= maxHiddenParts) return { refusal: `At most ${maxHiddenParts} parts of a surface can be hidden individually.` };
  const part = place.map((value) => rounded(value, resolution)) as Vec3;
  return { change: withSurface(settings, surface, { hiddenParts: [...hiddenParts, part] }) };
}
