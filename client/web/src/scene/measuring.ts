// Measures picked places: positions, field values, the length between two, the angle at the second of three, and the
// area and volume of the part picked last, which can be hidden. Each place may have a note. A fourth place starts over.
// Numbers have bounds and only significant digits.
import * as THREE from "three";
import { type MassProperties, volumeBound } from "../mesh/mass_properties";
import type { DatasetInfo, Label, ProbedPlace } from "../protocol/messages";
import { button, h } from "../shared/elements";
import { grouped, inDigits } from "../shared/quantities";
import { type MeasuredPlace, maxNoteLength, maxPlaces } from "../state/settings";
import {
  applied,
  coordinateResolution,
  inverse,
  latticeToWorld,
  placeText,
  reservationsOf,
  type Vec3,
  valueText,
  voxelLength,
  worldDifference,
  worldName,
} from "../stream/dataset";
import { boundOf, type ShownTiles } from "../surfaces/shown_surface";
import type { TilePool } from "../workers/tile_pool";
import type { MeasuredPart } from "../workers/worker_messages";
import { angleAt, areaText, distanceOf, lengthBetween, volumeText } from "./measures";
import type { Picked } from "./picking";
import type { Stage } from "./stage";

const names = "ABC";

// The measurements, for pictures.
export interface Measurement {
  points: { x: number; y: number; note: string }[]; // In CSS pixels.
  words: string[];
}

interface Place extends MeasuredPlace {
  info: DatasetInfo; // The dataset of the surface or the samples.
  index: Vec3; // In samples.
  surface: { tiles: ShownTiles; part: MeasuredPart } | null; // Null: on no shown surface.
}

export class Measuring {
  readonly element = h("div", { class: "picked", hidden: true, "aria-live": "polite" });
  readonly labels = h("div", { class: "pick-labels", "aria-hidden": "true" });
  private info: DatasetInfo | null = null;
  private places: Place[] = [];
  private readonly dots: HTMLElement[] = [];
  private readonly partLine = h("div");
  private isPartMeasured = false; // Whether the part at the place picked last is measured.
  private readonly drawing = document.createElementNS("http://www.w3.org/2000/svg", "svg");
  private readonly line = document.createElementNS("http://www.w3.org/2000/svg", "polyline");

  constructor(
    private readonly stage: Stage,
    private readonly pool: TilePool,
    private readonly probe: (info: DatasetInfo, world: Vec3) => Promise<ProbedPlace>,
    private readonly changed: (places: readonly MeasuredPlace[]) => void,
    private readonly leave: () => void, // Moves the focus to the scene.
    private readonly hidePart: (surface: number, world: Vec3, info: DatasetInfo) => void,
    private readonly nameOf: (label: Label) => string,
  ) {
    this.drawing.append(this.line);
    stage.whenDrawn(() => this.follow());
  }

  add({ world, index, info, surface }: Picked): void {
    const bound = surface ? boundOf(surface.tiles.shown) : 0; // A place on a plane is exact.
    const isGoingOn = this.places.every((one) => worldDifference(one.info, info) === null);
    const before = this.places.length < maxPlaces && isGoingOn ? this.places : [];
    this.places = [...before, { info, world, index, bound, surface: surface && { tiles: surface.tiles, part: surface.hit } }];
    this.emitChange();
  }

  clear(): void {
    if (this.places.length === 0) return;
    this.places = [];
    this.emitChange();
  }

  // Called when another step of a surface is shown: the measures of the part are outdated and repeated at the final
  // step. At another isovalue the place lies on no surface.
  surfaceReplaced(tiles: ShownTiles): void {
    const last = this.places[this.places.length - 1];
    const before = last?.surface?.tiles;
    if (!before || before.at !== tiles.at || before.shown === tiles.shown) return;
    const { info, resolution, facts } = tiles.shown;
    const isSame = info.name === before.shown.info.name && facts.isovalue === before.shown.facts.isovalue;
    const place = applied(inverse(latticeToWorld(info, resolution)), last.world);
    last.surface = isSame ? { tiles, part: { place } } : null;
    this.writePart(last);
    if (isSame && this.isPartMeasured && facts.isFinal) void this.measurePart(last.surface!);
  }

