// Series of datasets on the same grid: times, fields of a simulation or labels of a segmentation. Settings of one
// member (view, errors, regions) apply to all.
import type { DatasetInfo, Label } from "../protocol/messages";
import { nearestName } from "../shared/nearest_name";
import { inResolution } from "../shared/numbers";
import { hasSameGrid, isPartOf } from "../stream/dataset";
import { labelColor } from "./label_colors";
import type { LabelName, Settings } from "./settings";

export interface Series {
  name: string;
  members: readonly DatasetInfo[]; // In listed order; at least two.
  times: readonly number[]; // Distinct and ascending; empty: no times.
  timeUnit: string; // Empty: unknown, or frames are counted.
  fields: readonly string[]; // Distinct, in listed order; those of labels only if there are no others.
  labels: readonly DatasetInfo[]; // One member per label, by value.
}

// An entry of the dataset list and the dataset shown when it is selected.
export interface Entry {
  name: string;
  info: DatasetInfo;
  series: Series | null;
}

// In listed order; a series appears at its first member.
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

// Returns null if the dataset is in no series or its only member.
export function seriesOf(list: readonly DatasetInfo[], info: DatasetInfo): Series | null {
  const name = info.member?.series;
  if (!name) return null;
  const members = list.filter(({ member }) => member?.series === name);
  if (members.length < 2) return null;
  const times = members.map(timeOf).filter((time) => time !== null);
  const unlabeled = members.filter(({ member }) => !member!.label);
  const byLabel = new Map([...members].reverse().map((one) => [one.member!.label?.value, one]));
  byLabel.delete(undefined);
  return {
    name,
    members,
    times: [...new Set(times)].sort((a, b) => a - b),
    timeUnit: info.member!.timeUnit,
    fields: [...new Set((unlabeled.length > 0 ? unlabeled : members).map(({ member }) => member!.field))],
    labels: [...byLabel.values()].sort((a, b) => a.member!.label!.value - b.member!.label!.value),
  };
}

export function timeOf({ member }: DatasetInfo): number | null {
  const time = member?.time;
  return time !== undefined && Number.isFinite(time) ? time : null;
}

// Returns the dataset of that name, or else the first of the series or of the field ("flow.density") of that name.
export function findByName(list: readonly DatasetInfo[], name: string): DatasetInfo | null {
  const own = list.find((info) => info.name === name);
  if (own) return own;
  const member = list.find((info) => info.member?.series === name);
  const series = member && seriesOf(list, member);
  if (series) return firstOf(series);
  const times = list.filter((info) => timeOf(info) !== null && info.name.replace(/\.[^.]*$/, "") === name);
  return times.reduce<DatasetInfo | null>((first, one) => (first && timeOf(first)! <= timeOf(one)! ? first : one), null);
}

// Returns the same field and label at the nearest time; the dataset itself if it has no other times.
export function atTime(list: readonly DatasetInfo[], info: DatasetInfo, time: number | null): DatasetInfo {
  if (time === null || timeOf(info) === null) return info;
  const distance = (one: DatasetInfo) => Math.abs(timeOf(one)! - time);
  return sameFieldAndLabel(list, info).reduce((best, one) => (distance(one) < distance(best) ? one : best), info);
}

// Adds to a change of the dataset the time that follows: that of the named dataset; the same time if the change names a
// series or field of the shown dataset.
export function withTimeOfDataset(list: readonly DatasetInfo[], shown: DatasetInfo | null, now: Settings, change: Partial<Settings>): Partial<Settings> {
  const { dataset } = change;
  if (!dataset || now.t === null || change.t !== undefined) return change;
  const found = findByName(list, dataset);
  const staysAtTime = found && shown && found.name !== dataset && isSameSeries(found, shown);
  return staysAtTime ? change : { ...change, t: found?.name === dataset ? timeOf(found) : null };
}

// Returns the times of the same field and label, ascending; empty outside of series.
export function timesOf(list: readonly DatasetInfo[], info: DatasetInfo): number[] {
  return [...new Set(sameFieldAndLabel(list, info).map((one) => timeOf(one)!))].sort((a, b) => a - b);
}

// Returns the same label of another field, or its member without a label, at the same time if possible.
export function memberOfField(series: Series, info: DatasetInfo, field: string): DatasetInfo | null {
  const ofField = series.members.filter(({ member }) => member!.field === field);
  const same = ofField.filter(({ member }) => member!.label?.value === info.member!.label?.value);
  const found = same.length > 0 ? same : ofField.filter(({ member }) => !member!.label);
  return found.find((one) => timeOf(one) === timeOf(info)) ?? found[0] ?? null;
}

// Returns all labels of the series of some, at the same times.
export function withLabelsBeside(list: readonly DatasetInfo[], shown: readonly DatasetInfo[]): DatasetInfo[] {
  const beside = shown.flatMap((info) => seriesOf(list, info)?.labels.map((one) => atTime(list, one, timeOf(info))) ?? [info]);
  return [...new Map(beside.map((info) => [info.name, info])).values()];
}

