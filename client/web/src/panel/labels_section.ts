// The table of the labels of a segmentation. Hidden labels are not loaded. Changes of a selected label apply to all
// selected ones.
import type { DatasetInfo, Label } from "../protocol/messages";
import { findByName, labelName, labelOf, maxInitialLabels, renamedLabel, withLabelName } from "../state/series";
import { hiddenPartsOf } from "../state/hidden_parts";
import type { Progress } from "../state/progress";
import type { Settings } from "../state/settings";
import { type SurfaceSettings, surfacesOf, withAllSurfaces } from "../state/surfaces";
import { h } from "../shared/elements";
import { componentFilter } from "./component_filter";
import { type LabelLook, type LabelRow, labelRow, opacitySlider, showOpacity } from "./label_row";
import type { Change, PanelSection } from "./panel_section";
import { RowSelection } from "./row_selection";

const fewLabels = 8; // At most this many need no search.

export interface LabelsPart extends PanelSection {
  showProgress: (surface: number, progress: Progress) => void;
  showDatasets: (list: readonly DatasetInfo[]) => void;
  select: (surface: number) => void; // Selects and scrolls to the row of a surface that was clicked.
}

export interface LabelsEvents {
  saveLabels: (surfaces: readonly number[] | null) => void; // As a table of those that are visible; null: of all.
  zoomToLabel: (dataset: string) => void;
}

