// The list of surfaces: color, isovalue, opacity, error, visibility and state. Their lines are in the histogram.
import type { DatasetInfo } from "../protocol/messages";
import { button, h } from "../shared/elements";
import { grouped, roundedWithin } from "../shared/quantities";
import { mainTissues, tissueAtValue, type WindowedDataset } from "../shared/sample_window";
import { hiddenPartsOf } from "../state/hidden_parts";
import { imageBeside, withImage } from "../state/label_surfaces";
import type { Progress } from "../state/progress";
import { channelColor, findByName, isSameSeries, labelOf } from "../state/series";
import { materials, type Settings, type SurfaceSettings } from "../state/settings";
import { maxSurfaces, withAddedSurface, withMaterial, withOtherDataset, withoutSurface, withSurface } from "../state/surfaces";
import { suggestedIsovalue } from "../stream/request";
import { accuracyOf } from "./certificate";
import { componentFilter, componentsText, hidesAny } from "./component_filter";
import { datasetSelect } from "./dataset_select";
import { type Control, colorInput, eyeButton, opacitySlider } from "./inputs";
import { numberInput } from "./number_input";
import type { Change, PanelSection } from "./panel_section";

export interface SurfacesPart extends PanelSection {
  readonly isEmpty: boolean; // Only labels are shown, and there is no image beside them.
  showProgress: (surface: number, progress: Progress) => void;
}

export function surfacesPart(change: Change): SurfacesPart {
  let settings: Settings;
  let info: DatasetInfo | null = null;
  let datasets: readonly DatasetInfo[] = [];
  const rows = new Map<number, Row>(); // Labels have their own list.
  const list = h("ul", { class: "surfaces" });
  let image: DatasetInfo | null = null; // The image beside labels that are shown alone.
  const isLabel = ({ dataset }: SurfaceSettings) => labelOf(datasets, dataset || settings.dataset) !== null;
  const addOne = () => {
    if (image) change(withImage(settings, image));
    else if (info) change(withAddedSurface(settings, unusedIsovalue(info), suggestedIsovalue(info), isLabel));
  };
  const add = button("Add a surface", addOne, { class: "action", "data-tip": "Skin around bone, for example, or another channel." });
  const unusedIsovalue = (of: DatasetInfo) =>
    nextIsovalue(
      settings.surfaces.filter(({ dataset }) => !dataset).map(({ isovalue }) => isovalue ?? suggestedIsovalue(of)),
      of,
    );
  const rowAt = (at: number) => {
    const changeRow = (changes: Partial<SurfaceSettings>, isDragging?: boolean) => change(withSurface(settings, at, changes), isDragging);
    const row = surfaceRow(
      at,
      changeRow,
      (name) => {
        if (!name && info) return changeRow({ dataset: "", isovalue: unusedIsovalue(info) });
        const other = findByName(datasets, name);
        if (other) change(withOtherDataset(settings, at, { dataset: name, isovalue: suggestedIsovalue(other), ...channelColor(other) }));
      },
      () => {
        change(withoutSurface(settings, at));
        add.focus(); // The focused button was removed.
      },
    );
    list.append(row.element);
    rows.set(at, row);
    return row;
  };
  return {
    elements: [list, add],
    get isEmpty() {
      return add.hidden && rows.size === 0;
    },
    show: ({ settings: now, info: shown, list: known }) => {
      settings = now;
      info = shown;
      datasets = known;
      // Before the list of datasets arrives, it is unknown which surfaces are labels.
      const surfaces = datasets.length > 0 ? now.surfaces : now.surfaces.slice(0, maxSurfaces);
      for (const [at, row] of rows) {
        if (surfaces[at] && !isLabel(surfaces[at])) continue;
        row.element.remove();
        rows.delete(at);
      }
      surfaces.forEach((surface, at) => {
        if (isLabel(surface)) return;
        const isovalue = surface.isovalue ?? (shown && suggestedIsovalue(shown));
        const row = rows.get(at) ?? rowAt(at);
        row.show({ ...surface, isovalue }, surfaces.length > 1);
        row.showDatasets(datasets, shown);
      });
      image = shown && imageBeside(datasets, shown);
      add.textContent = image ? `Add a surface of ${image.member?.series || image.name}` : "Add a surface";
      add.hidden = rows.size >= maxSurfaces || (image === null && shown?.member?.label !== undefined);
    },
    showProgress: (surface, progress) => rows.get(surface)?.showProgress(progress),
  };
}