  // Shows the places of the settings; keeps the details of those picked here.
  show(info: DatasetInfo | null, places: readonly MeasuredPlace[]): void {
    const isSame = places.length === this.places.length && places.every((place, i) => isAt(place, this.places[i]) && place.note === this.places[i].note);
    const before = this.info;
    this.info = info;
    if (!info || (isSame && (places.length === 0 || before?.name === info.name))) return;
    const toIndex = inverse(info.indexToWorld);
    this.places = places.map((place) => {
      const known = this.places.find((one) => isAt(place, one));
      // Another time or field of the data has another value there.
      const isReplaced = known?.info.name === before?.name;
      return known
        ? { ...known, info: isReplaced ? info : known.info, note: place.note }
        : { ...place, info, index: applied(toIndex, place.world), surface: null };
    });
    this.write();
  }

  // The places and lengths that are currently visible.
  get measurement(): Measurement {
    const points = this.places.map(({ world }) => this.stage.project(new THREE.Vector3(...world)));
    const isWhole = points.every((at) => at !== null); // None is behind the eye.
    const noted = points.map((at, i) => ({ ...at!, note: this.places[i].note ?? "" }));
    return { points: isWhole ? noted : [], words: [...this.lengths(), ...this.angle()] };
  }

  private emitChange(): void {
    this.write();
    this.emitPlaces();
  }

  private emitPlaces(): void {
    this.changed(this.places.map(({ world, bound, note }) => ({ world, bound, ...(note ? { note } : {}) })));
  }

  private write(): void {
    const { places, info } = this;
    this.element.hidden = places.length === 0;
    this.writeDots();
    if (info && places.length > 0) this.writeWords(info);
    this.stage.invalidate();
  }

  private writeDots(): void {
    this.dots.splice(
      0,
      Infinity,
      ...this.places.map(({ note }, i) => h("span", { class: "dot" }, names[i], ...(note ? [h("span", { class: "dot-note" }, note)] : []))),
    );
    this.labels.replaceChildren(this.drawing, ...this.dots);
  }

  // For the place picked last.
  private noteInput(i: number): HTMLElement {
    const input = h("input", {
      type: "text",
      class: "note",
      placeholder: "Note",
      maxlength: String(maxNoteLength),
      "aria-label": `Note on ${names[i]}`,
    });
    input.value = this.places[i].note ?? "";
    input.addEventListener("change", () => {
      this.places[i] = { ...this.places[i], note: input.value.trim() || undefined };
      this.writeDots();
      this.stage.invalidate();
      this.emitPlaces();
    });
    return input;
  }

  private writeWords(info: DatasetInfo): void {
    const { places } = this;
    const clear = () => {
      this.clear();
      this.leave();
    };
    const close = button("×", clear, { class: "close", "aria-label": "Clear the measurement" });
    const last = places[places.length - 1];
    const label = last.surface?.tiles.shown.info.member?.label;
    this.element.replaceChildren(
      close,
      ...(label ? [h("p", { class: "picked-label" }, h("b", {}, this.nameOf(label)))] : []),
      ...places.map(({ world, index }, i) =>
        h(
          "p",
          {},
          h("b", {}, names[i]),
          ` ${worldName(info)} ${placeText(world, info)}`,
          h("span", {}, ` sample ${index.map((v) => v.toFixed(1)).join(", ")}`),
        ),
      ),
      ...(label ? [] : [this.fieldAt(last.info, last.world)]), // A label's field adds nothing to its name.
      ...[...this.lengths(), ...this.angle()].map((text) => h("p", { class: "distance" }, text)),
    );
    const click = this.element.closest(".has-slices") ? "Click (in slices: double-click)" : "Click";
    this.element.append(...reservationsOf(info).map((text) => h("p", { class: "assumed" }, text)));
    const next = [`${click} another point to measure.`, `${click} a third point for the angle.`][places.length - 1];
    if (next) this.element.append(h("p", { class: "hint" }, next));
    this.element.append(this.noteInput(places.length - 1));
    this.element.append(this.partLine);
    this.isPartMeasured = false;
    this.writePart(last);
  }

  private writePart({ surface, world }: Place): void {
    this.partLine.replaceChildren(...(surface ? [this.partButton(surface), this.hideButton(surface, world)] : []));
  }

  private lengths(): string[] {
    const { places, info } = this;
    return places.slice(1).map((to, i) => {
      const from = places[i];
      const length = distanceOf(from.world, to.world);
      const voxels = inDigits(length / voxelLength(info!), 3);
      return `${names[i]} to ${names[i + 1]}: ${lengthBetween(from, to, info!)} (${voxels} voxels)`;
    });
  }

