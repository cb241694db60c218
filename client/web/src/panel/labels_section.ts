// The labels of a segmentation: of each its color, name, size, opacity and whether it is shown. Those that are hidden are
// not loaded.
import type { DatasetInfo, Label } from "../protocol/messages";
import { labelName, labelOf, mostLabelsAtFirst, named } from "../state/series";
import type { Progress } from "../state/progress";
import type { Settings } from "../state/settings";
import { type SurfaceSettings, surfacesOf, withAllSurfaces, withSurface } from "../state/surfaces";
import { h } from "../shared/elements";
import { grouped } from "../shared/quantities";
import { componentFilter } from "./component_filter";
import type { Change, PanelSection } from "./panel_section";

const fewLabels = 8; // Need no search.

export interface LabelsPart extends PanelSection {
  showProgress: (surface: number, progress: Progress) => void;
  showDatasets: (list: readonly DatasetInfo[]) => void;
  highlight: (surface: number) => void; // That was clicked in the picture; its row is brought into view.
}

export interface LabelsEvents {
  saveLabels: () => void; // A table of the labels that are shown.
  zoomToLabel: (dataset: string) => void;
}

export function labelsPart(change: Change, { saveLabels, zoomToLabel }: LabelsEvents): LabelsPart {
  let settings: Settings | null = null;
  let datasets: readonly DatasetInfo[] = [];
  const rows = new Map<number, LabelRow>();
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
  const table = h("button", { type: "button", "data-tip": "Volume and area of every label that is shown, as CSV." }, "Table (CSV)");
  table.addEventListener("click", saveLabels);
  const order = h("select", { class: "label-order", "aria-label": "Order of the labels" },
    ...labelOrders.map(([word, text]) => h("option", { value: word }, text)));
  order.addEventListener("change", () => showAll());
  const limit = h("p", { class: "hint", hidden: true });
  const isolate = (kept: number) =>
    change(withAllSurfaces(settings!, (one, at) => (isLabel(one, at) ? { visible: at === kept } : null)));
  const showFound = () => {
    const words = search.value.trim().toLowerCase();
    for (const row of rows.values()) row.element.hidden = !row.element.dataset.label!.toLowerCase().includes(words);
  };
  search.addEventListener("input", showFound);
  const opacity = opacityOf("all labels", (value) =>
    change(withAllSurfaces(settings!, (one, at) => (isLabel(one, at) ? { opacity: value } : null))));
  const filter = componentFilter("all labels", {
    hide: (minComponent) => change(withAllSurfaces(settings!, (one, at) => (isLabel(one, at) ? { minComponent } : null))),
    showHidden: () => change(withAllSurfaces(settings!, (one, at) => (isLabel(one, at) ? { hiddenParts: [] } : null))),
  });
  const head = h("div", { class: "chips labels-head" },
    all("All", "Shows every label.", true), all("None", "Hides every label.", false), table, count, order, opacity);
  const rowAt = (at: number) => {
    const row = labelRow((changes) => change(withSurface(settings!, at, changes)), () => isolate(at),
      () => zoomToLabel(dataset(surfacesOf(settings!)[at], at)));
    rows.set(at, row);
    return row;
  };
  const showAll = () => {
    if (!settings) return;
    const infos = new Map(datasets.map((info) => [info.name, info]));
    const found = surfacesOf(settings).flatMap((one, at) => {
      const name = dataset(one, at);
      const label = (infos.get(name) ?? named(datasets, name))?.member?.label;
      return label ? [{ at, one, label }] : [];
    });
    const places = new Set(found.map(({ at }) => at));
    for (const [at, row] of rows) {
      if (places.has(at)) continue;
      row.element.remove();
      rows.delete(at);
    }
    order.hidden = !found.some(({ label }) => label.samples > 0n);
    inOrder(found, order.hidden ? "value" : order.value).forEach(({ at, one, label }, place) => {
      const row = rows.get(at) ?? rowAt(at);
      if (list.children[place] !== row.element) list.insertBefore(row.element, list.children[place] ?? null);
      row.show(one, label);
    });
    filter.show({
      minComponent: Math.max(0, ...found.map(({ one }) => one.minComponent ?? 0)),
      places: found.flatMap(({ one }) => one.hiddenParts ?? []),
    });
    const shown = found.filter(({ one }) => one.visible);
    count.textContent = `${shown.length} of ${found.length} shown`;
    search.hidden = found.length < fewLabels;
    limit.hidden = found.length <= mostLabelsAtFirst;
    limit.textContent = `The first ${mostLabelsAtFirst} are shown at first: each is a surface of its own. "All" shows the rest.`;
    showFound();
    showOpacity(opacity, shown.length > 0 ? Math.max(...shown.map(({ one }) => one.opacity)) : 1);
  };
  return {
    elements: [head, search, limit, list, filter.element],
    show: (now) => {
      settings = now;
      showAll();
    },
    showProgress: (surface, progress) => rows.get(surface)?.showProgress(progress),
    highlight: (surface) => {
      for (const [at, { element }] of rows) {
        element.classList.toggle("is-picked", at === surface);
        if (at !== surface) continue;
        element.hidden = false;
        element.scrollIntoView({ block: "nearest" });
      }
    },
    showDatasets: (now) => {
      datasets = now;
    },
  };
}

