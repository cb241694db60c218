// Selects a second field that colors the surfaces: from the same series, or any dataset in the same world.
import type { DatasetInfo } from "../protocol/messages";
import { colorMaps } from "../shared/color_maps";
import { h } from "../shared/elements";
import { inDigits } from "../shared/quantities";
import type { Progress } from "../state/progress";
import { datasetSelect } from "./dataset_select";
import type { Change, PanelSection } from "./panel_section";
import { SettingControls } from "./setting_controls";

export interface FieldPart extends PanelSection {
  showDatasets: (list: readonly DatasetInfo[]) => void;
  showProgress: (progress: Progress) => void;
}

export function fieldPart(change: Change): FieldPart {
  const controls = new SettingControls(change);
  const choice = datasetSelect("Color the surfaces by", "None: one color for each surface", (colorBy) =>
    change({ colorBy, fieldLevel: null, fieldWindow: null }),
  );
  const colors = controls.choice("colors", {
    label: "Colors",
    tip: "From small to large values; drag the legend in the picture to change the range.",
    choices: colorMaps.map((map) => [map, map] as const),
  });
  const log = controls.toggle("fieldLog", {
    label: "Logarithmic",
    tip: "Equal factors of the values have equal steps of color.",
  });
  const none = h("input", { type: "color", "aria-label": "Color where there is no value" });
  none.addEventListener("input", () => change({ noValueColor: none.value }));
  const noneRow = h(
    "label",
    { class: "control toggle", "data-tip": "The color of places where the field has no value." },
    h("span", {}, "Without a value"),
    none,
  );
  const note = h("p", { class: "hint", "data-tip": "Colors are exact at vertices, within 1/65534 of the range; between vertices they are interpolated." });
  let list: readonly DatasetInfo[] = [];
  let info: DatasetInfo | null = null;
  let wanted = "";
  return {
    elements: [choice.element, colors, log, noneRow, note],
    show: (settings, shown) => {
      controls.show(settings);
      none.value = settings.noValueColor;
      colors.hidden = log.hidden = noneRow.hidden = note.hidden = settings.colorBy === "";
      if (info === shown && wanted === settings.colorBy) return;
      info = shown;
      wanted = settings.colorBy;
      choice.show(list, info, wanted);
    },
    showDatasets: (now) => {
      list = now;
      choice.show(list, info, wanted);
    },
    showProgress: ({ scalars }) => {
      note.textContent = scalars ? noteOf(scalars) : "";
    },
  };
}

export function noteOf({ deviation, vertices, missing }: NonNullable<Progress["scalars"]>): string {
  if (missing === vertices) return "No vertex has a value: the dataset lies elsewhere.";
  const percent = inDigits((100 * missing) / vertices, 2);
  const none = missing > 0 ? ` ${percent} % of the vertices have no value.` : "";
  return `Between vertices, colors differ from the field by at most about ${inDigits(deviation, 2)}.${none}`;
}
