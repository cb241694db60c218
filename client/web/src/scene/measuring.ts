// What is told of picked places: where they are, what the field is there, the length between two, the angle at the second of
// three, and the area and volume of the part that was picked last. A fourth place begins anew.
import * as THREE from "three";

import { angleAt, areaText, distanceOf, volumeText } from "./measures";
import { h } from "../shared/elements";
import { counted, grouped, inDigits } from "../shared/quantities";
import type { MassProperties } from "../mesh/mass_properties";
import type { DatasetInfo, ProbedPlace } from "../protocol/messages";
import { latticeToWorld, lengthText, voxelLength, worldName } from "../stream/dataset";
import type { TilePool } from "../workers/tile_pool";
import { layers } from "./layers";
import type { Picked } from "./picking";
import type { Stage } from "./stage";

const names = "ABC";

export class Measuring {
  readonly element = h("div", { class: "picked", hidden: true, "aria-live": "polite" });
  readonly labels = h("div", { class: "pick-labels", "aria-hidden": "true" });
  private picks: Picked[] = [];
  private readonly dots: HTMLElement[] = [];
  private readonly line: THREE.Line;

  constructor(
    private readonly stage: Stage,
    private readonly pool: TilePool,
    private readonly probe: (place: Picked) => Promise<ProbedPlace>,
    private readonly leave: () => void, // The keyboard goes to what is shown.
  ) {
    this.line = new THREE.Line(
      new THREE.BufferGeometry(),
      new THREE.LineBasicMaterial({ color: 0xffd24a, depthTest: false }),
    );
    this.line.renderOrder = 5;
    this.line.frustumCulled = false;
    this.line.layers.set(layers.overlay);
    stage.scene.add(this.line);
    stage.whenDrawn(() => this.follow());
  }

  get places(): readonly Picked[] {
    return this.picks;
  }

  add(place: Picked): void {
    if (this.picks.length === names.length) this.picks = [];
    this.picks.push(place);
    this.tell();
  }

  forget(): void {
    this.picks = [];
    this.tell();
  }

  private tell(): void {
    const { picks } = this;
    this.element.hidden = picks.length === 0;
    this.dots.splice(0, Infinity, ...picks.map((_, i) => h("span", { class: "dot" }, names[i])));
    this.labels.replaceChildren(...this.dots);
    if (picks.length > 0) this.write();
    this.line.visible = picks.length > 1;
    if (picks.length > 1) this.line.geometry.setFromPoints(picks.map(({ world }) => new THREE.Vector3(...world)));
    this.stage.invalidate();
  }

  private write(): void {
    const { picks } = this;
    const { info } = picks[0];
    const close = h("button", { type: "button", class: "close", "aria-label": "Forget the picked points" }, "×");
    close.addEventListener("click", () => {
      this.forget();
      this.leave();
    });
    this.element.replaceChildren(close, ...picks.map(({ world, index }, i) =>
      h("p", {}, h("b", {}, names[i]), ` ${worldName(info)} ${world.map((v) => inDigits(v, 5)).join(", ")}`,
        h("span", {}, ` sample ${index.map((v) => v.toFixed(1)).join(", ")}`))), this.fieldAt(picks[picks.length - 1]));
    for (let i = 1; i < picks.length; ++i) {
      const length = distanceOf(picks[i - 1].world, picks[i].world);
      this.element.append(h("p", { class: "distance" }, `${names[i - 1]} to ${names[i]}: ${lengthText(length, info, 4)}`,
        h("span", {}, ` (${counted(length / voxelLength(info), "voxel", 4)})`)));
    }
    const [a, b, c] = picks.map(({ world }) => world);
    const angle = c && angleAt(b, a, c);
    if (angle) this.element.append(h("p", { class: "distance" }, `Angle at B: ${inDigits(angle, 4)}°`));
    if (!c) {
      const next = b ? "Click a third point for the angle." : "Click another point to measure.";
      this.element.append(h("p", { class: "hint" }, next));
    }
    const { surface } = picks[picks.length - 1];
    if (surface) this.element.append(this.partButton(surface));
  }

  // The place stays where what is there is not told.
  private fieldAt(place: Picked): HTMLElement {
    const line = h("p", { class: "field" }, "\u00a0");
    this.probe(place).then(
      (found) => line.replaceChildren(...fieldWords(found, place.info)),
      () => (line.hidden = true),
    );
    return line;
  }

  private partButton({ tiles, hit }: NonNullable<Picked["surface"]>): HTMLElement {
    const button = h("button", { type: "button", class: "measure-part" }, "Area and volume of this part");
    button.addEventListener("click", async () => {
      const { shown, drawn } = tiles;
      const toWorld = [...latticeToWorld(shown.info, shown.resolution)];
      const found = await this.pool.measure(drawn, toWorld, hit).catch(() => null);
      if (button.isConnected) button.replaceWith(h("p", { class: "part" }, ...partWords(found, shown.info)));
    });
    return button;
  }

  private follow(): void {
    this.picks.forEach(({ world }, i) => {
      const at = this.stage.project(new THREE.Vector3(...world));
      this.dots[i].hidden = !at;
      if (at) this.dots[i].style.transform = `translate(${at.x}px, ${at.y}px)`;
    });
  }
}

function fieldWords({ value, gradient }: ProbedPlace, info: DatasetInfo): (Node | string)[] {
  if (value === undefined) return ["No field here."];
  const unit = info.valueUnit ? ` ${info.valueUnit}` : "";
  const slope = gradient.length === 3 ? Math.hypot(...gradient) : null;
  const words = slope === null ? "" : `, gradient ${inDigits(slope, 4)}${unit} per ${info.lengthUnit || "unit"}`;
  return [h("b", {}, `Value ${inDigits(value, 6)}${unit}`), h("span", {}, words)];
}

function partWords(found: MassProperties | null, info: { lengthUnit: string }): (Node | string)[] {
  if (!found) return ["The surface has changed meanwhile; pick again."];
  const { area, volume, triangles } = found;
  const enclosed = volume === null ? "not closed, encloses nothing" : `volume ${volumeText(volume, info)}`;
  return [h("b", {}, `Area ${areaText(area, info)}, ${enclosed}`), h("span", {}, ` (${grouped(triangles)} triangles)`)];
}
