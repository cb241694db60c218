// Names of exported files, without their endings.
import type { DatasetInfo } from "../protocol/messages";
import { timeOf } from "./series";

// "jet_temperature_0.25_500.5": the series or dataset, its field, label and time, and the isovalue of values.
export function fileName(info: DatasetInfo, isovalue: number): string {
  const { member, name } = info;
  const time = timeOf(info);
  const words = member?.series ? [member.series, member.field, member.label?.name || member.label?.value, time] : [name];
  return fileWord([...words, member?.label ? null : isovalue]);
}

// The same of all times.
export function seriesName({ member, name }: DatasetInfo, isovalue: number): string {
  return fileWord([member?.series || name, member?.field, isovalue]);
}

function fileWord(words: readonly unknown[]): string {
  return words.filter((word) => word !== null && word !== undefined && word !== "").join("_").replace(/[^\p{L}\p{N}.+_-]+/gu, "-");
}
