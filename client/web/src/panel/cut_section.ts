// Cutting the surfaces open with a plane, and cropping them to a box. Display only: exports contain whole surfaces.
import type { Crop } from "../state/settings";
import type { Vec3 } from "../stream/dataset";
import { h } from "../shared/elements";
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
  const clip = controls.choice("clip", {
    label: "Clip", tip: "A plane that cuts the surface open. Drag its handles in the picture to move and turn it.",
    choices: [["off", "Off"], ["x", "x"], ["y", "y"], ["z", "z"], ["oblique", "Oblique", "Faces the camera initially."]],
  });
  const clipAt = controls.slider("clipAt", {
    label: "Clip at", tip: "Position of the plane along its normal.",
    min: 0, max: 1, step: 0.002,
    text: (value) => `${Math.round(100 * value)} %`,
  });
  const face = h("button", { type: "button", "data-tip": "Turns the plane towards the camera." }, "Face the camera");
  face.addEventListener("click", () => change({ clip: "oblique", clipNormal: null }));
  const facing = h("div", { class: "chips" }, face);
  const flip = controls.toggle("clipFlipped", {
    label: "Keep the other side", tip: "Flips the plane.",
  });
  const crop = choice<"off" | "box">({
    label: "Crop", tip: "Hides everything outside of a box. Drag its handles in the picture. Exports contain whole surfaces.",
    choices: [["off", "Off"], ["box", "Box"]],
    onChange: (kind) => change({ crop: kind === "box" ? initialCrop(shown()) : null }),
  });
  const filled = controls.toggle("filled", {
    label: "Fill", tip: "Shows samples where surfaces are clipped or cropped: inside them, or the image of labels.",
  });
  return {
    elements: [clip, clipAt, facing, flip, crop.element, filled],
    show: (settings) => {
      controls.show(settings);
      crop.show(settings.crop ? "box" : "off");
      clipAt.hidden = facing.hidden = flip.hidden = settings.clip === "off";
      filled.hidden = !permitsSamples || (settings.clip === "off" && !settings.crop);
    },
    showPermission: (permits) => { permitsSamples = permits; },
  };
}

// Returns a slightly smaller box, whose effect is seen.
function initialCrop({ low, high }: Crop): Crop {
  const at = (share: number) => low.map((from, axis) => from + share * (high[axis] - from)) as Vec3;
  return { low: at(0.08), high: at(0.92) };
}
