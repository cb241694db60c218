// The table of the labels of a segmentation. Hidden labels are not loaded. Changes of a selected label apply to all
// selected ones.
import type { DatasetInfo, Label } from "../protocol/messages";
import { button, h } from "../shared/elements";
import { hiddenPartsOf } from "../state/hidden_parts";
import { maxInitialLabels } from "../state/label_surfaces";
import type { Progress } from "../state/progress";
import { findByName, labelName, labelOf, renamedLabel, withLabelName } from "../state/series";
import type { Settings, SurfaceSettings } from "../state/settings";
import { withAllSurfaces } from "../state/surfaces";
import { componentFilter } from "./component_filter";
import { opacitySlider } from "./inputs";
import { type LabelLook, type LabelRow, labelRow } from "./label_row";
import { type LabelsBeside, labelsBeside } from "./labels_beside";
import type { Change, PanelSection, Shown } from "./panel_section";
import { RowSelection } from "./row_selection";

const fewLabels = 8; // At most this many need no search.

export interface LabelsEvents {
  saveLabels: (surfaces: readonly number[] | null) => void; // Saves a table of the visible ones of these surfaces; null: of all surfaces.
  zoomToLabel: (dataset: string) => void;
}

export class LabelsTable implements PanelSection {
  readonly elements: HTMLElement[];
  private settings: Settings | null = null;
  private datasets: readonly DatasetInfo[] = [];
  private readonly rows = new Map<number, LabelRow>(); // By surface.
  private found: FoundLabel[] = []; // In the order of the table.
  private readonly selection = new RowSelection(() => this.showSelected());
  private readonly list = h("ul", { class: "labels" });
  private readonly count = h("span", { class: "labels-count" });
  private readonly search = h("input", {
    type: "search",
    class: "label-search",
    placeholder: "Search labels",
    "aria-label": "Search labels",
    input: () => this.showFound(),
  });
  // A single label is selected to look at it, so the table then has all labels.
  private readonly table = button("Table (CSV)", () => this.events.saveLabels(this.selected().length > 1 ? this.selected() : null), {
    "data-tip": "Samples of all labels, volume and area of those displayed, or of several selected ones, as CSV.",
  });
  private readonly order = h(
    "select",
    { class: "label-order", "aria-label": "Order of the labels", change: () => this.showAll() },
    ...labelOrders.map(([word, text]) => h("option", { value: word }, text)),
  );
  private readonly limit = h("p", { class: "hint", hidden: true });
  private readonly opacity = opacitySlider("all labels", (opacity) => this.changeAll(() => ({ opacity })));
  private readonly mixed = h("span", { class: "labels-count", hidden: true }, "mixed");
  private readonly filter = componentFilter("all labels", {
    hide: (minComponent) => this.changeAll(() => ({ minComponent })),
    showHidden: () => this.changeAll(() => ({ hiddenParts: [] })),
  });

  private readonly beside: LabelsBeside;
  private readonly shown: HTMLElement; // Everything about the labels that are shown or hidden.

  constructor(
    private readonly change: Change,
    private readonly events: LabelsEvents,
  ) {
    this.list.addEventListener("keydown", (event) => this.press(event));
    // Space would click the name.
    this.list.addEventListener("keyup", (event) => event.key === " " && (event.target as Element).matches(".label-name") && event.preventDefault());
    const head = h(
      "div",
      { class: "chips labels-head" },
      this.visibilityButton("All", "Shows every label.", true),
      this.visibilityButton("None", "Hides every label.", false),
      this.table,
      this.count,
      this.order,
      this.opacity.element,
      this.mixed,
    );
    this.shown = h("div", { class: "labels-table" }, head, this.search, this.limit, this.list, this.filter.element);
    this.beside = labelsBeside(change);
    this.elements = [this.beside.element, this.shown];
  }

  // There are no labels to show.
  get isEmpty(): boolean {
    return this.found.length === 0 && this.beside.element.hidden;
  }

