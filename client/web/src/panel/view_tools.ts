// Buttons over the scene: fit, reset and views along the axes.

import { button, h } from "../shared/elements";
import type { Settings } from "../state/settings";
import { noSamples } from "./panel_section";

export interface ViewActions {
  fit: () => void;
  reset: () => void;
  lookUpright: (direction: readonly [number, number, number]) => void; // The direction for z up, rotated to the current up axis.
  toggleSlices: () => void;
  fullScreen: () => void;
  help: () => void;
}

const directions = [
  ["Front", 0, -1, 0],
  ["Side", 1, 0, 0],
  ["Top", 0, 0, 1],
] as const;

export interface ViewTools {
  element: HTMLElement;
  show: (settings: Settings) => void;
  showPermission: (permitsSamples: boolean) => void;
}

export function viewTools(actions: ViewActions): ViewTools {
  const tool = (word: string, label: string, tip: string, act: () => void) => button(word, act, { "aria-label": label, "data-tip": tip });
  const tip = "Three linked slices that meet in a crosshair (V).";
  const slices = tool("Slices", "Slices beside the surface", tip, actions.toggleSlices);
  const full = tool("Full", "Fullscreen", "Show only the picture (Z).", actions.fullScreen);
  full.append(h("span", { class: "wide" }, "screen")); // Hidden in narrow views.
  const element = h(
    "nav",
    { class: "tools", "aria-label": "View" },
    tool("Fit", "Fit the surface", "Fit the whole surface in the picture (F).", actions.fit),
    tool("Reset", "Reset view", "The initial view (R).", actions.reset),
    ...directions.map(([word, x, y, z]) =>
      tool(word, `${word} view`, `View from the ${word.toLowerCase()}, with the current up direction.`, () => actions.lookUpright([x, y, z])),
    ),
    slices,
    full,
    tool("?", "How to use it", "Mouse, fingers and keys (?).", actions.help),
  );
  return {
    element,
    show: ({ layout }) => slices.setAttribute("aria-pressed", String(layout === "four")),
    showPermission: (permitsSamples) => {
      slices.setAttribute("aria-disabled", String(!permitsSamples));
      slices.setAttribute("data-tip", permitsSamples ? tip : noSamples);
    },
  };
}
