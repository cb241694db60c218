// A small picture of the world's axes as one sees them now, with the patient's letters where the space
// is known. Each end is a button: one then looks from there.
import * as THREE from "three";

import { h } from "../shared/elements";
import type { DatasetInfo } from "../protocol/messages";
import { axisNames } from "./axis_names";
import type { Stage } from "./stage";

export class Orientation {
  readonly element = h("div", { class: "orientation", role: "group", "aria-label": "Look from a side", hidden: true });
  private ends: { button: HTMLElement; arm: HTMLElement; direction: THREE.Vector3 }[] = [];

  constructor(
    private readonly stage: Stage,
    private readonly lookFrom: (direction: THREE.Vector3) => void,
  ) {
    stage.whenDrawn(() => this.follow());
  }

  setDataset(info: DatasetInfo): void {
    this.ends = axisNames(info).map(({ letter, word, direction }, i) => {
      const button = h("button", {
        type: "button", class: `end axis-${"xyz"[i >> 1]}`, "aria-label": `Look from ${word}`, "data-tip": `Look from ${word}.`,
      }, letter);
      const towards = new THREE.Vector3(...direction);
      button.addEventListener("click", () => this.lookFrom(towards));
      return { button, arm: h("span", { class: `arm axis-${"xyz"[i >> 1]}` }), direction: towards };
    });
    this.element.replaceChildren(...this.ends.map(({ arm }) => arm), ...this.ends.map(({ button }) => button));
    this.element.hidden = false;
    this.follow();
  }

  show(isVisible: boolean): void {
    this.element.hidden = !isVisible || this.ends.length === 0;
  }

  private follow(): void {
    if (this.element.hidden) return;
    const toEye = this.stage.lens.quaternion.clone().invert();
    for (const { button, arm, direction } of this.ends) {
      const p = direction.clone().applyQuaternion(toEye);
      const arms = (count: number) => `calc(${count.toFixed(4)} * var(--arm))`; // As long as letters are large.
      button.style.transform = `translate(${arms(p.x)}, ${arms(-p.y)})`;
      button.style.zIndex = String(Math.round(10 + 9 * p.z));
      button.classList.toggle("is-behind", p.z < -0.05);
      arm.style.width = arms(Math.hypot(p.x, p.y));
      arm.style.transform = `rotate(${Math.atan2(-p.y, p.x).toFixed(4)}rad)`;
    }
  }
}
