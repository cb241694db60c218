// Shows the name of the label under the pointer.

import type { Label } from "../protocol/messages";
import { h } from "../shared/elements";
import { latestOnly } from "../shared/latest_only";
import type { Picked } from "./picking";

export class LabelHover {
  readonly element = h("div", { class: "label-hover", "aria-hidden": "true", hidden: true });
  private pointer: { x: number; y: number } | null = null; // Null: no name is needed.
  private readonly findLabel: (pointer: { x: number; y: number }) => void;

  // `hasLabels`: whether any label is shown; `find`: finds what is at a place of the canvas.
  constructor(
    canvas: HTMLCanvasElement,
    private readonly hasLabels: () => boolean,
    find: (x: number, y: number) => Promise<Picked | null>,
    private readonly nameOf: (label: Label) => string,
  ) {
    this.findLabel = latestOnly(async ({ x, y }) => this.show(await find(x, y).catch(() => null)));
    canvas.addEventListener("pointermove", ({ pointerType, buttons, offsetX, offsetY }) => {
      if (pointerType !== "mouse" || buttons !== 0 || !this.hasLabels()) return this.leave();
      this.pointer = { x: offsetX, y: offsetY };
      this.findLabel(this.pointer);
    });
    for (const end of ["pointerleave", "pointerdown", "wheel"]) canvas.addEventListener(end, () => this.leave(), { passive: true });
  }

  private leave(): void {
    this.pointer = null;
    this.element.hidden = true;
  }

  private show(found: Picked | null): void {
    const label = found?.surface?.tiles.shown.info.member?.label;
    this.element.hidden = !label || !this.pointer;
    if (!label || !this.pointer) return;
    this.element.textContent = this.nameOf(label);
    this.element.style.transform = `translate(${this.pointer.x + 14}px, ${this.pointer.y + 14}px)`;
  }
}
