// Cutting the surfaces open with a plane, and cropping them to a box. Display only: exports contain whole surfaces.
import type { DatasetInfo } from "../protocol/messages";
import { h } from "../shared/elements";
import type { Crop } from "../state/settings";
import { coordinateText, type Vec3, worldBox } from "../stream/dataset";
import { choice } from "./inputs";
import type { Change, PanelSection } from "./panel_section";
import { SettingControls } from "./setting_controls";

export interface CutPart extends PanelSection {
  showPermission: (permitsSamples: boolean) => void;
}

// `shown`: the box of the visible surfaces.
export function cutPart(change: Change, shown: () => Crop): CutPart {
  // These need no new surface, so dragging them costs the server nothing.
  const controls = new SettingControls((changes) => change(changes));
  let permitsSamples = true;
  let world: DatasetInfo | null = null;
  let plane = "off";
  const clip = controls.choice("clip", {
    label: "Clip",
    tip: "A plane that cuts the surface open. Drag its handles in the picture to move and turn it.",
    choices: [
      ["off", "Off"],
      ["x", "x"],
      ["y", "y"],
      ["z", "z"],
      ["oblique", "Oblique", "Faces the camera initially."],
    ],
  });
  const clipAt = controls.slider("clipAt", {
    label: "Clip at",
    tip: "Position of the plane along its normal.",
    min: 0,
    max: 1,
    step: 0.002,
    text: (value) => positionText(world, plane, value),
  });
  const face = h("button", { type: "button", "data-tip": "Turns the plane towards the camera." }, "Face the camera");
  face.addEventListener("click", () => change({ clip: "oblique", clipNormal: null }));
  const facing = h("div", { class: "chips" }, face);
  const flip = controls.toggle("clipFlipped", {
    label: "Keep the other side",
    tip: "Flips the plane.",
  });
  const crop = choice<"off" | "box">({
    label: "Crop",
    tip: "Hides everything outside of a box. Drag its handles in the picture. Exports contain whole surfaces.",
    choices: [
      ["off", "Off"],
      ["box", "Box"],
    ],
    onChange: (kind) => change({ crop: kind === "box" ? initialCrop(shown()) : null }),
  });
  const filled = controls.toggle("filled", {
    label: "Fill",
    tip: "Shows samples where surfaces are clipped or cropped: inside them, or the image of labels.",
  });
  return {
    elements: [clip, clipAt, facing, flip, crop.element, filled],
    show: (settings, info) => {
      [world, plane] = [info, settings.clip];
      controls.show(settings);
      crop.show(settings.crop ? "box" : "off");
      clipAt.hidden = facing.hidden = flip.hidden = settings.clip === "off";
      filled.hidden = !permitsSamples || (settings.clip === "off" && !settings.crop);
    },
    showPermission: (permits) => {
      permitsSamples = permits;
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
