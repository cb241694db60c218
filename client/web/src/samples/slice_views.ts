// Three linked slices beside the surface, perpendicular to the world axes. They meet in one place, shown by a crosshair
// in each and a mark in the scene. Window and level are those of the slice in the scene.
import { Vector3 } from "three";
import type { DatasetInfo } from "../protocol/messages";
import { SliceView, type Zoom } from "../scene/slice_view";
import type { Stage } from "../scene/stage";
import { h } from "../shared/elements";
import { latestOnly } from "../shared/latest_only";
import { isSameData } from "../state/series";
import { hasSameGrid, type Vec3, valueText, worldSpacing } from "../stream/dataset";
import { LatestSlice, type SliceSources } from "./latest_slice";
import { crossOf, type ShownSamples, scaleOf } from "./slices";

export class SliceViews {
  readonly element = h("div", { class: "slice-views", role: "group", "aria-label": "Slices", hidden: true });
  readonly mark = h("div", { class: "cross-mark", "aria-hidden": "true", hidden: true });
  private readonly planes: { view: SliceView; latest: LatestSlice }[];
  private cross: Vec3 | null = null; // Null: no slices are shown.
  private zoom: Zoom | null = null; // Null: each view shows its whole plane.
  private zoomed: DatasetInfo | null = null; // The dataset whose part is shown.
  private wanted: { sampled: DatasetInfo; cross: Vec3 } | null = null; // The place whose value is shown.
  private readonly probe = latestOnly(async (wanted: NonNullable<SliceViews["wanted"]>) => {
    const found = await this.sources.queries.probe(wanted.sampled.name, wanted.cross).catch(() => null);
    if (this.wanted === wanted && found?.value !== undefined) this.showValue(valueWithUnit(found.value, wanted.sampled));
  });

  constructor(
    private readonly stage: Stage,
    private readonly sources: SliceSources,
    private readonly current: () => ShownSamples,
    moved: (cross: Vec3, isDragging: boolean) => void,
    marked: (world: Vec3) => void, // A place to measure.
  ) {
    this.planes = [2, 1, 0].map((axis) => {
      const view = new SliceView(axis, moved, (zoom) => this.setZoom(zoom), marked);
      return { view, latest: new LatestSlice(sources, { slice: (slice) => view.showSlice(slice), lines: (lines) => view.showLines(lines) }) };
    });
    this.element.append(...this.planes.map(({ view }) => view.canvas));
    stage.whenDrawn(() => this.follow());
  }

  // Call when the settings, the dataset or the surfaces may have changed.
  update(): void {
    const { info, sampled, settings, rangeOfSamples } = this.current();
    const isShown = settings.layout === "four";
    const before = this.cross;
    this.element.hidden = !isShown;
    this.cross = isShown && info ? crossOf(settings.cross, info) : null;
    if (!info || !sampled || !this.cross) {
      for (const { latest } of this.planes) latest.request(null);
      this.wanted = null;
      return this.follow();
    }
    const { cross } = this;
    if (!this.zoomed || !hasSameGrid(this.zoomed, info)) this.zoom = null;
    this.zoomed = info;
    const range = rangeOfSamples();
    const scale = { map: settings.sliceColors, ...scaleOf(settings.level, settings.windowWidth, settings.samplesLog, range ?? sampled) };
    const hasMoved = cross.some((at, axis) => at !== before?.[axis]);
    if (hasMoved && this.planes.some(({ view }) => view.hides(cross))) this.zoom = this.zoom && { ...this.zoom, center: cross };
    for (const { view, latest } of this.planes) {
      view.show(info, cross, scale, this.zoom, settings.places);
      const grid = view.grid(worldSpacing(sampled));
      const { origin, width, height } = grid;
      latest.request({ key: `${sampled.name} ${sampled.contentId} ${origin} ${width} ${height}`, dataset: sampled.name, grid });
    }
    this.updateValue(sampled, cross);
    this.stage.invalidate();
  }

  // Shows the value at the crosshair in all views.
  private updateValue(sampled: DatasetInfo, cross: Vec3): void {
    const { wanted } = this;
    if (isSameData(wanted?.sampled, sampled) && cross.every((at, axis) => at === wanted?.cross[axis])) return;
    this.wanted = { sampled, cross };
    this.showValue("");
    this.probe(this.wanted);
  }

  private setZoom(zoom: Zoom | null): void {
    this.zoom = zoom;
    this.update();
  }

  private showValue(text: string): void {
    for (const { view } of this.planes) view.showValue(text);
  }

  // Draws all views where they are on the screen; `corner`: the element's whose corner is at (0, 0).
  drawOn(context: CanvasRenderingContext2D, corner: DOMRect): void {
    for (const { view } of this.planes) {
      const { x, y, width, height } = view.canvas.getBoundingClientRect();
      context.save();
      context.translate(x - corner.x, y - corner.y);
      context.beginPath();
      context.rect(0, 0, width, height);
      context.clip();
      context.fillStyle = "#000000";
      context.fill();
      view.drawOn(context);
      context.restore();
    }
  }

  close(): void {
    for (const { view } of this.planes) view.close();
  }

  private follow(): void {
    const at = this.cross && this.stage.project(new Vector3(...this.cross));
    this.mark.hidden = !at;
    if (at) this.mark.style.transform = `translate(${at.x}px, ${at.y}px)`;
  }
}

function valueWithUnit(value: number, info: DatasetInfo): string {
  return `${valueText(value, info)}${info.valueUnit ? ` ${info.valueUnit}` : ""}`;
}
