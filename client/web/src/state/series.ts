// Datasets that belong together, as listed by the server: times of a series, fields of a simulation, labels of a
// segmentation. They have the same grid, so that settings of one of them (view, errors, regions) hold for all.
import type { DatasetInfo, Label } from "../protocol/messages";
import { nearestName } from "../shared/nearest_name";
import { labelColor } from "./label_colors";
import { labelRanges, labelsOfRanges } from "./label_ranges";
import { defaults, type AdditionalSurface, type LabelName, type Settings } from "./settings";
import { surfacesOf } from "./surfaces";

export interface Series {
  name: string;
  members: readonly DatasetInfo[]; // As they are listed; two or more.
  times: readonly number[]; // That differ, ascending; none: it has no times.
  timeUnit: string; // Empty: times are numbers of frames.
  fields: readonly string[]; // That differ, as they are listed.
  labels: readonly DatasetInfo[]; // One member of each label, by its value.
}

// A line of a list of datasets: what is looked at first when it is chosen.
export interface Entry {
  name: string;
  info: DatasetInfo;
  series: Series | null;
}

export const labelIsovalue = 0.5; // Where the boundary of every label is.
export const mostLabelsAtFirst = 24; // Labels shown by default.

// In the order of the list: a series is where its first member is.
export function entriesOf(list: readonly DatasetInfo[]): Entry[] {
  const seen = new Set<string>();
  return list.flatMap((info): Entry[] => {
    if (info.member && seen.has(info.member.series)) return [];
    const series = seriesOf(list, info);
    if (!series) return [{ name: info.name, info, series }];
    seen.add(series.name);
    return [{ name: series.name, info: firstOf(series), series }];
  });
}

// Null: it is in no series, or its only member.
export function seriesOf(list: readonly DatasetInfo[], info: DatasetInfo): Series | null {
  const name = info.member?.series;
  if (!name) return null;
  const members = list.filter(({ member }) => member?.series === name);
  if (members.length < 2) return null;
  const times = members.map(timeOf).filter((time) => time !== null);
  const byLabel = new Map([...members].reverse().map((one) => [one.member!.label?.value, one]));
  byLabel.delete(undefined);
  return {
    name,
    members,
    times: [...new Set(times)].sort((a, b) => a - b),
    timeUnit: info.member!.timeUnit,
    fields: [...new Set(members.map(({ member }) => member!.field))],
    labels: [...byLabel.values()].sort((a, b) => a.member!.label!.value - b.member!.label!.value),
  };
}

export function timeOf({ member }: DatasetInfo): number | null {
  const time = member?.time;
  return time !== undefined && Number.isFinite(time) ? time : null;
}

// The dataset of that name; else the first of the series of that name.
export function named(list: readonly DatasetInfo[], name: string): DatasetInfo | null {
  const own = list.find((info) => info.name === name);
  if (own) return own;
  const member = list.find((info) => info.member?.series === name);
  const series = member && seriesOf(list, member);
  return series ? firstOf(series) : null;
}

// The same field and label at the nearest time there is; itself where it has no other times.
export function atTime(list: readonly DatasetInfo[], info: DatasetInfo, time: number | null): DatasetInfo {
  if (time === null || timeOf(info) === null) return info;
  const distance = (one: DatasetInfo) => Math.abs(timeOf(one)! - time);
  return alike(list, info).reduce((best, one) => (distance(one) < distance(best) ? one : best), info);
}

// The times of the same field and label, ascending; none or one: there is no series.
export function timesOf(list: readonly DatasetInfo[], info: DatasetInfo): number[] {
  return [...new Set(alike(list, info).map((one) => timeOf(one)!))].sort((a, b) => a - b);
}

// The same label at the same time, of another field.
export function ofField(series: Series, info: DatasetInfo, field: string): DatasetInfo | null {
  const isIt = ({ member }: DatasetInfo) => member!.field === field && member!.label?.value === info.member!.label?.value;
  const found = series.members.filter(isIt);
  return found.find((one) => timeOf(one) === timeOf(info)) ?? found[0] ?? null;
}

// Which values the dataset has over all its times, so that a color means the same at each.
export function rangeOf(list: readonly DatasetInfo[], info: DatasetInfo): { min: number; max: number } {
  const all = [info, ...alike(list, info)];
  return { min: Math.min(...all.map(({ min }) => min)), max: Math.max(...all.map(({ max }) => max)) };
}

export function isOfOneSeries(a: DatasetInfo, b: DatasetInfo): boolean {
  return a.name === b.name || (!!a.member && a.member.series === b.member?.series);
}

// "0.25 s"; "frame 3" without a unit.
export function timeText(time: number, unit: string): string {
  const number = String(Number(time.toPrecision(6)));
  return unit ? `${number} ${unit}` : `frame ${number}`;
}

// Null: it is none of a label.
export function labelOf(list: readonly DatasetInfo[], name: string): Label | null {
  return named(list, name)?.member?.label ?? null;
}

// With the name that the user gave it, if any.
export function renamedLabel(label: Label, names: readonly LabelName[]): Label {
  const given = names.find((one) => one.label === label.value);
  return given ? { ...label, name: given.name } : label;
}

// As the user calls it.
export function nameOfLabel(label: Label, { labelNames }: Settings): string {
  return labelName(renamedLabel(label, labelNames));
}

// Names with that label's; an empty one is the file's again.
export function withLabelName(names: readonly LabelName[], label: number, name: string): LabelName[] {
  const others = names.filter((one) => one.label !== label);
  return name ? [...others, { label, name }].sort((a, b) => a.label - b.label) : others;
}

// "liver"; where the file names none, "label 3".
export function labelName({ value, name }: Label): string {
  return name || `label ${value}`;
}

