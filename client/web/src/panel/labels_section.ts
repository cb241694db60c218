// The labels of a segmentation: color, name, size, opacity and visibility of each. Hidden labels are not loaded.
import type { DatasetInfo, Label } from "../protocol/messages";
import { labelName, labelOf, maxInitialLabels, findByName, renamedLabel, withLabelName } from "../state/series";
import type { Progress } from "../state/progress";
import { maxNoteLength, type Settings } from "../state/settings";
import { type SurfaceSettings, surfacesOf, withAllSurfaces, withSurface } from "../state/surfaces";
import { h } from "../shared/elements";
import { grouped } from "../shared/quantities";
import { componentFilter } from "./component_filter";
import type { Change, PanelSection } from "./panel_section";

const fewLabels = 8; // At most this many need no search.

export interface LabelsPart extends PanelSection {
  showProgress: (surface: number, progress: Progress) => void;
  showDatasets: (list: readonly DatasetInfo[]) => void;
  highlight: (surface: number) => void; // Scrolls to the row of a surface that was clicked.
}

export interface LabelsEvents {
  saveLabels: () => void; // As a table of the visible labels.
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
  const table = h("button", { type: "button", "data-tip": "Volume and area of every displayed label, as CSV." }, "Table (CSV)");
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
    const row = labelRow((changes) => change(withSurface(settings!, at, changes)), () => isolate(at), () => zoomToLabel(own()), rename);
    rows.set(at, row);
    return row;
  };
  const showAll = () => {
    if (!settings) return;
    const infos = new Map(datasets.map((info) => [info.name, info]));
    const found = surfacesOf(settings).flatMap((one, at) => {
      const name = dataset(one, at);
      const label = (infos.get(name) ?? findByName(datasets, name))?.member?.label;
      return label ? [{ at, one, label: renamedLabel(label, settings!.labelNames) }] : [];
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

// Keys and display names.
const labelOrders = [["value", "by number"], ["size", "largest first"], ["name", "by name"]] as const;

interface FoundLabel {
  at: number;
  one: SurfaceSettings;
  label: Label;
}

// Labels of equal size or name stay in order of their values.
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

function labelRow(
  change: (changes: Partial<SurfaceSettings>) => void, isolate: () => void, zoom: () => void, rename: (name: string) => void,
): LabelRow {
  const color = h("input", { type: "color" });
  color.addEventListener("input", () => change({ color: color.value }));
  const name = h("button", { type: "button", class: "label-name", "data-tip": "Zooms to the label. Double-click or F2: rename." });
  name.addEventListener("click", zoom);
  name.addEventListener("dblclick", () => editName(name, rename));
  name.addEventListener("keydown", ({ key }) => key === "F2" && editName(name, rename));
  const opacity = opacityOf("", (value) => change({ opacity: value }));
  const eye = h("button", { type: "button", class: "eye" });
  const only = h("button", { type: "button", class: "only", "data-tip": "Shows only this label." }, "only");
  let isVisible = true;
  eye.addEventListener("click", () => change({ visible: !isVisible }));
  const element = h("li", { class: "label-row" }, eye, color, name, only, opacity);
  only.addEventListener("click", isolate);
  let hasFinal = false;
  let size = "";
  let isComing = false;
  const showComing = () => {
    if (isComing !== (isComing = isVisible && !hasFinal)) element.classList.toggle("is-coming", isComing);
  };
  return {
    element,
    showProgress: ({ shown, isStreaming, failure }) => {
      hasFinal = failure !== null || (!isStreaming && shown?.isFinal === true);
      const title = failure?.text ?? size;
      if (name.title !== title) name.title = title;
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

// Replaces the name by an input; an empty input restores the file's name.
function editName(name: HTMLElement, rename: (name: string) => void): void {
  const input = h("input", { type: "text", class: "label-rename", maxlength: String(maxNoteLength), "aria-label": `Name of ${name.textContent}` });
  input.value = name.textContent ?? "";
  let hasEnded = false; // Removing an input also blurs it.
  const end = (isTaken: boolean) => {
    if (hasEnded) return;
    hasEnded = true;
    const given = input.value.trim();
    input.replaceWith(name);
    if (isTaken && given !== name.textContent) rename(given);
  };
  input.addEventListener("blur", () => end(true));
  input.addEventListener("keydown", (event) => {
    event.stopPropagation(); // Typed letters must not trigger shortcuts.
    if (event.key === "Enter" || event.key === "Escape") end(event.key === "Enter");
  });
  name.replaceWith(input);
  input.select();
}

function opacityOf(what: string, turned: (value: number) => void): HTMLInputElement {
  const input = h("input", { type: "range", min: "0", max: "1", step: "0.01", "aria-label": `Opacity of ${what}` });
  input.setAttribute("data-tip", "The opacity of the surface.");
  input.addEventListener("input", () => turned(Number(input.value)));
  return input;
}

// `isMixed`: surfaces with different opacities; the slider shows the largest.
function showOpacity(input: HTMLInputElement, opacity: number, isMixed = false): void {
  input.value = String(opacity);
  input.setAttribute("aria-valuetext", isMixed ? "mixed" : `${Math.round(100 * opacity)} %`);
  input.style.setProperty("--share", `${100 * opacity}%`);
}
