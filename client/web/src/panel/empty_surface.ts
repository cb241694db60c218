// Explains why nothing of a surface is visible.

import type { Progress } from "../state/progress";
import { valueText } from "../stream/dataset";
import type { ShownSurface } from "../surfaces/shown_surface";
import { isEmpty } from "./certificate";
import { componentsText } from "./component_filter";

// Returns the reason; null: something is visible or will be.
export function emptySurfaceText({ info: of, facts }: ShownSurface, { shown, components, isStreaming }: Progress): string | null {
  if (!shown || isStreaming) return null;
  if (!isEmpty(shown)) return components?.shown === 0 ? `${componentsText(components)}.` : null;
  return `There is no surface at isovalue ${facts.isovalue}: the values of "${of.name}" range from ` + `${valueText(of.min, of)} to ${valueText(of.max, of)}.`;
}
