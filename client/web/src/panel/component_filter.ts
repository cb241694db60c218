// "Hide components smaller than [ ] samples": of one surface, or of several. Noise in scans makes thousands of small ones around the main surface.
import type { ShownComponents } from "../state/progress";
import { maxMinComponent } from "../state/surfaces";
import { h } from "../shared/elements";
import { counted, grouped } from "../shared/quantities";
import type { Control } from "./inputs";
import { numberInput } from "./number_input";

// `of`: whose components, in words; `hide` hears of samples, 0: nothing is hidden. `keepLargest` hides all but one.
export function componentFilter(of: string, hide: (minComponent: number) => void, keepLargest?: () => void): Control<number> {
  const input = numberInput(`Hide components of ${of} smaller than, in samples`,
    (samples) => hide(Math.min(maxMinComponent, Math.max(0, samples))), () => hide(0));
  input.element.setAttribute("min", "0");
  input.element.setAttribute("placeholder", "0");
  const label = h("label", {
    "data-tip": "Parts that do not hang together with the rest, by the diagonal of the box around them. They are hidden " +
      "here, and in what you measure and take with you; what is checked stays the whole surface.",
  }, "Hide components smaller than ", input.element, " samples");
  const element = h("div", { class: "component-filter" }, label);
  if (keepLargest) element.append(keepLargestButton(of, keepLargest));
  return { element, show: (minComponent) => input.show(minComponent === 0 ? null : minComponent) };
}

function keepLargestButton(of: string, act: () => void): HTMLElement {
  const button = h("button", {
    type: "button", "aria-label": `Keep the largest part of ${of}`, "data-tip": "Hides every connected component but the largest one.",
  }, "Keep the largest part");
  button.addEventListener("click", act);
  return h("span", { class: "chips" }, button);
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