  show({ settings, info, list }: Shown): void {
    this.settings = settings;
    this.datasets = list;
    this.beside.show(list, settings, info);
    this.showAll();
  }

  showProgress(surface: number, progress: Progress): void {
    this.rows.get(surface)?.showProgress(progress);
  }

  // Selects and scrolls to the row of a surface that was clicked.
  select(surface: number): void {
    const label = this.found.find(({ at }) => at === surface);
    if (!label) return;
    const { element } = this.rows.get(surface)!;
    element.hidden = false;
    element.scrollIntoView({ block: "nearest" });
    this.selection.select(label.key);
  }

  // ---- changes

  private visibilityButton(word: string, tip: string, visible: boolean): HTMLElement {
    return button(word, () => this.changeAll(() => ({ visible })), { "data-tip": tip });
  }

  private changeAll(look: (at: number) => Partial<SurfaceSettings>): void {
    const isLabel = (one: SurfaceSettings) => labelOf(this.datasets, this.datasetOf(one)) !== null;
    this.change(withAllSurfaces(this.settings!, (one, at) => (isLabel(one) ? look(at) : null)));
  }

  private datasetOf(one: SurfaceSettings): string {
    return one.dataset || this.settings!.dataset;
  }

  // The rows that match the search, and the surfaces of the selected ones.
  private listed(): FoundLabel[] {
    return this.found.filter(({ at }) => !this.rows.get(at)!.element.hidden);
  }

  private selected(): number[] {
    return this.listed()
      .filter(({ key }) => this.selection.has(key))
      .map(({ at }) => at);
  }

  // Returns the surfaces that a control in this row changes.
  private targets(at: number): Set<number> {
    const selected = this.selected();
    return new Set(selected.includes(at) ? selected : [at]);
  }

  private changeTargets(at: number, look: LabelLook): void {
    const changed = this.targets(at);
    this.change(withAllSurfaces(this.settings!, (_, other) => (changed.has(other) ? look : null)));
  }

  private isolate(at: number): void {
    const kept = this.targets(at);
    this.changeAll((other) => ({ visible: kept.has(other) }));
  }

  private rename(dataset: string, name: string): void {
    const label = labelOf(this.datasets, dataset);
    if (label) this.change({ labelNames: withLabelName(this.settings!.labelNames, label.value, name === label.name ? "" : name) });
  }

  private click(key: string, { ctrlKey, metaKey, shiftKey }: MouseEvent): void {
    if (shiftKey)
      return this.selection.extend(
        key,
        this.listed().map((one) => one.key),
      );
    if (ctrlKey || metaKey) return this.selection.toggle(key);
    this.selection.select(key);
    this.events.zoomToLabel(key);
  }

  private press(event: KeyboardEvent): void {
    const { rows, selection } = this;
    const names = this.listed();
    const at = names.findIndex((one) => rows.get(one.at)!.name === event.target);
    if (at < 0) return;
    const { key, ctrlKey, metaKey, shiftKey } = event;
    const step = { ArrowUp: -1, ArrowDown: 1 }[key];
    if (step) {
      const next = names[at + step];
      if (next) rows.get(next.at)!.name.focus();
      if (next && shiftKey)
        selection.extend(
          next.key,
          names.map((one) => one.key),
          names[at].key,
        );
      else if (next && !ctrlKey && !metaKey) selection.select(next.key);
    } else if (key === " ") selection.toggle(names[at].key);
    else if (key === "a" && (ctrlKey || metaKey)) selection.selectAll(names.map((one) => one.key));
    else if (key !== "Escape" || !selection.clear()) return;
    event.preventDefault();
    event.stopPropagation();
  }

  // ---- the table

