// Resolves settings and the list of datasets to the datasets of the surfaces and of their colors at a time.
import type { Moment } from "./swap_group";
import type { DatasetInfo } from "./protocol/messages";
import { atTime, isSameSeries, findByName, rangeOf, timeOf, unknownDatasetText } from "./state/series";
import type { AdditionalSurface, Settings } from "./state/settings";
import { surfacesOf } from "./state/surfaces";
import type { ScalarOptions } from "./stream/stream_request";
import { worldDifference } from "./stream/dataset";

export interface Scene {
  moment: Moment;
  infos: readonly (DatasetInfo | null)[]; // The dataset of each surface; null: unknown.
  scalars?: ScalarOptions;
}

// `info`: the dataset of the first surface, at that time.
export function sceneOf(list: readonly DatasetInfo[], settings: Settings, info: DatasetInfo): Scene {
  const time = timeOf(info);
  const own = (name: string) => {
    const one = findByName(list, name);
    return one && (isSameSeries(one, info) ? atTime(list, one, time) : one);
  };
  return {
    moment: { scene: info.member?.series || info.name, time },
    infos: surfacesOf(settings).map(({ dataset }) => (dataset ? own(dataset) : info)),
    scalars: settings.colorBy ? wishOf(list, own(settings.colorBy), settings.colorBy) : undefined,
  };
}

// What of the settings cannot be shown, as text, and the change without it.
export interface SceneRefusal {
  text: string;
  change: Partial<Settings>;
}

// Refuses surfaces of unknown datasets, and a field of another world that colors the surfaces. Null: nothing.
export function sceneRefusal(list: readonly DatasetInfo[], { colorBy, surfaces }: Settings, info: DatasetInfo): SceneRefusal | null {
  const isKnown = ({ dataset }: AdditionalSurface) => !dataset || findByName(list, dataset) !== null;
  const unknown = surfaces.find((one) => !isKnown(one));
  if (unknown) return { text: unknownDatasetText(list, unknown.dataset!), change: { surfaces: surfaces.filter(isKnown) } };
  const by = colorBy ? findByName(list, colorBy) : null;
  const reason = by && worldDifference(info, by);
  return reason ? { text: `"${colorBy}" cannot color this surface: ${reason}.`, change: { colorBy: "" } } : null;
}

// The server rejects unknown names.
function wishOf(list: readonly DatasetInfo[], by: DatasetInfo | null, name: string): ScalarOptions {
  if (!by) return { dataset: name };
  const { min, max } = rangeOf(list, by);
  return min < max ? { dataset: by.name, low: min, high: max } : { dataset: by.name };
}
