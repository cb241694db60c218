// Resolves settings and the list of datasets to the datasets of the surfaces and of their colors at a time.

import type { DatasetInfo } from "../protocol/messages";
import { atTime, findByName, imageOf, isSameSeries, rangeOf, timeOf, unknownDatasetText } from "../state/series";
import type { Settings, SurfaceSettings } from "../state/settings";
import { worldDifference } from "../stream/dataset";
import type { ScalarOptions } from "../stream/stream_request";
import type { SceneTime } from "./swap_group";

export interface Scene {
  time: SceneTime;
  infos: readonly (DatasetInfo | null)[]; // The dataset of each surface; null: unknown.
  scalars?: ScalarOptions;
}

// `info`: the dataset of the first surface, at that time.
export function sceneOf(list: readonly DatasetInfo[], settings: Settings, info: DatasetInfo): Scene {
  return {
    time: { scene: info.member?.series || info.name, time: timeOf(info) },
    infos: settings.surfaces.map(({ dataset }) => (dataset ? besideOf(list, info, findByName(list, dataset)) : info)),
    scalars: settings.colorBy ? scalarOptionsOf(list, besideOf(list, info, findByName(list, settings.colorBy)), settings.colorBy) : undefined,
  };
}

// Returns the dataset whose samples planes show beside the surfaces of `info`.
export function sampledOf(list: readonly DatasetInfo[], { samplesOf }: Settings, info: DatasetInfo): DatasetInfo {
  const image = samplesOf ? findByName(list, samplesOf) : info.member?.label ? imageOf(list, info) : null;
  return image && worldDifference(info, image) === null ? besideOf(list, info, image)! : info;
}

// Returns the dataset at the time of `info`, if they are of the same series.
function besideOf(list: readonly DatasetInfo[], info: DatasetInfo, one: DatasetInfo | null): DatasetInfo | null {
  return one && isSameSeries(one, info) ? atTime(list, one, timeOf(info)) : one;
}

// Names the settings that cannot be shown, and the change that replaces them.
export interface SceneRefusal {
  text: string;
  change: Partial<Settings>;
}

// Refuses surfaces and samples of unknown datasets, and datasets of another world that color the surfaces or fill planes. Null:
// nothing.
export function sceneRefusal(list: readonly DatasetInfo[], { colorBy, samplesOf, surfaces }: Settings, info: DatasetInfo): SceneRefusal | null {
  const isKnown = ({ dataset }: SurfaceSettings) => !dataset || findByName(list, dataset) !== null;
  const unknown = surfaces.find((one) => !isKnown(one));
  if (unknown) return { text: unknownDatasetText(list, unknown.dataset), change: { surfaces: surfaces.filter(isKnown) } };
  const by = colorBy ? findByName(list, colorBy) : null;
  if (colorBy && !by) return { text: unknownDatasetText(list, colorBy), change: { colorBy: "" } };
  const reason = by && worldDifference(info, by);
  if (reason) return { text: `"${colorBy}" cannot color this surface: ${reason}.`, change: { colorBy: "" } };
  const sampled = samplesOf ? findByName(list, samplesOf) : info;
  if (!sampled) return { text: unknownDatasetText(list, samplesOf), change: { samplesOf: "" } };
  const difference = worldDifference(info, sampled);
  return difference ? { text: `Slices cannot show "${samplesOf}": ${difference}.`, change: { samplesOf: "" } } : null;
}

// Returns the options for a dataset that colors surfaces; without a known dataset only the name, which the server rejects.
function scalarOptionsOf(list: readonly DatasetInfo[], by: DatasetInfo | null, name: string): ScalarOptions {
  if (!by) return { dataset: name };
  const { min, max } = rangeOf(list, by);
  return min < max ? { dataset: by.name, low: min, high: max } : { dataset: by.name };
}
