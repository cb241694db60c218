// Selects the field of a series, or its labels.
import type { DatasetInfo } from "../protocol/messages";
import { h } from "../shared/elements";
import { changeFromWritten, settingsOfEntry } from "../state/label_surfaces";
import { channelColor, memberOfField, type Series, seriesOf } from "../state/series";
import type { Settings } from "../state/settings";
import type { Change, PanelSection } from "./panel_section";

const labelsOption = "/labels"; // No field has this name.

export interface SeriesPart extends PanelSection {
  showDatasets: (list: readonly DatasetInfo[]) => void;
}

export function seriesPart(change: Change): SeriesPart {
  let list: readonly DatasetInfo[] = [];
  let info: DatasetInfo | null = null;
  let settings: Settings;
  const choice = h("select", { class: "select", "aria-label": "Field of the surfaces", hidden: true });
  choice.setAttribute("data-tip", "The surfaces are where this field has the isovalue.");
  choice.addEventListener("change", () => {
    const series = info && seriesOf(list, info);
    if (!series) return;
    if (choice.value === labelsOption) return change(settingsOfEntry({ name: series.name, info: info!, series }, settings));
    const other = memberOfField(series, info!, choice.value);
    if (other) change(changeFromWritten(list, info, settings, { dataset: other.name, isovalue: null, ...channelColor(other) }));
  });
  return {
    elements: [choice],
    show: (now, shown) => {
      settings = now;
      info = shown;
      const offers = offersOf(shown && seriesOf(list, shown));
      choice.hidden = offers.length < 2;
      if ([...choice.options].map(({ value }) => value).join("\n") !== offers.map(([value]) => value).join("\n")) {
        choice.replaceChildren(...offers.map(([value, words]) => h("option", { value }, words)));
      }
      const isOfLabels = shown?.member?.label && offers.some(([value]) => value === labelsOption);
      choice.value = isOfLabels ? labelsOption : (shown?.member?.field ?? "");
    },
    showDatasets: (now) => {
      list = now;
    },
  };
}

// Returns values and texts. Labels are offered beside fields, such as those of a segmented image.
function offersOf(series: Series | null): [string, string][] {
  if (!series) return [];
  const fields = series.fields.map((field): [string, string] => [field, field || "(no name)"]);
  const hasBoth = series.labels.length > 0 && series.members.some(({ member }) => !member!.label);
  return hasBoth ? [...fields, [labelsOption, `labels (${series.labels.length})`]] : fields;
}
