// The side panel: all settings, in the order in which they are needed.
import type { DatasetInfo } from "../protocol/messages";
import type { ShownLevel } from "../scene/volume/volume";
import { h } from "../shared/elements";
import { settingsOfEntry } from "../state/label_surfaces";
import type { Progress, StepFacts, SurfaceSize } from "../state/progress";
import { seriesOf, timesOf } from "../state/series";
import { type Crop, defaults, type Settings } from "../state/settings";
import type { Store } from "../state/store";
import { type AccuracyPart, accuracyPart } from "./accuracy_section";
import { type BookmarksEvents, bookmarksPart } from "./bookmarks_section";
import { type CutPart, cutPart } from "./cut_section";
import { type DownloadsEvents, type DownloadsPart, downloadsPart } from "./downloads_section";
import { expectedText } from "./expected_text";
import { type FieldPart, fieldPart } from "./field_section";
import type { HistogramView } from "./histogram";
import { foldedSection, section } from "./inputs";
import { type IsovaluePart, isovaluePart } from "./isovalue_section";
import { type LabelsEvents, type LabelsPart, labelsPart } from "./labels_section";
import { lookPart } from "./look_section";
import type { Change, PanelSection } from "./panel_section";
import { regionPart } from "./region_section";
import { type SeriesPart, seriesPart } from "./series_section";
import { type SlicePart, slicePart } from "./slice_section";
import { type SurfacesPart, surfacesPart } from "./surfaces_section";
import { type VolumePart, volumePart } from "./volume_section";

export interface PanelEvents extends DownloadsEvents, BookmarksEvents, LabelsEvents {
  reset: () => void;
  roll: (radians: number) => void;
  shownBox: () => Crop;
}

const noServer = "Full resolution, read from files without a server. Allowed errors, budgets, finer places and colors by a field need a server.";

export class Panel {
  readonly element: HTMLElement;
  readonly histogram: HistogramView;
  private readonly parts: PanelSection[];
  private readonly accuracy: AccuracyPart;
  private readonly isovalue: IsovaluePart;
  private readonly surfaces: SurfacesPart;
  private readonly field: FieldPart;
  private readonly series: SeriesPart;
  private readonly labels: LabelsPart;
  private readonly downloads: DownloadsPart;
  private readonly slice: SlicePart;
  private readonly volume: VolumePart;
  private readonly cut: CutPart;
  private list: readonly DatasetInfo[] = [];
  private readonly ofValues: HTMLElement; // Does not apply to labels alone.
  private readonly surfacesElement: HTMLElement;
  private readonly labelsElement: HTMLElement;
  private readonly expected = h("p", {
    class: "expected",
    "data-tip": "The server's estimate for these settings. The view shows the full resolution instead where that arrives sooner.",
  });
  private size: SurfaceSize | null = null;
  private shown: StepFacts | null = null; // The shown step of the first surface.
  private info: DatasetInfo | null = null;

