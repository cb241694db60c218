// The labels of a segmentation as surfaces: alone, or beside the surfaces of an image.
import type { DatasetInfo } from "../protocol/messages";
import { worldDifference } from "../stream/dataset";
import { labelColor } from "./label_colors";
import { labelRanges, labelsOfRanges, parseLabels } from "./label_ranges";
import { atTime, channelColor, type Entry, findByName, imageOf, isSameSeries, seriesOf } from "./series";
import { defaultSurface, defaults, type Settings, type SurfaceSettings, type WrittenSettings } from "./settings";
import { outerOpacity, withSurface } from "./surfaces";
import { fromWritten } from "./written_settings";

export const labelIsovalue = 0.5; // The isovalue of every label's boundary.
export const maxInitialLabels = 24; // Labels shown by default.

export interface Segmentation {
  name: string; // The name of its series; with a single label that of its dataset.
  labels: readonly DatasetInfo[]; // By value.
}

// The settings when an entry is selected: all labels of a segmentation, otherwise one surface, which looks like the first
// one did. If one label is named, only that one is visible.
export function settingsOfEntry({ info, series }: Entry, { surfaces: [first] }: Settings, named: string | null = null): Partial<Settings> {
  const labels = series?.labels ?? [];
  if (labels.length > 0) return withLabelsOnly(initialSurfaces(labels, named));
  const { color, opacity, material, visible } = first;
  return { dataset: info.name, surfaces: [{ ...defaultSurface, color, opacity, material, visible, ...channelColor(info) }] };
}

// The dataset of the view is that of the first surface.
function withLabelsOnly([first, ...others]: readonly SurfaceSettings[]): Pick<Settings, "dataset" | "surfaces"> {
  return { dataset: first.dataset, surfaces: [{ ...first, dataset: "" }, ...others] };
}

