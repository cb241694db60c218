// What follows from a change of settings.
import type { DatasetInfo } from "../protocol/messages";
import { initialCut } from "../scene/cut_plane";
import { withLabelChanges } from "../state/label_surfaces";
import { findByName, withTimeOfDataset } from "../state/series";
import type { Settings } from "../state/settings";
import { withAllSurfaces } from "../state/surfaces";
import { suggestedIsovalue, type View } from "../stream/request";

export interface CompletedChange {
  change: Partial<Settings>;
  unknown: string | null; // A named dataset that is not in the list; the change keeps the shown one.
}

// `info`: the shown dataset.
export function completedChange(
  list: readonly DatasetInfo[],
  info: DatasetInfo | null,
  before: Settings,
  given: Partial<Settings>,
  view: View,
): CompletedChange {
  const unknown = list.length > 0 && given.dataset && !findByName(list, given.dataset) ? given.dataset : null;
  let change = withLabelChanges(list, info, before, unknown ? { ...given, dataset: before.dataset } : given);
  change = withTimeOfDataset(list, info, before, change);
  change = { ...change, ...initialCut(change, before, view) };
  // Times suggest different isovalues: fixes the current ones.
  if (change.t !== undefined && change.dataset === undefined && info) {
    const isovalue = suggestedIsovalue(info);
    const fixed = withAllSurfaces({ ...before, ...change }, (one) => (one.isovalue === null && !one.dataset ? { isovalue } : null));
    change = { ...change, ...fixed };
  }
  return { change, unknown };
}
