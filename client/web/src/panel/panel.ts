// The side panel: all settings, in the order in which they are needed.
import { button, h } from "../shared/elements";
import { settingsOfEntry } from "../state/label_surfaces";
import type { Progress, StepFacts, SurfaceSize } from "../state/progress";
import { seriesOf, timesOf } from "../state/series";
import { type Crop, defaults, type Settings } from "../state/settings";
import type { Store } from "../state/store";
import { type AccuracyPart, accuracyPart } from "./accuracy_section";
import { type BookmarksEvents, bookmarksPart } from "./bookmarks_section";
import { cutPart } from "./cut_section";
import { type DownloadsEvents, type DownloadsPart, downloadsPart } from "./downloads_section";
import { expectedText } from "./expected_text";
import { type FieldPart, fieldPart } from "./field_section";
import type { HistogramView } from "./histogram";
import { foldedSection, section } from "./inputs";
import { isovaluePart } from "./isovalue_section";
import { type LabelsEvents, LabelsTable } from "./labels_section";
import { lookPart } from "./look_section";
import type { Change, PanelSection, Shown } from "./panel_section";
import { regionPart } from "./region_section";
import { seriesPart } from "./series_section";
import { slicePart } from "./slice_section";
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
  readonly accuracy: AccuracyPart;
  private readonly surfaces: SurfacesPart;
  private readonly field: FieldPart;
  readonly labels: LabelsTable;
  private readonly downloads: DownloadsPart;
  readonly volume: VolumePart;
  private readonly ofValues: HTMLElement; // Does not apply to labels alone.
  private readonly surfacesElement: HTMLElement;
  private readonly labelsElement: HTMLElement;
  private readonly expected = h("p", {
    class: "expected",
    "data-tip": "The server's estimate for these settings. The view shows the full resolution instead where that arrives sooner.",
  });
  private size: SurfaceSize | null = null;
  private step: StepFacts | null = null; // The shown step of the first surface.
  private shown: Shown;

  constructor(
    settings: Store<Settings>,
    change: Change,
    events: PanelEvents,
    datasets: HTMLElement,
    isOfFiles = false, // There is no server.
  ) {
    this.shown = { settings: settings.get(), info: null, list: [], permitsSamples: true };
    const resetAll = () => {
      const { dataset, theme } = settings.get();
      const { info, list } = this.shown;
      const series = info?.member?.label ? seriesOf(list, info) : null;
      change({ ...defaults, dataset, theme, ...(series && settingsOfEntry({ name: series.name, info: info!, series }, defaults)) });
      events.reset();
    };
    const isovalue = isovaluePart(change);
    this.accuracy = accuracyPart(change, this.expected);
    this.surfaces = surfacesPart(change);
    this.labels = new LabelsTable(change, events);
    this.field = fieldPart(change);
    this.volume = volumePart(change);
    this.downloads = downloadsPart(events);
    this.histogram = isovalue.histogram;
    const [series, region, cut, slice] = [seriesPart(change), regionPart(change), cutPart(change, events.shownBox), slicePart(change)];
    const look = lookPart(change, events.roll);
    this.parts = [series, isovalue, this.surfaces, this.labels, this.accuracy, region, this.field, cut, slice, this.volume, look];
    this.ofValues = h("section", {}, ...isovalue.elements);
    const { colorBy, clip, crop, slice: plane, volume, surfaces } = settings.get();
    this.surfacesElement = foldedSection("Surfaces", surfaces.length > 1, ...this.surfaces.elements);
    this.labelsElement = section("Labels", ...this.labels.elements);
    const ofServer = [
      section("Accuracy", ...this.accuracy.elements),
      foldedSection("Finer in one place", false, ...region.elements),
      foldedSection("Color by a field", colorBy !== "", ...this.field.elements),
    ];
    this.element = h(
      "aside",
      { class: "panel", "aria-label": "Controls" },
      h("header", {}, h("h1", {}, "Multi-Tetra"), h("p", {}, "surfaces of volume data, streamed")),
      section("Dataset", datasets, ...series.elements),
      this.labelsElement,
      this.ofValues,
      this.surfacesElement,
      ...(isOfFiles ? [section("Accuracy", h("p", { class: "hint" }, noServer))] : ofServer),
      foldedSection("Clip and crop", clip !== "off" || crop !== null, ...cut.elements),
      foldedSection("Slices", plane !== "off", ...slice.elements),
      foldedSection("Volume", volume !== "off", ...this.volume.elements),
      foldedSection("Appearance", false, ...look.elements),
      foldedSection("Bookmarks", false, ...bookmarksPart(events)),
      foldedSection("Export", false, ...this.downloads.elements),
      button("Reset all settings", resetAll, { class: "action reset-all", "data-tip": "All settings except the dataset and the theme." }),
    );
    settings.watch((now) => this.show({ settings: now }));
  }

  show(change: Partial<Shown>): void {
    this.shown = { ...this.shown, ...change };
    const { info, list } = this.shown;
    this.downloads.showTimes(info !== null && timesOf(list, info).length > 1);
    this.labelsElement.hidden = false; // The table scrolls to the first shown label.
    for (const part of this.parts) part.show(this.shown);
    this.ofValues.hidden = !!info?.member?.label;
    this.surfacesElement.hidden = this.surfaces.isEmpty;
    this.labelsElement.hidden = this.labels.isEmpty;
    this.drawExpected();
  }

  showExpected(size: SurfaceSize | null): void {
    this.size = size;
    this.drawExpected();
  }

  showSurface(surface: number, progress: Progress): void {
    this.surfaces.showProgress(surface, progress);
    this.labels.showProgress(surface, progress);
    if (surface !== 0) return;
    this.field.showProgress(progress);
    if (progress.shown === this.step) return;
    this.step = progress.shown;
    this.drawExpected();
  }

  private drawExpected(): void {
    const { info, settings } = this.shown;
    const { length } = settings.surfaces;
    const text = info?.member?.label && length > 1 ? "" : expectedText(this.size, this.step);
    this.expected.textContent = (text && length > 1 ? `Surface 1: ${text}` : text) || "\u00a0"; // Keeps the line's height.
  }
}
