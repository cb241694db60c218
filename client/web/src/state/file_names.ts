// Names of exported files, without their endings.
import type { DatasetInfo } from "../protocol/messages";
import { timeOf } from "./series";

export interface NamedSurface {
  info: DatasetInfo;
  isovalue: number;
}

// "jet_temperature_0.25_500.5": the series or dataset of the first surface, its field and time, and its isovalue, or
// its label if it is the only one.
export function fileName(surfaces: readonly NamedSurface[]): string {
  if (surfaces.length === 0) return "multitetra";
  const [{ info, isovalue }] = surfaces;
  const { member, name } = info;
  if (!member?.label) return fileWord([...(member?.series ? [member.series, member.field, timeOf(info)] : [name]), isovalue]);
  return fileWord([member.series, timeOf(info), surfaces.length === 1 ? member.label.name || member.label.value : "labels"]);
}

// Returns the name for a file of all times.
export function seriesName([first]: readonly NamedSurface[]): string {
  return first ? fileWord([first.info.member?.series || first.info.name, first.info.member?.field, first.isovalue]) : "multitetra";
}

function fileWord(words: readonly unknown[]): string {
  return words
    .filter((word) => word !== null && word !== undefined && word !== "")
    .join("_")
    .replace(/[^\p{L}\p{N}.+_-]+/gu, "-");
}
