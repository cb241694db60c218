// Explains why nothing of a surface is visible.
import type { ShownSurface } from "../shown_surface";
import type { Progress } from "../state/progress";
import { inDigits } from "../shared/quantities";
import { isEmpty } from "./certificate";
import { componentsText } from "./component_filter";

// Returns the reason; null: something is visible or will be.
export function emptySurfaceText({ info: of, facts }: ShownSurface, { shown, components, isStreaming }: Progress): string | null {
  if (!shown || isStreaming) return null;
  if (!isEmpty(shown)) return components?.shown === 0 ? `${componentsText(components)}.` : null;
  return `There is no surface at isovalue ${inDigits(facts.isovalue, 6)}: the values of "${of.name}" range from ` +
    `${inDigits(of.min, 6)} to ${inDigits(of.max, 6)}.`;
}