  private showAll(): void {
    if (!this.settings) return;
    const isNew = this.rows.size === 0;
    this.findLabels(this.settings);
    this.shown.hidden = this.found.length === 0;
    this.found.forEach(({ at, one, label }, place) => {
      const row = this.rows.get(at) ?? this.addRow(at);
      if (this.list.children[place] !== row.element) this.list.insertBefore(row.element, this.list.children[place] ?? null);
      row.show(one, label);
    });
    const shown = this.found.filter(({ one }) => one.visible);
    if (isNew && shown.length > 0 && shown[0] !== this.found[0]) {
      this.list.scrollTop = this.rows.get(shown[0].at)!.element.offsetTop - this.list.offsetTop;
    }
    this.showControls(shown);
    this.showFound();
  }

  // Removes the rows of others.
  private findLabels(settings: Settings): void {
    const { datasets, order } = this;
    const infos = new Map(datasets.map((info) => [info.name, info]));
    const labels = settings.surfaces.flatMap((one, at): FoundLabel[] => {
      const key = this.datasetOf(one);
      const label = (infos.get(key) ?? findByName(datasets, key))?.member?.label;
      return label ? [{ at, key, one, label: renamedLabel(label, settings.labelNames) }] : [];
    });
    const places = new Set(labels.map(({ at }) => at));
    for (const [at, row] of this.rows) {
      if (places.has(at)) continue;
      row.element.remove();
      this.rows.delete(at);
    }
    order.hidden = !labels.some(({ label }) => label.samples > 0n);
    this.found = inOrder(labels, order.hidden ? "value" : order.value);
  }

  private addRow(at: number): LabelRow {
    const dataset = () => this.datasetOf(this.settings!.surfaces[at]);
    const row = labelRow({
      change: (look) => this.changeTargets(at, look),
      isolate: () => this.isolate(at),
      click: (event) => this.click(dataset(), event),
      rename: (name) => this.rename(dataset(), name),
    });
    this.rows.set(at, row);
    return row;
  }

  private showControls(shown: FoundLabel[]): void {
    const { found } = this;
    this.filter.show({
      minComponent: Math.max(0, ...found.map(({ one }) => hiddenPartsOf(one).minComponent)),
      places: found.flatMap(({ one }) => one.hiddenParts),
    });
    this.count.textContent = `${shown.length} of ${found.length} shown`;
    this.search.hidden = found.length < fewLabels;
    this.limit.hidden = found.length <= maxInitialLabels;
    this.limit.textContent = `The first ${maxInitialLabels} labels are shown initially, each as a separate surface. "All" shows the rest.`;
    const opacities = shown.map(({ one }) => one.opacity);
    const isMixed = new Set(opacities).size > 1;
    this.mixed.hidden = !isMixed;
    this.opacity.show(opacities.length > 0 ? Math.max(...opacities) : 1, isMixed);
  }

  private showFound(): void {
    const words = this.search.value.trim().toLowerCase();
    for (const row of this.rows.values()) row.element.hidden = !row.element.dataset.label!.toLowerCase().includes(words);
    this.showSelected();
  }

  private showSelected(): void {
    const { length } = this.selected();
    for (const { at, key } of this.found) this.rows.get(at)!.showSelected(this.selection.has(key));
    this.table.textContent = length > 1 ? `Table of ${length} (CSV)` : "Table (CSV)";
  }
}

// Keys and display names.
const labelOrders = [
  ["value", "by number"],
  ["size", "largest first"],
  ["name", "by name"],
] as const;

interface FoundLabel {
  at: number; // The index of its surface.
  key: string; // The name of its dataset.
  one: SurfaceSettings;
  label: Label;
}

// Labels of equal size or name stay in order of their values.
function inOrder(found: FoundLabel[], order: string): FoundLabel[] {
  if (order === "size") return [...found].sort((a, b) => Number(b.label.samples - a.label.samples));
  if (order === "name") return [...found].sort((a, b) => labelName(a.label).localeCompare(labelName(b.label), "en", { numeric: true }));
  return found;
}
