// A plane of samples in the picture: where it lies and its colours. The legend in the picture has the rest.
import { colourMaps } from "../shared/colour_maps";
import type { Change, Part } from "./part";
import { SettingControls } from "./setting_controls";

export function slicePart(change: Change): Part {
  const controls = new SettingControls(change);
  const slice = controls.choice("slice", {
    label: "Plane", tip: "The samples on a plane across the data, with the lines where it cuts the surfaces.",
    words: [["off", "Off"], ["x", "x"], ["y", "y"], ["z", "z"]],
  });
  const at = controls.slider("sliceAt", {
    label: "Lies at", tip: "Where the plane lies along its axis.",
    min: 0, max: 1, step: 0.002,
    text: (value) => `${(100 * value).toFixed(1)} %`,
  });
  const colours = controls.choice("colours", {
    label: "Colours of samples", tip: "From small values to large ones; drag the legend in the picture to turn window and level.",
    words: colourMaps.map((map) => [map, map] as const),
  });
  const log = controls.toggle("samplesLog", {
    label: "Logarithmic", tip: "Equal factors of the values have equal steps of colour.",
  });
  return {
    elements: [slice, at, colours, log],
    show: (settings) => {
      controls.show(settings);
      at.hidden = settings.slice === "off";
    },
  };
}