// Words of the settings' kind, and what people read.
const labelOrders = [["value", "by number"], ["size", "largest first"], ["name", "by name"]] as const;

interface FoundLabel {
  at: number;
  one: SurfaceSettings;
  label: Label;
}

// Labels of equal size or name stay in the order of their values.
function inOrder(found: FoundLabel[], order: string): FoundLabel[] {
  if (order === "size") return [...found].sort((a, b) => Number(b.label.samples - a.label.samples));
  if (order === "name") return [...found].sort((a, b) => labelName(a.label).localeCompare(labelName(b.label), "en", { numeric: true }));
  return found;
}

interface LabelRow {
  element: HTMLElement;
  show: (surface: SurfaceSettings, label: Label) => void;
  showProgress: (progress: Progress) => void;
}

function labelRow(change: (changes: Partial<SurfaceSettings>) => void, isolate: () => void, zoom: () => void): LabelRow {
  const color = h("input", { type: "color" });
  color.addEventListener("input", () => change({ color: color.value }));
  const name = h("button", { type: "button", class: "label-name", "data-tip": "Zooms to the label." });
  name.addEventListener("click", zoom);
  const opacity = opacityOf("", (value) => change({ opacity: value }));
  const eye = h("button", { type: "button", class: "eye" });
  const only = h("button", { type: "button", class: "only", "data-tip": "Shows this label alone." }, "only");
  let isVisible = true;
  eye.addEventListener("click", () => change({ visible: !isVisible }));
  const element = h("li", { class: "label-row" }, eye, color, name, only, opacity);
  only.addEventListener("click", isolate);
  let hasFinal = false;
  let size = "";
  const showComing = () => element.classList.toggle("is-coming", isVisible && !hasFinal);
  return {
    element,
    showProgress: ({ shown, isStreaming, failure }) => {
      hasFinal = failure !== null || (!isStreaming && shown?.isFinal === true);
      name.title = failure?.text ?? size;
      showComing();
    },
    show: (surface, label) => {
      const word = labelName(label);
      isVisible = surface.visible;
      showComing();
      if (name.textContent !== word) {
        name.textContent = element.dataset.label = word;
        size = name.title = label.samples > 0n ? `${word}: ${grouped(Number(label.samples))} samples` : word;
        name.setAttribute("aria-label", `Zoom to ${word}`);
        eye.setAttribute("aria-label", `Show ${word}`);
        color.setAttribute("aria-label", `Color of ${word}`);
        only.setAttribute("aria-label", `Show only ${word}`);
        opacity.setAttribute("aria-label", `Opacity of ${word}`);
      }
      color.value = surface.color;
      eye.setAttribute("aria-pressed", String(isVisible));
      eye.textContent = isVisible ? "◉" : "○";
      showOpacity(opacity, surface.opacity);
    },
  };
}

function opacityOf(what: string, turned: (value: number) => void): HTMLInputElement {
  const input = h("input", { type: "range", min: "0", max: "1", step: "0.01", "aria-label": `Opacity of ${what}` });
  input.setAttribute("data-tip", "The opacity of the surface.");
  input.addEventListener("input", () => turned(Number(input.value)));
  return input;
}

function showOpacity(input: HTMLInputElement, opacity: number): void {
  input.value = String(opacity);
  input.setAttribute("aria-valuetext", `${Math.round(100 * opacity)} %`);
  input.style.setProperty("--share", `${100 * opacity}%`);
}
