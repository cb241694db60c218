// Selects the field of a series.
import type { DatasetInfo } from "../protocol/messages";
import { seriesOf, memberOfField } from "../state/series";
import { h } from "../shared/elements";
import type { Change, PanelSection } from "./panel_section";

export interface SeriesPart extends PanelSection {
  showDatasets: (list: readonly DatasetInfo[]) => void;
}

export function seriesPart(change: Change): SeriesPart {
  let list: readonly DatasetInfo[] = [];
  let info: DatasetInfo | null = null;
  const choice = h("select", { class: "select", "aria-label": "Field of the surfaces", hidden: true });
  choice.setAttribute("data-tip", "The surfaces are where this field has the isovalue.");
  choice.addEventListener("change", () => {
    const series = info && seriesOf(list, info);
    const other = series && memberOfField(series, info!, choice.value);
    if (other) change({ dataset: other.name, isovalue: null });
  });
  return {
    elements: [choice],
    show: (_, shown) => {
      info = shown;
      const fields = (shown && seriesOf(list, shown)?.fields) ?? [];
      choice.hidden = fields.length < 2;
      if ([...choice.options].map(({ value }) => value).join("\n") !== fields.join("\n")) {
        choice.replaceChildren(...fields.map((field) => h("option", { value: field }, field || "(no name)")));
      }
      choice.value = shown?.member?.field ?? "";
    },
    showDatasets: (now) => {
      list = now;
    },
  };
}
