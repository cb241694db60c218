// The slice in the scene: position and colors. The legend has the rest.
import type { DatasetInfo } from "../protocol/messages";
import { button, chips, h } from "../shared/elements";
import { sampleWindows } from "../shared/sample_window";
import { sampledOf } from "../surfaces/scene_at";
import { positionText } from "./cut_section";
import { datasetSelect } from "./dataset_select";
import { type Change, colorChoices, noSamples, type PanelSection, shareScale } from "./panel_section";
import { SettingControls } from "./setting_controls";

export function slicePart(change: Change): PanelSection {
  let world: DatasetInfo | null = null;
  let plane = "off";
  let known: DatasetInfo | null = null;
  const refusal = h("p", { class: "hint", hidden: true }, noSamples);
  const controls = new SettingControls(change);
  const sliceTip = "The samples on a plane through the data, with the contours of the surfaces. Clip has oblique planes, which Fill covers with samples.";
  const slice = controls.choice("slice", "Plane", sliceTip, { off: "Off", x: "x", y: "y", z: "z" });
  const samples = datasetSelect(
    "Samples of",
    "Automatic",
    (samplesOf) => change({ samplesOf, level: null, windowWidth: null }),
    ({ member }) => !member?.label,
  );
  const samplesTip = "Whose samples planes show: by default the image of labels, otherwise the data of the first surface.";
  const samplesRow = h("label", { class: "control", "data-tip": samplesTip }, h("span", {}, "Samples of"), samples.element);
  const at = controls.slider("sliceAt", "Position", "Position of the plane along its axis.", {
    ...shareScale,
    text: (value) => positionText(world, plane, value),
  });
  const colorsTip = "From small to large values; drag the legend in the picture to change level and window.";
  const colors = controls.choice("sliceColors", "Colors of samples", colorsTip, colorChoices);
  const windows = chips("Windows");
  const air = controls.toggle("transparentAir", "Transparent air", "Hides samples of air, or of a dark background.");
  const log = controls.toggle("samplesLog", "Logarithmic", "Equal factors of the values have equal steps of color.");
  const showWindows = (info: DatasetInfo | null) => {
    if (info === known) return;
    known = info;
    const unit = info?.valueUnit ? ` ${info.valueUnit}` : "";
    const windowOf = ({ name, level, width }: ReturnType<typeof sampleWindows>[number]) =>
      button(name, () => change({ level, windowWidth: width }), { "data-tip": `Level ${level}, window ${width}${unit}.` });
    windows.replaceChildren(...(info ? sampleWindows(info) : []).map(windowOf));
  };
  return {
    elements: [refusal, slice, at, samplesRow, colors, windows, air, log],
    show: ({ settings, info, list, permitsSamples }) => {
      [world, plane] = [info, settings.slice];
      controls.show(settings);
      showWindows(info && sampledOf(list, settings, info));
      refusal.hidden = permitsSamples;
      for (const element of [slice, colors, windows, air, log]) element.hidden = !permitsSamples;
      samplesRow.hidden = samples.show(list, info, settings.samplesOf) === 0 || !permitsSamples;
      at.hidden = settings.slice === "off" || !permitsSamples;
    },
  };
}
