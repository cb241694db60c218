// What surrounds the surface: the box of the data with its axes, and a scale bar in world units.
import * as THREE from "three";

import { applied, lengthText } from "../stream/dataset";
import type { DatasetInfo } from "../protocol/messages";
import { h } from "../panel/dom";
import { discard } from "./discard";
import type { Stage } from "./stage";

const axisColours = [0xd9534f, 0x5cb85c, 0x4f8fd9];

export class Surroundings {
  readonly scaleBar = h("div", { class: "scale-bar", "data-tip":
    "A length at the distance of the middle of the picture, in the unit of the dataset's spacing." });
  private readonly box = new THREE.Group();
  private dataset: DatasetInfo | null = null; // Before there is one, no length means anything.

  constructor(private readonly stage: Stage) {
    stage.scene.add(this.box);
    stage.whenDrawn(() => this.drawScale());
  }

  setDataset(info: DatasetInfo): void {
    discard(this.box);
    this.dataset = info;
    this.show(this.box.visible);
    const corner = (bits: number) =>
      applied(info.indexToWorld, info.dims.map((n, axis) => (bits & (1 << axis) ? n - 1 : 0)));
    for (let axis = 0; axis < 3; ++axis) {
      for (let bits = 0; bits < 8; ++bits) {
        if (bits & (1 << axis)) continue;
        const geometry = new THREE.BufferGeometry();
        const ends = [...corner(bits), ...corner(bits | (1 << axis))];
        geometry.setAttribute("position", new THREE.Float32BufferAttribute(ends, 3));
        const isAxis = bits === 0;
        const material = new THREE.LineBasicMaterial({
          color: isAxis ? axisColours[axis] : 0x808a96,
          transparent: true,
          opacity: isAxis ? 1 : 0.32,
        });
        this.box.add(new THREE.LineSegments(geometry, material));
      }
    }
    this.stage.invalidate();
  }

  show(isVisible: boolean): void {
    this.box.visible = isVisible;
    this.scaleBar.hidden = !isVisible || !this.dataset;
    this.stage.invalidate();
  }

  private drawScale(): void {
    if (!this.dataset) return;
    const wanted = this.stage.unitsOf(110);
    const magnitude = 10 ** Math.floor(Math.log10(wanted));
    const length = [5, 2, 1].map((n) => n * magnitude).find((value) => value <= wanted) ?? magnitude;
    const pixels = length / this.stage.unitsOf(1);
    if (!Number.isFinite(pixels)) return;
    this.scaleBar.style.width = `${pixels.toFixed(1)}px`;
    const text = lengthText(length, this.dataset, 4);
    if (this.scaleBar.textContent !== text) this.scaleBar.textContent = text;
  }
}
