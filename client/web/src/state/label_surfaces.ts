// The labels of a segmentation as surfaces: alone, or beside the surfaces of an image.
import type { DatasetInfo } from "../protocol/messages";
import { worldDifference } from "../stream/dataset";
import { labelColor } from "./label_colors";
import { labelRanges, labelsOfRanges, parseLabels } from "./label_ranges";
import { atTime, channelColor, type Entry, findByName, imageOf, isSameSeries, seriesOf } from "./series";
import { type AdditionalSurface, defaults, type Settings } from "./settings";
import { outerOpacity, surfacesOf } from "./surfaces";

export const labelIsovalue = 0.5; // The isovalue of every label's boundary.
export const maxInitialLabels = 24; // Labels shown by default.

export interface Segmentation {
  name: string; // The name of its series; with a single label that of its dataset.
  labels: readonly DatasetInfo[]; // By value.
}

// The settings when an entry is selected: all labels of a segmentation, otherwise one surface. If one label is named,
// only that one is visible.
export function settingsOfEntry({ info, series }: Entry, named: string | null = null): Partial<Settings> {
  const [first, ...others] = initialSurfaces(series?.labels ?? [], named);
  if (!first) return { dataset: info.name, isovalue: null, surfaces: [], ...channelColor(info) };
  const { dataset, color, opacity, visible } = first;
  return { dataset, isovalue: labelIsovalue, color, opacity, visible, surfaces: others };
}

// The settings when the user chooses an entry: also its default view.
export function settingsOfChoice(entry: Entry): Partial<Settings> {
  return {
    ...settingsOfEntry(entry),
    t: null,
    playing: false,
    region: null,
    minComponent: 0,
    hiddenParts: [],
    eye: null,
    target: null,
    up: defaults.up,
    clip: "off",
    clipNormal: null,
    crop: null,
    places: [],
    cross: null,
    samplesOf: "",
  };
}

// Returns the segmentations that can be shown beside the surfaces of an image: those in its world.
export function segmentationsBeside(list: readonly DatasetInfo[], info: DatasetInfo): Segmentation[] {
  if (info.member?.label) return [];
  const firsts = new Map<string, DatasetInfo>();
  for (const one of list) {
    const name = one.member?.label ? one.member.series || one.name : "";
    if (name && !firsts.has(name)) firsts.set(name, one);
  }
  return [...firsts].filter(([, one]) => worldDifference(info, one) === null).map(([name, one]) => ({ name, labels: seriesOf(list, one)?.labels ?? [one] }));
}

// Returns what the selection says of a segmentation that the address names and that cannot be shown; null: there is none.
export function absentSegmentation(list: readonly DatasetInfo[], { labels }: Settings): { name: string; words: string } | null {
  const name = parseLabels(labels)?.series;
  if (!name) return null;
  const isServed = list.some((one) => one.member?.label && (one.member.series || one.name) === name);
  return { name, words: isServed ? `${name}: in another place` : `${name}: not on this server yet` };
}

// Returns the image whose surfaces can be shown beside those of a segmentation: its own, or else the first one in its world.
export function imageBeside(list: readonly DatasetInfo[], info: DatasetInfo): DatasetInfo | null {
  if (!info.member?.label) return null;
  return imageOf(list, info) ?? list.find((one) => !one.member?.label && worldDifference(info, one) === null) ?? null;
}

// Replaces the labels beside the surfaces of an image. The image usually encloses them: its surface becomes translucent
// if it is opaque, and opaque again without labels. Null: shows none.
export function withSegmentation(list: readonly DatasetInfo[], settings: Settings, segmentation: Segmentation | null): Partial<Settings> {
  const labels = new Set(list.filter(({ member }) => member?.label).map(({ name }) => name));
  const surfaces = settings.surfaces.filter(({ dataset }) => !labels.has(dataset ?? ""));
  const { opacity } = settings;
  if (segmentation) {
    return { surfaces: [...surfaces, ...initialSurfaces(segmentation.labels)], opacity: opacity === 1 ? outerOpacity : opacity, labels: "" };
  }
  return { surfaces, opacity: surfaces.length === 0 && opacity === outerOpacity ? 1 : opacity, labels: "" };
}

