// Buttons over the picture: where one looks from.
import { h } from "./dom";

export interface ViewActs {
  fit: () => void;
  reset: () => void;
  lookFrom: (x: number, y: number, z: number) => void;
  help: () => void;
}

const directions = [
  ["Front", 0, -1, 0],
  ["Side", 1, 0, 0],
  ["Top", 0, -0.0001, 1],
] as const;

export function viewTools(acts: ViewActs): HTMLElement {
  const button = (word: string, label: string, tip: string, act: () => void) => {
    const element = h("button", { type: "button", "aria-label": label, "data-tip": tip }, word);
    element.addEventListener("click", act);
    return element;
  };
  return h("nav", { class: "tools", "aria-label": "View" },
    button("Fit", "Fit the surface", "The whole surface in the picture (F).", acts.fit),
    button("Reset", "Reset the view", "The view of the beginning (R).", acts.reset),
    ...directions.map(([word, x, y, z]) =>
      button(word, `${word} view`, "Look along an axis of the world.", () => acts.lookFrom(x, y, z))),
    button("?", "How to use it", "Mouse, fingers and keys (?).", acts.help));
}
