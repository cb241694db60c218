// Selects a second field that colors the surfaces: from the same series, or any dataset in the same world.
import { h } from "../shared/elements";
import { inDigits } from "../shared/quantities";
import type { Progress } from "../state/progress";
import { datasetSelect } from "./dataset_select";
import { colorInput, labeled } from "./inputs";
import { type Change, colorChoices, type PanelSection } from "./panel_section";
import { SettingControls } from "./setting_controls";

export interface FieldPart extends PanelSection {
  showProgress: (progress: Progress) => void;
}

export function fieldPart(change: Change): FieldPart {
  const controls = new SettingControls(change);
  const choice = datasetSelect("Color the surfaces by", "None: one color for each surface", (colorBy) =>
    change({ colorBy, fieldLevel: null, fieldWindow: null }),
  );
  const colorsTip = "From small to large values; drag the legend in the picture to change the range.";
  const colors = controls.choice("colors", "Colors", colorsTip, colorChoices);
  const log = controls.toggle("fieldLog", "Logarithmic", "Equal factors of the values have equal steps of color.");
  const none = colorInput("Color where there is no value", (noValueColor) => change({ noValueColor }));
  const noneRow = labeled("Without a value", "The color of places where the field has no value.", none.element);
  const note = h("p", { class: "hint", "data-tip": "Colors are exact at vertices, within 1/65534 of the range; between vertices they are interpolated." });
  return {
    elements: [choice.element, colors, log, noneRow, note],
    show: ({ settings, info, list }) => {
      controls.show(settings);
      none.show(settings.noValueColor);
      colors.hidden = log.hidden = noneRow.hidden = note.hidden = settings.colorBy === "";
      choice.show(list, info, settings.colorBy);
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
