// "Hide components smaller than [ ] samples": of one surface, or of several. Noise in scans makes thousands of
// small ones around the one that is meant.
import type { ShownComponents } from "../state/progress";
import { maxMinComponent } from "../state/surfaces";
import { h } from "../shared/elements";
import { counted, grouped } from "../shared/quantities";
import type { Control } from "./inputs";
import { numberInput } from "./number_input";

// `of`: whose components, in words; `hide` hears of samples, 0: nothing is hidden.
export function componentFilter(of: string, hide: (minComponent: number) => void): Control<number> {
  const input = numberInput(`Hide components of ${of} smaller than, in samples`,
    (samples) => hide(Math.min(maxMinComponent, Math.max(0, samples))), () => hide(0));
  input.element.setAttribute("min", "0");
  input.element.setAttribute("placeholder", "0");
  const element = h("label", {
    class: "component-filter",
    "data-tip": "Hides connected components by the diagonal of their bounding box, also in measurements and downloads. " +
      "Checks cover the whole surface.",
  }, "Hide components smaller than ", input.element, " samples");
  return { element, show: (minComponent) => input.show(minComponent === 0 ? null : minComponent) };
}

export function hidesAny(components: ShownComponents | null): components is ShownComponents {
  return components !== null && components.shown < components.components;
}

// "3 components of 120 shown (smaller than 12 samples hidden)"
export function componentWords({ shown, components, minComponent }: ShownComponents): string {
  const noun = shown === 1 ? "component" : "components";
  const count = shown === 0 ? "No" : grouped(shown);
  return `${count} ${noun} of ${grouped(components)} shown (smaller than ${counted(minComponent, "sample", 12)} hidden)`;
}
