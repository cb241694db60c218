// Selects the field of a series, or its labels.
import { h } from "../shared/elements";
import { changeFromWritten, settingsOfEntry } from "../state/label_surfaces";
import { channelColor, memberOfField, type Series, seriesOf } from "../state/series";
import type { Change, PanelSection, Shown } from "./panel_section";

const labelsOption = "/labels"; // No field has this name.

export function seriesPart(change: Change): PanelSection {
  let now: Shown | null = null;
  const choose = () => {
    const { info, list, settings } = now!;
    const series = info && seriesOf(list, info);
    if (!series) return;
    if (choice.value === labelsOption) return change(settingsOfEntry({ name: series.name, info, series }, settings));
    const other = memberOfField(series, info, choice.value);
    if (other) change(changeFromWritten(list, info, settings, { dataset: other.name, isovalue: null, ...channelColor(other) }));
  };
  const tip = "The surfaces are where this field has the isovalue.";
  const choice = h("select", { class: "select", "aria-label": "Field of the surfaces", hidden: true, "data-tip": tip, change: choose });
  return {
    elements: [choice],
    show: (shown) => {
      now = shown;
      const { info, list } = shown;
      const offers = offersOf(info && seriesOf(list, info));
      choice.hidden = offers.length < 2;
      if ([...choice.options].map(({ value }) => value).join("\n") !== offers.map(([value]) => value).join("\n")) {
        choice.replaceChildren(...offers.map(([value, words]) => h("option", { value }, words)));
      }
      const isOfLabels = info?.member?.label && offers.some(([value]) => value === labelsOption);
      choice.value = isOfLabels ? labelsOption : (info?.member?.field ?? "");
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
