// "Hide components smaller than [ ] samples", for one or several surfaces: noise causes thousands of small ones.

import { button, h } from "../shared/elements";
import { counted, grouped } from "../shared/quantities";
import type { HiddenParts } from "../state/hidden_parts";
import type { ShownComponents } from "../state/progress";
import { maxMinComponent } from "../state/settings";
import type { Control } from "./inputs";
import { numberInput } from "./number_input";

export interface ComponentFilterActions {
  hide: (minComponent: number) => void; // In samples; 0: hides none.
  showHidden: () => void; // Shows individually hidden parts again.
  keepLargest?: (isOn: boolean) => void; // Hides all but the largest, or shows all.
}

// `of`: names the surfaces.
export function componentFilter(of: string, { hide, showHidden, keepLargest }: ComponentFilterActions): Control<HiddenParts> {
  const input = numberInput(
    `Hide components of ${of} smaller than, in samples`,
    (samples) => hide(Math.min(maxMinComponent, Math.max(0, samples))),
    () => hide(0),
  );
  input.element.setAttribute("min", "0");
  input.element.setAttribute("placeholder", "0");
  const label = h(
    "label",
    {
      "data-tip":
        "Connected components with a shorter bounding-box diagonal are hidden " +
        "in the picture, in measurements and in downloads; checks apply to the whole surface.",
    },
    "Hide components smaller than ",
    input.element,
    " samples",
  );
  const element = h("div", { class: "component-filter" }, label);
  const again = button("", showHidden, { "aria-label": `Show the hidden parts of ${of}`, hidden: true });
  const largest = button("Keep the largest part", () => keepLargest?.(largest.getAttribute("aria-pressed") !== "true"), {
    "aria-label": `Keep the largest part of ${of}`,
    hidden: !keepLargest,
    "data-tip": "Hides all connected components except the largest, also when the surface changes.",
  });
  const chips = h("span", { class: "chips" }, largest, again);
  element.append(chips);
  return {
    element,
    show: ({ minComponent, places, largestOnly }) => {
      largest.setAttribute("aria-pressed", String(!!largestOnly));
      input.show(minComponent === 0 ? null : minComponent);
      again.hidden = places.length === 0;
      again.textContent = `Show ${counted(places.length, "hidden part")}`;
      chips.hidden = !keepLargest && again.hidden;
    },
  };
}

export function hidesAny(components: ShownComponents | null): components is ShownComponents {
  return components !== null && components.shown < components.components;
}

// "3 components of 120 shown (smaller than 12 samples hidden)". Individually hidden components count as hidden.
export function componentsText({ shown, components, minComponent }: ShownComponents): string {
  const noun = shown === 1 ? "component" : "components";
  const count = shown === 0 ? "No" : grouped(shown);
  const least = minComponent > 0 ? ` (smaller than ${counted(minComponent, "sample", 12)} hidden)` : "";
  return `${count} ${noun} of ${grouped(components)} shown${least}`;
}
