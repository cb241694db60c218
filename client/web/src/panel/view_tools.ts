// Buttons over the picture: where one looks from.
import * as THREE from "three";

import { h } from "../shared/elements";

export interface ViewActs {
  fit: () => void;
  reset: () => void;
  lookFrom: (direction: THREE.Vector3) => void;
  fullScreen: () => void;
  help: () => void;
}

const directions = [
  ["Front", 0, -1, 0],
  ["Side", 1, 0, 0],
  ["Top", 0, 0, 1],
] as const;

export function viewTools(acts: ViewActs): HTMLElement {
  const button = (word: string, label: string, tip: string, act: () => void) => {
    const element = h("button", { type: "button", "aria-label": label, "data-tip": tip }, word);
    element.addEventListener("click", act);
    return element;
  };
  return h("nav", { class: "tools", "aria-label": "View" },
    button("Fit", "Fit the surface", "The whole surface in the picture (F).", acts.fit),
    button("Reset", "Reset view", "The view from the start (R).", acts.reset),
    ...directions.map(([word, x, y, z]) =>
      button(word, `${word} view`, "Look along an axis of the world.", () => acts.lookFrom(new THREE.Vector3(x, y, z)))),
    button("Fullscreen", "Fullscreen", "The picture alone (Z).", acts.fullScreen),
    button("?", "How to use it", "Mouse, fingers and keys (?).", acts.help));
}
