// A second field that colours the surfaces: any dataset in the same world.
import type { DatasetInfo } from "../protocol/messages";
import { colourMaps } from "../scene/colour_maps";
import type { Progress } from "../state/progress";
import { h, inDigits } from "./dom";
import type { Change, Part } from "./part";
import { SettingControls } from "./setting_controls";

export interface FieldPart extends Part {
  showDatasets: (list: readonly DatasetInfo[]) => void;
  showProgress: (progress: Progress) => void;
}

export function fieldPart(change: Change): FieldPart {
  const controls = new SettingControls(change);
  const choice = h("select", { class: "select", "aria-label": "Colour the surfaces by" });
  choice.addEventListener("change", () => change({ colourBy: choice.value, fieldLevel: null, fieldWindow: null }));
  const colours = controls.choice("fieldColours", {
    label: "Colours", tip: "From small values to large ones; drag the legend in the picture to turn the range.",
    words: colourMaps.map((map) => [map, map] as const),
  });
  const told = h("p", { class: "hint", "data-tip":
    "Colours are exact at vertices, to a 65534th of the range; between them they are interpolated." });
  let list: readonly DatasetInfo[] = [];
  let info: DatasetInfo | null = null;
  let wanted = "";
  const offer = () => {
    const fitting = list.filter((one) => info && isInSameWorld(one, info));
    const names = fitting.map(({ name }) => name);
    const all = ["", ...names, ...(wanted && !names.includes(wanted) ? [wanted] : [])];
    choice.replaceChildren(...all.map((name) => h("option", { value: name }, name || "Nothing: one colour each")));
    choice.value = wanted;
  };
  return {
    elements: [choice, colours, told],
    show: (settings, shown) => {
      controls.show(settings);
      colours.hidden = told.hidden = settings.colourBy === "";
      if (info === shown && wanted === settings.colourBy) return;
      info = shown;
      wanted = settings.colourBy;
      offer();
    },
    showDatasets: (now) => {
      list = now;
      offer();
    },
    showProgress: ({ scalars }) => {
      told.textContent = scalars ? `Between vertices, colours are at most about ${inDigits(scalars.deviation, 2)} beside the field.` : "";
    },
  };
}

// The server says no where worlds differ; what is known to differ is not offered.
function isInSameWorld(a: DatasetInfo, b: DatasetInfo): boolean {
  const agree = <T>(x: T, y: T) => !x || !y || x === y;
  return agree(a.space, b.space) && agree(a.lengthUnit, b.lengthUnit);
}
