// The slice in the scene: position and colors. The legend has the rest.
import type { DatasetInfo } from "../protocol/messages";
import { colorMaps } from "../shared/color_maps";
import { h } from "../shared/elements";
import { sampleWindows } from "../shared/sample_window";
import { sampledOf } from "../surfaces/scene_at";
import { positionText } from "./cut_section";
import { datasetSelect } from "./dataset_select";
import type { Change, PanelSection } from "./panel_section";
import { SettingControls } from "./setting_controls";

export const noSamples = "The server permits surfaces only here, no samples.";

export interface SlicePart extends PanelSection {
  showDatasets: (list: readonly DatasetInfo[]) => void;
  showPermission: (permitsSamples: boolean) => void;
}

export function slicePart(change: Change): SlicePart {
  let world: DatasetInfo | null = null;
  let plane = "off";
  const refusal = h("p", { class: "hint", hidden: true }, noSamples);
  const controls = new SettingControls(change);
  const slice = controls.choice("slice", {
    label: "Plane",
    tip: "The samples on a plane through the data, with the contours of the surfaces. Clip has oblique planes, which Fill covers with samples.",
    choices: [
      ["off", "Off"],
      ["x", "x"],
      ["y", "y"],
      ["z", "z"],
    ],
  });
  const samples = datasetSelect(
    "Samples of",
    "Automatic",
    (samplesOf) => change({ samplesOf, level: null, windowWidth: null }),
    ({ member }) => !member?.label,
  );
  const samplesRow = h(
    "label",
    { class: "control", "data-tip": "Whose samples planes show: by default the image of labels, otherwise the data of the first surface." },
    h("span", {}, "Samples of"),
    samples.element,
  );
  const at = controls.slider("sliceAt", {
    label: "Position",
    tip: "Position of the plane along its axis.",
    min: 0,
    max: 1,
    step: 0.002,
    text: (value) => positionText(world, plane, value),
  });
  const colors = controls.choice("sliceColors", {
    label: "Colors of samples",
    tip: "From small to large values; drag the legend in the picture to change level and window.",
    choices: colorMaps.map((map) => [map, map] as const),
  });
  const windows = h("div", { class: "chips", role: "group", "aria-label": "Windows" });
  const air = controls.toggle("transparentAir", {
    label: "Transparent air",
    tip: "Hides samples of air, or of a dark background.",
  });
  const log = controls.toggle("samplesLog", {
    label: "Logarithmic",
    tip: "Equal factors of the values have equal steps of color.",
  });
  let known: DatasetInfo | null = null;
  let list: readonly DatasetInfo[] = [];
  const showWindows = (info: DatasetInfo | null) => {
    if (info === known) return;
    known = info;
    windows.replaceChildren(
      ...(info ? sampleWindows(info) : []).map(({ name, level, width }) => {
        const button = h("button", { type: "button", "data-tip": `Level ${level}, window ${width}${info!.valueUnit ? ` ${info!.valueUnit}` : ""}.` }, name);
        button.addEventListener("click", () => change({ level, windowWidth: width }));
        return button;
      }),
    );
  };
  return {
    elements: [refusal, slice, at, samplesRow, colors, windows, air, log],
    show: (settings, info) => {
      [world, plane] = [info, settings.slice];
      controls.show(settings);
      showWindows(info && sampledOf(list, settings, info));
      samplesRow.hidden = samples.show(list, info, settings.samplesOf) === 0 || slice.hidden;
      at.hidden = settings.slice === "off" || slice.hidden;
    },
    showDatasets: (now) => {
      list = now;
    },
    showPermission: (permitsSamples) => {
      refusal.hidden = permitsSamples;
      for (const element of [slice, at, samplesRow, colors, windows, air, log]) element.hidden = !permitsSamples;
    },
  };
}