// Shows the surface of an image beside the labels that are shown alone.
export function withImage(settings: Settings, image: DatasetInfo): Partial<Settings> {
  const labels = surfacesOf(settings).map((one) => ({
    ...one,
    isovalue: one.isovalue ?? labelIsovalue,
    dataset: one.dataset || settings.dataset,
    error: null,
  }));
  return {
    ...firstOnly(defaults),
    ...channelColor(image),
    dataset: image.name,
    isovalue: null,
    opacity: outerOpacity,
    surfaces: labels.map(withoutDefaults),
  };
}

// Returns the dataset that the settings name and the changes that follow: all labels of a segmentation if no surfaces
// are named, only one visible if it is named. Null: the dataset is not in the list.
export function initialSelection(list: readonly DatasetInfo[], settings: Settings): { info: DatasetInfo; changes: Partial<Settings> | null } | null {
  const { dataset, t } = settings;
  const found = dataset ? findByName(list, dataset) : list[0];
  if (!found) return null;
  const changes = found.member?.label ? changesOfLabels(list, found, settings) : changesOfImage(list, found, settings);
  const first = changes.dataset ? findByName(list, changes.dataset) : null;
  return { info: atTime(list, first ?? found, t), changes: Object.keys(changes).length > 0 ? changes : null };
}

function changesOfLabels(list: readonly DatasetInfo[], found: DatasetInfo, { dataset, surfaces, labels }: Settings): Partial<Settings> {
  const series = surfaces.length === 0 || labels !== "" ? seriesOf(list, found) : null;
  if (!series || series.labels.length < 2) return labels ? { labels: "" } : {};
  if (!labels) return settingsOfEntry({ name: series.name, info: found, series }, series.labels.find(({ name }) => name === dataset)?.name);
  const [first, ...others] = restored(series.labels, labels, surfaces);
  return { ...firstOnly({ ...defaults, ...first }), dataset: first.dataset, isovalue: first.isovalue, surfaces: others, labels: "" };
}

function changesOfImage(list: readonly DatasetInfo[], found: DatasetInfo, { color, labels, surfaces }: Settings): Partial<Settings> {
  const own = color === defaults.color ? channelColor(found) : {};
  if (!labels) return own;
  const beside = segmentationsBeside(list, found).find(({ name }) => name === parseLabels(labels)?.series);
  if (!beside) return parseLabels(labels)?.series ? own : { ...own, labels: "" }; // They may be prepared later.
  const names = new Set(beside.labels.map(({ name }) => name));
  const others = surfaces.filter(({ dataset }) => !names.has(dataset ?? ""));
  return { ...own, labels: "", surfaces: [...others, ...restored(beside.labels, labels, surfaces)] };
}

// Adds to a change of settings what follows for labels: named labels replace all shown surfaces, or the labels beside
// those of an image, and surfaces and their look do not stay between labels and another dataset. `shown`: the current
// dataset.
export function withLabelChanges(list: readonly DatasetInfo[], shown: DatasetInfo | null, now: Settings, change: Partial<Settings>): Partial<Settings> {
  const after = change.dataset ? findByName(list, change.dataset) : shown;
  const [was, is] = [shown?.member?.label !== undefined, after?.member?.label !== undefined];
  const isOther = shown && after && (isSameSeries(shown, after) ? was !== is : was || is);
  const all = isOther ? { ...firstOnly(defaults), isovalue: null, surfaces: [], ...change } : change;
  if (!all.labels) return all;
  const kept = after && !is ? withSegmentation(list, { ...now, ...all }, null).surfaces! : [];
  return { ...all, ...initialSelection(list, { ...now, surfaces: kept, ...all })?.changes };
}