// Returns, for bodies, the first suggested value of skin or bone if not shown; otherwise, the suggested value farthest
// from the used ones, of tissue rather than air; without suggestions, a value between the last used one and the maximum.
export function nextIsovalue(used: readonly number[], info: WindowedDataset & Pick<DatasetInfo, "suggestedIsovalues">): number {
  const { suggestedIsovalues, min, max } = info;
  const distance = (value: number) => Math.min(...used.map((other) => Math.abs(other - value)));
  const shownTissues = used.map((value) => tissueAtValue(value, info));
  const rank = (value: number) => {
    const tissue = tissueAtValue(value, info);
    if (tissue === "" || shownTissues.includes(tissue)) return 0;
    return mainTissues.includes(tissue) ? 2 : 1;
  };
  const unused = suggestedIsovalues.filter((value) => !used.includes(value));
  const best = Math.max(...unused.map(rank));
  const fresh = unused.filter((value) => rank(value) === best);
  if (best === 2) return fresh[0];
  if (fresh.length === 0) return roundedWithin((Math.max(...used) + max) / 2, max - min);
  return fresh.reduce((best, value) => (distance(value) > distance(best) ? value : best));
}

interface Row extends Pick<Control<SurfaceSettings>, "element"> {
  show: (surface: SurfaceSettings, isOneOfSeveral: boolean) => void;
  showDatasets: (list: readonly DatasetInfo[], info: DatasetInfo | null) => void;
  showProgress: (progress: Progress) => void;
}

function surfaceRow(
  at: number,
  change: (changes: Partial<SurfaceSettings>, isDragging?: boolean) => void,
  chooseDataset: (dataset: string) => void,
  remove: () => void,
): Row {
  const name = `surface ${at + 1}`;
  const color = colorInput(`Color of ${name}`, (value) => change({ color: value }));
  const isovalue = numberInput(`Isovalue of ${name}`, (value) => change({ isovalue: value }));
  const error = numberInput(
    `Allowed error of ${name}, in voxels`,
    (value) => change({ error: Math.max(0, value) }),
    () => change({ error: null }),
  );
  error.element.setAttribute("data-tip", "The allowed error in voxels; empty: that of all surfaces.");
  error.element.setAttribute("placeholder", "error");
  const opacity = opacitySlider(name, (value) => change({ opacity: value }));
  const eye = eyeButton((visible) => change({ visible }));
  eye.element.setAttribute("aria-label", `Show ${name}`);
  eye.element.setAttribute("data-tip", "Shows or hides the surface.");
  const cross = button("×", remove, { class: "cross", "aria-label": `Remove ${name}` });
  const choose = () => change(withMaterial({ color: ofColor }, materials.find((word) => word === material.value)!));
  const material = h(
    "select",
    { "aria-label": `Material of ${name}`, class: "material", "data-tip": "How it reflects light.", change: choose },
    ...materials.map((word) => h("option", { value: word }, word[0].toUpperCase() + word.slice(1))),
  );
  const filter = componentFilter(name, {
    hide: (minComponent) => change({ minComponent }),
    showHidden: () => change({ hiddenParts: [] }),
    keepLargest: (isOn) => change({ minComponent: isOn ? "largest" : 0 }),
  });
  const state = h("span", { class: "surface-state" });
  const dataset = datasetSelect(`Data of ${name}`, "The same data", chooseDataset, isOtherData);
  dataset.element.classList.add("surface-dataset");
  dataset.element.setAttribute("data-tip", "Another channel or field, or another dataset in the same world.");
  let ofDataset = "";
  let ofColor = "";
  const element = h(
    "li",
    { class: "surface-row" },
    dataset.element,
    color.element,
    isovalue.element,
    opacity.element,
    eye.element,
    cross,
    state,
    error.element,
    filter.element,
    material,
  );
  return {
    element,
    show: (surface, isOneOfSeveral) => {
      ofDataset = surface.dataset;
      ofColor = surface.color;
      color.show(surface.color);
      isovalue.show(surface.isovalue);
      error.show(surface.error);
      opacity.show(surface.opacity);
      material.value = surface.material;
      eye.show(surface.visible);
      filter.show(hiddenPartsOf(surface));
      cross.hidden = filter.element.hidden = !isOneOfSeveral;
    },
    showDatasets: (list, info) => {
      dataset.element.hidden = dataset.show(list, info, ofDataset) === 0 || at === 0;
    },
    showProgress: ({ shown, components, isStreaming, failure, sizeToConfirm }) => {
      const limit = sizeToConfirm ? ", the best of this size" : "";
      const hidden = hidesAny(components) ? `, ${componentsText(components)}` : "";
      const count = grouped(components?.triangles ?? shown?.triangles ?? 0);
      const accuracy = shown ? accuracyOf(shown, 2) : null;
      const triangles = accuracy ? `${count} triangles, ${accuracy.value} ${accuracy.unit}${limit}${hidden}` : "";
      const text = failure?.text ?? (isStreaming ? `${triangles || "waiting"}…` : triangles);
      if (state.textContent !== text) state.textContent = text;
    },
  };
}

// Whether surfaces of a dataset can be shown beside the surfaces of another one, except as another isovalue of it.
function isOtherData(one: DatasetInfo, info: DatasetInfo): boolean {
  return !one.member?.label && !(isSameSeries(one, info) && one.member?.field === info.member?.field);
}