export function labelsPart(change: Change, { saveLabels, zoomToLabel }: LabelsEvents): LabelsPart {
  let settings: Settings | null = null;
  let datasets: readonly DatasetInfo[] = [];
  const rows = new Map<number, LabelRow>();
  let found: FoundLabel[] = []; // In the order of the table.
  const selection = new RowSelection(() => showSelected());
  const list = h("ul", { class: "labels" });
  const count = h("span", { class: "labels-count" });
  const isLabel = (one: SurfaceSettings, at: number) => labelOf(datasets, dataset(one, at)) !== null;
  const dataset = (one: SurfaceSettings, at: number) => (at > 0 && one.dataset) || settings!.dataset;
  const all = (word: string, tip: string, visible: boolean) => {
    const button = h("button", { type: "button", "data-tip": tip }, word);
    button.addEventListener("click", () => change(withAllSurfaces(settings!, (one, at) => (isLabel(one, at) ? { visible } : null))));
    return button;
  };
  const search = h("input", { type: "search", class: "label-search", placeholder: "Search labels", "aria-label": "Search labels" });
  const table = h("button", { type: "button", "data-tip": "Samples of all labels, volume and area of those displayed, or of several selected ones, as CSV." }, "Table (CSV)");
  // A single selected label is one that was looked at: the table then still has all.
  table.addEventListener("click", () => saveLabels(selected().length > 1 ? selected() : null));
  const order = h("select", { class: "label-order", "aria-label": "Order of the labels" },
    ...labelOrders.map(([word, text]) => h("option", { value: word }, text)));
  order.addEventListener("change", () => showAll());
  const limit = h("p", { class: "hint", hidden: true });
  // The rows that match the search, and the surfaces of the selected ones.
  const listed = () => found.filter(({ at }) => !rows.get(at)!.element.hidden);
  const selected = () => listed().filter(({ key }) => selection.has(key)).map(({ at }) => at);
  // Returns the surfaces that a control in this row changes.
  const targets = (at: number) => new Set(selected().includes(at) ? selected() : [at]);
  const changeLabels = (at: number, look: LabelLook) => {
    const changed = targets(at);
    change(withAllSurfaces(settings!, (_, other) => (changed.has(other) ? look : null)));
  };
  const isolate = (at: number) => {
    const kept = targets(at);
    change(withAllSurfaces(settings!, (one, other) => (isLabel(one, other) ? { visible: kept.has(other) } : null)));
  };
  const click = (key: string, { ctrlKey, metaKey, shiftKey }: MouseEvent) => {
    if (shiftKey) return selection.extend(key, listed().map((one) => one.key));
    if (ctrlKey || metaKey) return selection.toggle(key);
    selection.select(key);
    zoomToLabel(key);
  };
  const showFound = () => {
    const words = search.value.trim().toLowerCase();
    for (const row of rows.values()) row.element.hidden = !row.element.dataset.label!.toLowerCase().includes(words);
    showSelected();
  };
  const showSelected = () => {
    const { length } = selected();
    for (const { at, key } of found) rows.get(at)!.showSelected(selection.has(key));
    table.textContent = length > 1 ? `Table of ${length} (CSV)` : "Table (CSV)";
  };
  search.addEventListener("input", showFound);
  const opacity = opacitySlider("all labels", (value) =>
    change(withAllSurfaces(settings!, (one, at) => (isLabel(one, at) ? { opacity: value } : null))));
  const mixed = h("span", { class: "labels-count", hidden: true }, "mixed");
  const filter = componentFilter("all labels", {
    hide: (minComponent) => change(withAllSurfaces(settings!, (one, at) => (isLabel(one, at) ? { minComponent } : null))),
    showHidden: () => change(withAllSurfaces(settings!, (one, at) => (isLabel(one, at) ? { hiddenParts: [] } : null))),
  });
  const head = h("div", { class: "chips labels-head" },
    all("All", "Shows every label.", true), all("None", "Hides every label.", false), table, count, order, opacity, mixed);
  const rowAt = (at: number) => {
    const own = () => dataset(surfacesOf(settings!)[at], at);
    const rename = (name: string) => {
      const label = labelOf(datasets, own());
      if (label) change({ labelNames: withLabelName(settings!.labelNames, label.value, name === label.name ? "" : name) });
    };
    const row = labelRow({
      change: (look) => changeLabels(at, look), isolate: () => isolate(at), click: (event) => click(own(), event), rename,
    });
    rows.set(at, row);
    return row;
  };
  list.addEventListener("keydown", (event) => {
    const names = listed();
    const at = names.findIndex((one) => rows.get(one.at)!.name === event.target);
    if (at < 0) return;
    const { key, ctrlKey, metaKey, shiftKey } = event;
    const step = { ArrowUp: -1, ArrowDown: 1 }[key];
    if (step) {
      const next = names[at + step];
      if (next) rows.get(next.at)!.name.focus();
      if (next && shiftKey) selection.extend(next.key, names.map((one) => one.key), names[at].key);
      else if (next && !ctrlKey && !metaKey) selection.select(next.key);
    } else if (key === " ") selection.toggle(names[at].key);
    else if (key === "a" && (ctrlKey || metaKey)) selection.selectAll(names.map((one) => one.key));
    else if (key !== "Escape" || !selection.clear()) return;
    event.preventDefault();
    event.stopPropagation();
  });
  // Space would click the name.
  list.addEventListener("keyup", (event) => event.key === " " && (event.target as Element).matches(".label-name") && event.preventDefault());
  const scrollTo = ({ at }: FoundLabel) => {
    list.scrollTop = rows.get(at)!.element.offsetTop - list.offsetTop;
  };
  const showAll = () => {
    if (!settings) return;
    const infos = new Map(datasets.map((info) => [info.name, info]));
    const labels = surfacesOf(settings).flatMap((one, at): FoundLabel[] => {
      const name = dataset(one, at);
      const label = (infos.get(name) ?? findByName(datasets, name))?.member?.label;
      return label ? [{ at, key: name, one, label: renamedLabel(label, settings!.labelNames) }] : [];
    });
    const isNew = rows.size === 0;
    const places = new Set(labels.map(({ at }) => at));
    for (const [at, row] of rows) {
      if (places.has(at)) continue;
      row.element.remove();
      rows.delete(at);
    }
    order.hidden = !labels.some(({ label }) => label.samples > 0n);
    found = inOrder(labels, order.hidden ? "value" : order.value);
    found.forEach(({ at, one, label }, place) => {
      const row = rows.get(at) ?? rowAt(at);
      if (list.children[place] !== row.element) list.insertBefore(row.element, list.children[place] ?? null);
      row.show(one, label);
    });
    filter.show({
      minComponent: Math.max(0, ...found.map(({ one }) => hiddenPartsOf(one).minComponent)),
      places: found.flatMap(({ one }) => one.hiddenParts ?? []),
    });
    const shown = found.filter(({ one }) => one.visible);
    count.textContent = `${shown.length} of ${found.length} shown`;
    if (isNew && shown.length > 0 && shown[0] !== found[0]) scrollTo(shown[0]);
    search.hidden = found.length < fewLabels;
    limit.hidden = found.length <= maxInitialLabels;
    limit.textContent = `The first ${maxInitialLabels} labels are shown initially, each as a separate surface. "All" shows the rest.`;
    showFound();
    const opacities = shown.map(({ one }) => one.opacity);
    const isMixed = new Set(opacities).size > 1;
    mixed.hidden = !isMixed;
    showOpacity(opacity, opacities.length > 0 ? Math.max(...opacities) : 1, isMixed);
  };
  return {
    elements: [head, search, limit, list, filter.element],
    show: (now) => {
      settings = now;
      showAll();
    },
    showProgress: (surface, progress) => rows.get(surface)?.showProgress(progress),
    select: (surface) => {
      const label = found.find(({ at }) => at === surface);
      if (!label) return;
      const { element } = rows.get(surface)!;
      element.hidden = false;
      element.scrollIntoView({ block: "nearest" });
      selection.select(label.key);
    },
    showDatasets: (now) => {
      datasets = now;
    },
  };
}

// Keys and display names.
const labelOrders = [["value", "by number"], ["size", "largest first"], ["name", "by name"]] as const;

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