// Returns the image of a segmentation: values on the same grid, of the same series, or else the only ones. A segmentation
// on a grid of its own has the image that it is a part of, if the server has no others.
export function imageOf(list: readonly DatasetInfo[], info: DatasetInfo): DatasetInfo | null {
  const all = list.filter(({ member }) => !member?.label);
  const onGrid = all.filter((one) => hasSameGrid(one, info));
  const only = (images: DatasetInfo[]) => images.find((one) => images.every((other) => isSameSeries(one, other))) ?? null;
  if (onGrid.length > 0) return onGrid.find((one) => isSameSeries(one, info)) ?? only(onGrid);
  const image = only(all);
  return image && isPartOf(info, image) ? image : null;
}

// Returns the value range over all times of the dataset, so that colors are comparable between times.
export function rangeOf(list: readonly DatasetInfo[], info: DatasetInfo): { min: number; max: number } {
  const all = [info, ...sameFieldAndLabel(list, info)];
  return { min: Math.min(...all.map(({ min }) => min)), max: Math.max(...all.map(({ max }) => max)) };
}

// Whether both are the same dataset, prepared once; the list of a later connection has other objects. What is shown of
// a dataset stays valid when the server has computed its missing errors.
export function isSameData(a: DatasetInfo | null | undefined, b: DatasetInfo | null | undefined): boolean {
  return !!a && a.name === b?.name && (a.contentId === b.contentId || isCompleted(a, b));
}

function isCompleted(before: DatasetInfo, now: DatasetInfo): boolean {
  const facts = ({ dims, indexToWorld, min, max, voidSamples, histogram }: DatasetInfo) =>
    [dims, indexToWorld, min, max, voidSamples, histogram?.counts].join();
  return before.missing !== "" && now.missing === "" && facts(before) === facts(now);
}

export function isSameSeries(a: DatasetInfo, b: DatasetInfo): boolean {
  return a.name === b.name || (!!a.member && a.member.series === b.member?.series);
}

// "0.25 s"; "time 3" without a unit. `times`: those of the series, of which every two differ in the text.
export function timeText(time: number, unit: string, times: readonly number[]): string {
  const gaps = times
    .slice(1)
    .map((one, i) => Math.abs(one - times[i]))
    .filter((gap) => gap > 0);
  const number = inResolution(time, gaps.length > 0 ? Math.min(...gaps) / 100 : Math.abs(time) / 1e12);
  return unit ? `${number} ${unit}` : `time ${number}`;
}

// Returns null for datasets that are not a label.
export function labelOf(list: readonly DatasetInfo[], name: string): Label | null {
  return findByName(list, name)?.member?.label ?? null;
}

// Applies the user's name for the label, if any.
export function renamedLabel(label: Label, names: readonly LabelName[]): Label {
  const given = names.find((one) => one.label === label.value);
  return given ? { ...label, name: given.name } : label;
}

// Returns the user's name for the label.
export function nameOfLabel(label: Label, { labelNames }: Settings): string {
  return labelName(renamedLabel(label, labelNames));
}

// Sets a label's name; an empty one restores the file's.
export function withLabelName(names: readonly LabelName[], label: number, name: string): LabelName[] {
  const others = names.filter((one) => one.label !== label);
  return name ? [...others, { label, name }].sort((a, b) => a.label - b.label) : others;
}

// "liver"; "label 3" if the file has no name.
export function labelName({ value, name }: Label): string {
  return name || `label ${value}`;
}

// Returns the color in which the source shows a channel, if any; black would be invisible.
export function channelColor({ member }: DatasetInfo): { color?: string } {
  return member?.color && !member.label ? { color: labelColor(0, member.color) } : {};
}

// "No dataset named "haed" is served here. Did you mean "head"?"
export function unknownDatasetText(list: readonly DatasetInfo[], dataset: string): string {
  const names = list.flatMap(({ name, member }) => (member ? [member.series, name] : [name]));
  const meant = nearestName(dataset, names);
  return `No dataset named "${dataset}" is served here.${meant ? ` Did you mean "${meant}"?` : ""}`;
}

function firstOf({ members, labels }: Series): DatasetInfo {
  const first = labels[0] ?? members[0];
  const like = members.filter(({ member }) => member!.field === first.member!.field && member!.label?.value === first.member!.label?.value);
  return like.reduce((best, one) => ((timeOf(one) ?? 0) < (timeOf(best) ?? 0) ? one : best), first);
}

// Returns the members that differ only in time.
function sameFieldAndLabel(list: readonly DatasetInfo[], { member }: DatasetInfo): DatasetInfo[] {
  if (!member) return [];
  return list.filter(
    (one) =>
      one.member?.series === member.series && one.member.field === member.field && one.member.label?.value === member.label?.value && timeOf(one) !== null,
  );
}
