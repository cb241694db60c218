// Selects a second field that colors the surfaces: from the same series, or any dataset in the same world.
import type { DatasetInfo } from "../protocol/messages";
import { colorMaps } from "../shared/color_maps";
import { entriesOf, seriesOf, isSameSeries, findByName, memberOfField } from "../state/series";
import type { Progress } from "../state/progress";
import { worldDifference } from "../stream/dataset";
import { h } from "../shared/elements";
import { inDigits } from "../shared/quantities";
import type { Change, PanelSection } from "./panel_section";
import { SettingControls } from "./setting_controls";

export interface FieldPart extends PanelSection {
  showDatasets: (list: readonly DatasetInfo[]) => void;
  showProgress: (progress: Progress) => void;
}

interface Offer {
  name: string; // Of the dataset or its series.
  words: string;
}

export function fieldPart(change: Change): FieldPart {
  const controls = new SettingControls(change);
  const choice = h("select", { class: "select", "aria-label": "Color the surfaces by" });
  choice.addEventListener("change", () => change({ colorBy: choice.value, fieldLevel: null, fieldWindow: null }));
  const colors = controls.choice("colors", {
    label: "Colors", tip: "From small to large values; drag the legend in the picture to change the range.",
    choices: colorMaps.map((map) => [map, map] as const),
  });
  const log = controls.toggle("fieldLog", {
    label: "Logarithmic", tip: "Equal factors of the values have equal steps of color.",
  });
  const none = h("input", { type: "color", "aria-label": "Color where there is no value" });
  none.addEventListener("input", () => change({ noValueColor: none.value }));
  const noneRow = h("label", { class: "control toggle", "data-tip": "The color of places where the field has no value." },
    h("span", {}, "Without a value"), none);
  const note = h("p", { class: "hint", "data-tip":
    "Colors are exact at vertices, within 1/65534 of the range; between vertices they are interpolated." });
  let list: readonly DatasetInfo[] = [];
  let info: DatasetInfo | null = null;
  let wanted = "";
  let offered = "";
  const offer = () => {
    const { fields, others } = info ? offersFor(list, info) : { fields: [], others: [] };
    const chosen = chosenOf(list, info, wanted);
    const isUnknown = chosen !== "" && ![...fields, ...others].some(({ name }) => name === chosen);
    const rest = isUnknown ? [...others, { name: chosen, words: chosen }] : others;
    const key = JSON.stringify([fields, rest]);
    if (key !== offered) {
      offered = key;
      choice.replaceChildren(h("option", { value: "" }, "None: one color for each surface"),
        ...group("Fields of the same series", fields), ...group(fields.length > 0 ? "Other datasets" : "Datasets", rest));
    }
    choice.value = chosen;
  };
  return {
    elements: [choice, colors, log, noneRow, note],
    show: (settings, shown) => {
      controls.show(settings);
      none.value = settings.noValueColor;
      colors.hidden = log.hidden = noneRow.hidden = note.hidden = settings.colorBy === "";
      if (info === shown && wanted === settings.colorBy) return;
      info = shown;
      wanted = settings.colorBy;
      offer();
    },
    showDatasets: (now) => {
      list = now;
      offer();
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

function group(label: string, offers: readonly Offer[]): HTMLElement[] {
  if (offers.length === 0) return [];
  return [h("optgroup", { label }, ...offers.map(({ name, words }) => h("option", { value: name }, words)))];
}

// A field is identified by its first time, so that names do not change with the time.
function offersFor(list: readonly DatasetInfo[], info: DatasetInfo): { fields: Offer[]; others: Offer[] } {
  const series = seriesOf(list, info);
  const fields = series && series.fields.length > 1 ? series.fields : [];
  return {
    fields: fields.map((field) => ({ name: firstOf(list, info, field), words: field || "(no name)" })),
    others: entriesOf(list)
      .filter((one) => worldDifference(info, one.info) === null && !(fields.length > 0 && isSameSeries(one.info, info)))
      .map(({ name }) => ({ name, words: name })),
  };
}

function firstOf(list: readonly DatasetInfo[], info: DatasetInfo, field: string): string {
  const series = seriesOf(list, info)!;
  const first = findByName(list, series.name)!;
  return (memberOfField(series, first, field) ?? info).name;
}

// Returns the offer that matches the wanted dataset.
function chosenOf(list: readonly DatasetInfo[], info: DatasetInfo | null, wanted: string): string {
  const by = findByName(list, wanted);
  if (!wanted || !by || !info) return wanted;
  if (isSameSeries(by, info) && by.member && (seriesOf(list, by)?.fields.length ?? 0) > 1) return firstOf(list, info, by.member.field);
  return seriesOf(list, by)?.name ?? by.name;
}
