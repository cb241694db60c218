// Cutting the surfaces open with a plane, and cropping them to a box. Display only: exports contain whole surfaces.
import type { DatasetInfo } from "../protocol/messages";
import { button, h } from "../shared/elements";
import type { Crop } from "../state/settings";
import { coordinateText, type Vec3, worldBox } from "../stream/dataset";
import { choice } from "./inputs";
import { type Change, type PanelSection, shareScale } from "./panel_section";
import { SettingControls } from "./setting_controls";

// `shownBox`: the box of the visible surfaces.
export function cutPart(change: Change, shownBox: () => Crop): PanelSection {
  // These need no new surface, so dragging them costs the server nothing.
  const controls = new SettingControls((changes) => change(changes));
  let world: DatasetInfo | null = null;
  let plane = "off";
  const clipTip = "A plane that cuts the surface open. Drag its handles in the picture to move and turn it.";
  const clip = controls.choice("clip", "Clip", clipTip, { off: "Off", x: "x", y: "y", z: "z", oblique: ["Oblique", "Faces the camera initially."] });
  const clipAt = controls.slider("clipAt", "Clip at", "Position of the plane along its normal.", {
    ...shareScale,
    text: (value) => positionText(world, plane, value),
  });
  const face = button("Face the camera", () => change({ clip: "oblique", clipNormal: null }), { "data-tip": "Turns the plane towards the camera." });
  const facing = h("div", { class: "chips" }, face);
  const flip = controls.toggle("clipFlipped", "Keep the other side", "Flips the plane.");
  const cropTip = "Hides everything outside of a box. Drag its handles in the picture. Exports contain whole surfaces.";
  const crop = choice("Crop", cropTip, { off: "Off", box: "Box" }, (kind) => change({ crop: kind === "box" ? initialCrop(shownBox()) : null }));
  const filled = controls.toggle("filled", "Fill", "Shows samples where surfaces are clipped or cropped: inside them, or the image of labels.");
  return {
    elements: [clip, clipAt, facing, flip, crop.element, filled],
    show: ({ settings, info, permitsSamples }) => {
      [world, plane] = [info, settings.clip];
      controls.show(settings);
      crop.show(settings.crop ? "box" : "off");
      clipAt.hidden = facing.hidden = flip.hidden = settings.clip === "off";
      filled.hidden = !permitsSamples || (settings.clip === "off" && !settings.crop);
    },
  };
}

// Returns the coordinate of a plane perpendicular to a world axis, for example "12.5 mm"; of other planes their share of
// the way through the data, for example "40 %".
export function positionText(info: DatasetInfo | null, axis: string, share: number): string {
  const at = "xyz".indexOf(axis);
  if (!info || at < 0) return `${Math.round(100 * share)} %`;
  const { low, high } = worldBox(info);
  return coordinateText(low[at] + share * (high[at] - low[at]), info);
}

// Returns a slightly smaller box, so that its effect is visible.
function initialCrop({ low, high }: Crop): Crop {
  const at = (share: number) => low.map((from, axis) => from + share * (high[axis] - from)) as Vec3;
  return { low: at(0.08), high: at(0.92) };
}