  constructor(
    private readonly settings: Store<Settings>,
    change: Change,
    events: PanelEvents,
    datasets: HTMLElement,
    isOfFiles = false, // There is no server.
  ) {
    const resetAll = h(
      "button",
      { type: "button", class: "action reset-all", "data-tip": "All settings except the dataset and the theme." },
      "Reset all settings",
    );
    resetAll.addEventListener("click", () => {
      const { dataset, theme } = settings.get();
      const series = this.info?.member?.label ? seriesOf(this.list, this.info) : null;
      change({ ...defaults, dataset, theme, ...(series && settingsOfEntry({ name: series.name, info: this.info!, series }, defaults)) });
      events.reset();
    });
    const isovalue = (this.isovalue = isovaluePart(change));
    const accuracy = (this.accuracy = accuracyPart(change, this.expected));
    const surfaces = (this.surfaces = surfacesPart(change));
    const series = (this.series = seriesPart(change));
    const labels = (this.labels = labelsPart(change, events));
    this.ofValues = h("section", {}, ...isovalue.elements);
    this.surfacesElement = foldedSection("Surfaces", settings.get().surfaces.length > 1, ...surfaces.elements);
    this.labelsElement = section("Labels", ...labels.elements);
    const region = regionPart(change);
    const field = (this.field = fieldPart(change));
    const slice = (this.slice = slicePart(change));
    const volume = (this.volume = volumePart(change));
    const cut = (this.cut = cutPart(change, events.shownBox));
    const look = lookPart(change, events.roll);
    this.downloads = downloadsPart(events);
    this.histogram = isovalue.histogram;
    this.parts = [series, isovalue, surfaces, labels, accuracy, region, field, cut, slice, volume, look];
    this.element = h(
      "aside",
      { class: "panel", "aria-label": "Controls" },
      h("header", {}, h("h1", {}, "Multi-Tetra"), h("p", {}, "surfaces of volume data, streamed")),
      section("Dataset", datasets, ...series.elements),
      this.labelsElement,
      this.ofValues,
      this.surfacesElement,
      section("Accuracy", ...(isOfFiles ? [h("p", { class: "hint" }, noServer)] : accuracy.elements)),
      ...(isOfFiles
        ? []
        : [
            foldedSection("Finer in one place", false, ...region.elements),
            foldedSection("Color by a field", settings.get().colorBy !== "", ...field.elements),
          ]),
      foldedSection("Clip and crop", settings.get().clip !== "off" || settings.get().crop !== null, ...cut.elements),
      foldedSection("Slices", settings.get().slice !== "off", ...slice.elements),
      foldedSection("Volume", settings.get().volume !== "off", ...volume.elements),
      foldedSection("Appearance", false, ...look.elements),
      foldedSection("Bookmarks", false, ...bookmarksPart(events)),
      foldedSection("Export", false, ...this.downloads.elements),
      resetAll,
    );
    settings.watch(() => this.show());
  }

  setDataset(info: DatasetInfo): void {
    this.info = info;
    this.show();
  }

  showExpected(size: SurfaceSize | null): void {
    this.size = size;
    this.drawExpected();
  }

  // Called when a surface was clicked.
  showPicked(surface: number): void {
    this.labels.select(surface);
  }

  showPaused(isPaused: boolean): void {
    this.accuracy.showPaused(isPaused);
  }

  showDatasets(list: readonly DatasetInfo[], permitsSamples: boolean): void {
    this.list = list;
    this.slice.showPermission(permitsSamples);
    this.volume.showPermission(permitsSamples);
    this.cut.showPermission(permitsSamples);
    for (const part of [this.isovalue, this.field, this.series, this.labels, this.surfaces, this.slice, this.volume]) part.showDatasets(list);
    this.show();
  }

  showVolume(level: ShownLevel | null): void {
    this.volume.showLevel(level);
  }

  showSurface(surface: number, progress: Progress): void {
    this.surfaces.showProgress(surface, progress);
    this.labels.showProgress(surface, progress);
    if (surface !== 0) return;
    this.field.showProgress(progress);
    if (progress.shown === this.shown) return;
    this.shown = progress.shown;
    this.drawExpected();
  }

  private drawExpected(): void {
    const { length } = this.settings.get().surfaces;
    const text = this.info?.member?.label && length > 1 ? "" : expectedText(this.size, this.shown);
    this.expected.textContent = (text && length > 1 ? `Surface 1: ${text}` : text) || "\u00a0"; // Keeps the line's height.
  }

  private show(): void {
    this.downloads.showTimes(this.info !== null && timesOf(this.list, this.info).length > 1);
    this.labelsElement.hidden = false; // The table scrolls to the first shown label.
    for (const part of this.parts) part.show(this.settings.get(), this.info);
    this.ofValues.hidden = !!this.info?.member?.label;
    this.surfacesElement.hidden = this.surfaces.isEmpty;
    this.labelsElement.hidden = this.labels.isEmpty;
    this.drawExpected();
  }
}