// The settings when the user chooses an entry: also its default view.
export function settingsOfChoice(entry: Entry, now: Settings): Partial<Settings> {
  return {
    ...settingsOfEntry(entry, now),
    t: null,
    playing: false,
    region: null,
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
  const images = settings.surfaces.filter(({ dataset }) => !labels.has(dataset));
  const [{ opacity }] = images;
  if (segmentation) {
    const surfaces = [...images, ...initialSurfaces(segmentation.labels)];
    return { ...withSurface({ surfaces }, 0, { opacity: opacity === 1 ? outerOpacity : opacity }), labels: "" };
  }
  const isAlone = images.length === 1 && opacity === outerOpacity;
  return { ...withSurface({ surfaces: images }, 0, { opacity: isAlone ? 1 : opacity }), labels: "" };
}

// Shows the surface of an image beside the labels that are shown alone.
export function withImage(settings: Settings, image: DatasetInfo): Partial<Settings> {
  return { dataset: image.name, surfaces: [{ ...defaultSurface, ...channelColor(image), opacity: outerOpacity }, ...namedSurfaces(settings)] };
}

// The surfaces of labels, each with the name of its dataset.
function namedSurfaces({ surfaces, dataset }: Settings): SurfaceSettings[] {
  return surfaces.map((one) => ({ ...one, isovalue: one.isovalue ?? labelIsovalue, dataset: one.dataset || dataset }));
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

function changesOfLabels(list: readonly DatasetInfo[], found: DatasetInfo, settings: Settings): Partial<Settings> {
  const { dataset, surfaces, labels } = settings;
  const series = surfaces.length === 1 || labels !== "" ? seriesOf(list, found) : null;
  if (!series || series.labels.length < 2) return labels ? { labels: "" } : {};
  if (!labels) return settingsOfEntry({ name: series.name, info: found, series }, settings, series.labels.find(({ name }) => name === dataset)?.name);
  return { ...withLabelsOnly(restored(series.labels, labels, surfaces)), labels: "" };
}

function changesOfImage(list: readonly DatasetInfo[], found: DatasetInfo, settings: Settings): Partial<Settings> {
  const { labels } = settings;
  const { surfaces } = settings.surfaces[0].color === defaultSurface.color ? withSurface(settings, 0, channelColor(found)) : settings;
  const own = surfaces === settings.surfaces ? {} : { surfaces };
  if (!labels) return own;
  const beside = segmentationsBeside(list, found).find(({ name }) => name === parseLabels(labels)?.series);
  if (!beside) return parseLabels(labels)?.series ? own : { ...own, labels: "" }; // They may be prepared later.
  const names = new Set(beside.labels.map(({ name }) => name));
  const others = surfaces.filter(({ dataset }) => !names.has(dataset));
  return { labels: "", surfaces: [...others, ...restored(beside.labels, labels, surfaces)] };
}

// Adds to a change of settings what follows for labels: named labels replace all shown surfaces, or the labels beside
// those of an image, and surfaces and their look do not stay between labels and another dataset. `shown`: the current
// dataset.
export function withLabelChanges(list: readonly DatasetInfo[], shown: DatasetInfo | null, now: Settings, change: Partial<Settings>): Partial<Settings> {
  const all = keepsSurfaces(list, shown, change) ? change : { surfaces: defaults.surfaces, ...change };
  if (!all.labels) return all;
  const after = { ...now, ...all };
  const info = datasetAfter(list, shown, change);
  const kept = info && !info.member?.label ? withSegmentation(list, after, null).surfaces! : defaults.surfaces;
  return { ...all, ...initialSelection(list, { ...after, surfaces: all.surfaces ?? kept })?.changes };
}

// Returns the change of the settings that other pages write.
export function changeFromWritten(list: readonly DatasetInfo[], shown: DatasetInfo | null, now: Settings, given: Partial<WrittenSettings>): Partial<Settings> {
  return fromWritten(keepsSurfaces(list, shown, given) ? now : defaults, given);
}

function datasetAfter(list: readonly DatasetInfo[], shown: DatasetInfo | null, { dataset }: Pick<Partial<Settings>, "dataset">): DatasetInfo | null {
  return dataset ? findByName(list, dataset) : shown;
}

function keepsSurfaces(list: readonly DatasetInfo[], shown: DatasetInfo | null, change: Pick<Partial<Settings>, "dataset">): boolean {
  const after = datasetAfter(list, shown, change);
  const [was, is] = [shown?.member?.label !== undefined, after?.member?.label !== undefined];
  return !shown || !after || (isSameSeries(shown, after) ? was === is : !was && !is);
}

// Shortens the settings of a segmentation for addresses: the visible labels, and as surfaces only labels whose look was
// changed. initialSelection() restores the settings.
export function withShortLabels(list: readonly DatasetInfo[], settings: Settings): Settings {
  const info = findByName(list, settings.dataset);
  if (!info) return settings;
  if (info.member?.label) {
    const labels = seriesOf(list, info)?.labels ?? [];
    const short = labels.length > 1 ? shortened(labels, namedSurfaces({ ...settings, dataset: info.name })) : null;
    return short ? { ...settings, labels: short.ranges, surfaces: [defaultSurface, ...short.changed] } : settings;
  }
  const datasets = new Set(settings.surfaces.map(({ dataset }) => dataset));
  const beside = segmentationsBeside(list, info).find(({ labels }) => labels.every(({ name }) => datasets.has(name)));
  if (!beside) return settings;
  const names = new Set(beside.labels.map(({ name }) => name));
  const isOfLabels = ({ dataset }: SurfaceSettings) => names.has(dataset);
  const short = shortened(beside.labels, settings.surfaces.filter(isOfLabels));
  const others = settings.surfaces.filter((one) => !isOfLabels(one));
  return short ? { ...settings, labels: `${beside.name}:${short.ranges}`, surfaces: [...others, ...short.changed] } : settings;
}

// Returns the visible labels as text, and the surfaces whose look was changed; null: the surfaces are not those of all
// labels, or text cannot name the labels.
function shortened(labels: readonly DatasetInfo[], surfaces: readonly SurfaceSettings[]): { ranges: string; changed: SurfaceSettings[] } | null {
  if (labels.length !== surfaces.length || labels.some(({ name }, at) => name !== surfaces[at].dataset)) return null;
  const values = labels.map(labelValue);
  const ranges = labelRanges(values, new Set(values.filter((_, at) => surfaces[at].visible)));
  const changed = surfaces.filter((one, at) => lookOf(one) !== lookOf(surfaceOfLabel(labels[at], one.visible)));
  return ranges === null ? null : { ranges, changed };
}

// Returns the surfaces that shortened() shortened.
function restored(labels: readonly DatasetInfo[], text: string, changed: readonly SurfaceSettings[]): SurfaceSettings[] {
  const ranges = parseLabels(text)?.ranges ?? "";
  const shown = labelsOfRanges(ranges, labels.map(labelValue));
  const others = new Map(changed.map((one) => [one.dataset, one]));
  return labels.map((one, at) => others.get(one.name) ?? surfaceOfLabel(one, ranges ? shown.has(labelValue(one)) : at < maxInitialLabels));
}

function initialSurfaces(labels: readonly DatasetInfo[], named: string | null = null): SurfaceSettings[] {
  return labels.map((one, at) => surfaceOfLabel(one, named ? one.name === named : at < maxInitialLabels));
}

function surfaceOfLabel({ name: dataset, member }: DatasetInfo, visible: boolean): SurfaceSettings {
  const { value, color } = member!.label!;
  return { ...defaultSurface, dataset, isovalue: labelIsovalue, color: labelColor(value, color), visible };
}

function labelValue({ member }: DatasetInfo): number {
  return member!.label!.value;
}

function lookOf({ isovalue, error, color, opacity, minComponent, hiddenParts, material }: SurfaceSettings): string {
  return JSON.stringify([isovalue, error, color, opacity, minComponent, hiddenParts, material]);
}