// Shortens the settings of a segmentation for addresses: the visible labels, and as surfaces only labels whose look was
// changed. initialSelection() restores the settings.
export function withShortLabels(list: readonly DatasetInfo[], settings: Settings): Settings {
  const info = findByName(list, settings.dataset);
  if (!info) return settings;
  if (info.member?.label) {
    const surfaces = surfacesOf(settings).map((one, at) => ({
      ...one,
      isovalue: one.isovalue ?? labelIsovalue,
      dataset: one.dataset || info.name,
      error: at > 0 ? one.error : null,
    }));
    const labels = seriesOf(list, info)?.labels ?? [];
    const short = labels.length > 1 ? shortened(labels, surfaces) : null;
    return short ? { ...settings, ...firstOnly(defaults), isovalue: null, labels: short.ranges, surfaces: short.changed } : settings;
  }
  const datasets = new Set(settings.surfaces.map(({ dataset }) => dataset));
  const beside = segmentationsBeside(list, info).find(({ labels }) => labels.every(({ name }) => datasets.has(name)));
  if (!beside) return settings;
  const names = new Set(beside.labels.map(({ name }) => name));
  const isOfLabels = ({ dataset }: AdditionalSurface) => names.has(dataset ?? "");
  const short = shortened(beside.labels, settings.surfaces.filter(isOfLabels));
  const others = settings.surfaces.filter((one) => !isOfLabels(one));
  return short ? { ...settings, labels: `${beside.name}:${short.ranges}`, surfaces: [...others, ...short.changed] } : settings;
}

// Returns the visible labels as text, and the surfaces whose look was changed; null: the surfaces are not those of all
// labels, or text cannot name the labels.
function shortened(labels: readonly DatasetInfo[], surfaces: readonly AdditionalSurface[]): { ranges: string; changed: AdditionalSurface[] } | null {
  if (labels.length !== surfaces.length || labels.some(({ name }, at) => name !== surfaces[at].dataset)) return null;
  const values = labels.map(labelValue);
  const ranges = labelRanges(values, new Set(values.filter((_, at) => surfaces[at].visible)));
  const changed = surfaces.filter((one, at) => lookOf(one) !== lookOf(surfaceOfLabel(labels[at], one.visible)));
  return ranges === null ? null : { ranges, changed };
}

// Returns the surfaces that shortened() shortened.
function restored(labels: readonly DatasetInfo[], text: string, changed: readonly AdditionalSurface[]): AdditionalSurface[] {
  const ranges = parseLabels(text)?.ranges ?? "";
  const shown = labelsOfRanges(ranges, labels.map(labelValue));
  const others = new Map(changed.map((one) => [one.dataset, one]));
  return labels.map((one, at) => others.get(one.name) ?? surfaceOfLabel(one, ranges ? shown.has(labelValue(one)) : at < maxInitialLabels));
}

function initialSurfaces(labels: readonly DatasetInfo[], named: string | null = null): AdditionalSurface[] {
  return labels.map((one, at) => surfaceOfLabel(one, named ? one.name === named : at < maxInitialLabels));
}

function surfaceOfLabel({ name: dataset, member }: DatasetInfo, visible: boolean): AdditionalSurface {
  const { value, color } = member!.label!;
  return { dataset, isovalue: labelIsovalue, error: null, color: labelColor(value, color), opacity: defaults.opacity, visible };
}

function labelValue({ member }: DatasetInfo): number {
  return member!.label!.value;
}

type FirstOnly = Pick<Settings, "color" | "opacity" | "visible" | "minComponent" | "hiddenParts" | "material">;

// Picks the settings of the first surface.
function firstOnly({ color, opacity, visible, minComponent, hiddenParts, material }: FirstOnly): FirstOnly {
  return { color, opacity, visible, minComponent, hiddenParts, material };
}

// Leaves out optional fields with default values, as parsed addresses do.
function withoutDefaults({ minComponent, hiddenParts = [], material = "neutral", ...surface }: AdditionalSurface): AdditionalSurface {
  return {
    ...surface,
    ...(minComponent ? { minComponent } : {}),
    ...(material !== "neutral" ? { material } : {}),
    ...(hiddenParts.length > 0 ? { hiddenParts } : {}),
  };
}

function lookOf({ isovalue, error, color, opacity, minComponent = 0, hiddenParts = [], material = "neutral" }: AdditionalSurface): string {
  return JSON.stringify([isovalue, error, color, opacity, minComponent, hiddenParts, material]);
}