  private angle(): string[] {
    const [a, b, c] = this.places.map(({ world }) => world);
    const angle = c && angleAt(b, a, c);
    return angle ? [`Angle at B: ${inDigits(angle, 3)}°`] : [];
  }

  // If the server returns no value, only the place is shown.
  private fieldAt(info: DatasetInfo, world: readonly number[]): HTMLElement {
    const line = h("p", { class: "field" }, "\u00a0");
    this.probe(info, [...world] as Vec3).then(
      (found) => line.replaceChildren(...fieldWords(found, info)),
      () => (line.hidden = true),
    );
    return line;
  }

  private partButton(surface: NonNullable<Place["surface"]>): HTMLElement {
    return button("Measure this part", () => void this.measurePart(surface), { class: "measure-part" });
  }

  private async measurePart(surface: NonNullable<Place["surface"]>): Promise<void> {
    const {
      tiles: { shown, drawn },
      part,
    } = surface;
    this.isPartMeasured = true;
    const toWorld = [...latticeToWorld(shown.info, shown.resolution)];
    const found = await this.pool.call("measure", drawn, toWorld, part).catch(() => null);
    const words = partWords(found, shown.info, boundOf(shown), shown.facts.isCertified && shown.facts.errorWorld === 0);
    if (this.places[this.places.length - 1]?.surface !== surface) return; // Another place or step in the meantime.
    this.partLine.querySelector(".measure-part")?.replaceWith(h("p", { class: "part" }, ...words));
  }

  private hideButton({ tiles }: NonNullable<Place["surface"]>, world: Vec3): HTMLElement {
    const hide = () => {
      this.clear();
      this.hidePart(tiles.at, world, tiles.shown.info);
      this.leave();
    };
    return button("Hide this part", hide, { class: "hide-part" });
  }

  private follow(): void {
    const seen = this.places.map(({ world }) => this.stage.project(new THREE.Vector3(...world)));
    seen.forEach((at, i) => {
      this.dots[i].hidden = !at;
      if (at) this.dots[i].style.transform = `translate(${at.x}px, ${at.y}px)`;
    });
    const isWhole = seen.every((at) => at !== null); // None is behind the eye.
    this.line.setAttribute("points", isWhole ? seen.map((at) => `${at!.x},${at!.y}`).join(" ") : "");
  }
}

// Compares with the precision of addresses.
function isAt(place: MeasuredPlace, known: Place): boolean {
  return place.world.every((value, axis) => Math.abs(value - known.world[axis]) <= coordinateResolution(known.info));
}

function fieldWords({ value, gradient }: ProbedPlace, info: DatasetInfo): (Node | string)[] {
  if (value === undefined) return ["No field here."];
  const unit = info.valueUnit ? ` ${info.valueUnit}` : "";
  const slope = gradient.length === 3 ? Math.hypot(...gradient) : null;
  const words = slope === null ? "" : `, gradient ${inDigits(slope, 3)}${unit} per ${info.lengthUnit || "unit"}`;
  return [h("b", {}, `Value ${valueText(value, info)}${unit}`), h("span", {}, words)];
}

// `bound`: the surface's error in world units; null: unknown.
function partWords(found: MassProperties | null, info: { lengthUnit: string }, bound: number | null, isFullResolution: boolean): (Node | string)[] {
  if (!found) return ["The surface has changed in the meantime; pick again."];
  const { area, volume, triangles, isCapped } = found;
  const off = bound === null ? null : volumeBound(found, bound);
  const ending = isCapped ? ", closed at the border of the data" : "";
  const enclosed = volume === null ? "not closed, encloses no volume" : `volume ${volumeText(volume, info, off)}${ending}`;
  return [
    h("b", {}, `Area ${areaText(area, info, isFullResolution)}, ${enclosed}`),
    h("span", {}, ` (${grouped(triangles)} triangles${isFullResolution ? ", full resolution" : ""})${volumeHint(volume, off, isFullResolution)}`),
  ];
}

// Returns how to obtain a volume or a tighter bound; empty: not needed.
export function volumeHint(volume: number | null, bound: number | null, isFullResolution: boolean): string {
  if (volume === null) {
    return ". The border of the data cuts it open on opposite sides: prepare the file, or view it, with --pad-value VALUE --pad 1 to close it.";
  }
  const isWide = bound === null || bound > 0.02 * volume;
  return isWide && !isFullResolution ? ". The quality Exact narrows the bound." : "";
}