// What is looked at when an entry is chosen: all labels of a segmentation, else one surface. Where one
// label is named, the others are there to be shown.
export function settingsOfEntry({ info, series }: Entry, named: string | null = null): Partial<Settings> {
  const labels = series?.labels ?? [];
  const isShown = ({ name }: DatasetInfo, at: number) => (named ? name === named : at < mostLabelsAtFirst);
  const [first, ...others] = labels.map((one, at) => surfaceOfLabel(one, isShown(one, at)));
  if (!first) return { dataset: info.name, isovalue: null, surfaces: [] };
  const { dataset, color, opacity, visible } = first;
  return { dataset, isovalue: labelIsovalue, color, opacity, visible, surfaces: others };
}

// What the settings name, and what is changed of them: all labels of a segmentation, where no surfaces are named; one
// alone is shown where it is named. Null: the list has no such dataset.
export function startOf(list: readonly DatasetInfo[], settings: Settings): { info: DatasetInfo; changes: Partial<Settings> | null } | null {
  const { dataset, surfaces, labels, t } = settings;
  const found = dataset ? named(list, dataset) : list[0];
  if (!found) return null;
  const isOfLabels = (surfaces.length === 0 || labels !== "") && found.member?.label;
  const series = isOfLabels ? seriesOf(list, found) : null;
  if (!series || series.labels.length < 2) return { info: atTime(list, found, t), changes: labels ? { labels: "" } : null };
  if (labels) {
    const changes = withLabels(series, settings);
    return { info: atTime(list, named(list, changes.dataset!) ?? found, t), changes };
  }
  const label = series.labels.find(({ name }) => name === dataset)?.name ?? null;
  const changes = settingsOfEntry({ name: series.name, info: found, series }, label);
  return { info: atTime(list, named(list, changes.dataset!) ?? found, t), changes };
}

// The settings with all surfaces of a segmentation as few words: the labels that are shown, and as surfaces those alone whose
// look was changed. startOf() makes the same settings of them.
export function shortened(list: readonly DatasetInfo[], settings: Settings): Settings {
  const info = named(list, settings.dataset);
  const series = info?.member?.label ? seriesOf(list, info) : null;
  const surfaces = surfacesOf(settings).map((one, at) => ({
    ...one, isovalue: one.isovalue ?? labelIsovalue, dataset: one.dataset || info?.name, error: at > 0 ? one.error : null,
  }));
  const isWhole = series && series.labels.length === surfaces.length && series.labels.length > 1;
  if (!isWhole || series.labels.some(({ name }, at) => name !== surfaces[at].dataset)) return settings;
  const values = series.labels.map(({ member }) => member!.label!.value);
  const labels = labelRanges(values, new Set(values.filter((_, at) => surfaces[at].visible)));
  if (labels === null) return settings;
  const changed = surfaces.filter((one, at) => lookOf(one) !== lookOf(surfaceOfLabel(series.labels[at], one.visible)));
  return { ...settings, ...firstOnly(defaults), isovalue: null, labels, surfaces: changed };
}

// What shortened() wrote.
function withLabels({ labels: members }: Series, { labels, surfaces }: Settings): Partial<Settings> {
  const shown = labelsOfRanges(labels, members.map(({ member }) => member!.label!.value));
  const changed = new Map(surfaces.map((one) => [one.dataset, one]));
  const [first, ...others] = members.map((one) => changed.get(one.name) ?? surfaceOfLabel(one, shown.has(one.member!.label!.value)));
  const { dataset, isovalue } = first;
  return { ...firstOnly({ ...defaults, ...first }), dataset, isovalue, surfaces: others, labels: "" };
}

type FirstOnly = Pick<Settings, "color" | "opacity" | "visible" | "minComponent" | "hiddenParts" | "material" | "largestOnly">;

// The settings that are of the first surface.
function firstOnly({ color, opacity, visible, minComponent, hiddenParts, material, largestOnly }: FirstOnly): FirstOnly {
  return { color, opacity, visible, minComponent, hiddenParts, material, largestOnly };
}

function lookOf({ isovalue, error, color, opacity, minComponent = 0, hiddenParts = [], material = "neutral", largestOnly = false }: AdditionalSurface): string {
  return JSON.stringify([isovalue, error, color, opacity, minComponent, hiddenParts, material, largestOnly]);
}

function surfaceOfLabel({ name: dataset, member }: DatasetInfo, visible: boolean): AdditionalSurface {
  const { value, color } = member!.label!;
  return { dataset, isovalue: labelIsovalue, error: null, color: labelColor(value, color), opacity: defaults.opacity, visible };
}

// "No dataset named "haed" is served here. Did you mean "head"?"
export function unknownDatasetWords(list: readonly DatasetInfo[], dataset: string): string {
  const names = list.flatMap(({ name, member }) => (member ? [member.series, name] : [name]));
  const meant = nearestName(dataset, names);
  const advice = meant ? `Did you mean "${meant}"?` : "Choose one from the list.";
  return `No dataset named "${dataset}" is served here. ${advice}`;
}

function firstOf({ members, labels }: Series): DatasetInfo {
  const first = labels[0] ?? members[0];
  const like = members.filter(({ member }) =>
    member!.field === first.member!.field && member!.label?.value === first.member!.label?.value);
  return like.reduce((best, one) => ((timeOf(one) ?? 0) < (timeOf(best) ?? 0) ? one : best), first);
}

// Members that differ from it in time alone.
function alike(list: readonly DatasetInfo[], { member }: DatasetInfo): DatasetInfo[] {
  if (!member) return [];
  return list.filter((one) =>
    one.member?.series === member.series && one.member.field === member.field &&
    one.member.label?.value === member.label?.value && timeOf(one) !== null);
}
