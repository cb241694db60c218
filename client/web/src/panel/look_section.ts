// The display of the surface. Nothing here changes its shape; shading decides if normals are sent.
import { h } from "../shared/elements";
import type { Change, PanelSection } from "./panel_section";
import { SettingControls } from "./setting_controls";

export function lookPart(change: Change, roll: (radians: number) => void): PanelSection {
  // These need no new surface, so dragging them costs the server nothing.
  const controls = new SettingControls((changes) => change(changes));
  const coloring = controls.choice("coloring", {
    label: "Colors", tip: "See the method at work.",
    words: [
      ["plain", "Plain"],
      ["tiles", "Tiles", "One color for each tile: what is encoded, sent and kept as one."],
      ["steps", "Steps", "By the step in which a tile came: red first, then orange, yellow, green."],
    ],
  });
  const wireframe = controls.toggle("wireframe", {
    label: "Wireframe", tip: "Shows the triangles: large where the surface is flat.",
  });
  const shading = controls.choice("shading", {
    label: "Shading", tip: "Where the directions for light come from.",
    words: [
      ["smooth", "Computed", "From the triangles, averaged where they meet: the least to send."],
      ["field", "From the data", "The field's own gradients, sent with the surface: the smoothest, and several times as much to send."],
      ["facets", "Facets", "Each triangle flat, as it is."],
    ],
  });
  const clip = controls.choice("clip", {
    label: "Cut", tip: "A plane that cuts the surface open. Drag its handles in the picture to move and turn it.",
    words: [["off", "Off"], ["x", "x"], ["y", "y"], ["z", "z"], ["oblique", "Oblique", "Faces the camera at first."]],
  });
  const clipAt = controls.slider("clipAt", {
    label: "Cut at", tip: "Where the plane lies along its normal.",
    min: 0, max: 1, step: 0.002,
    text: (value) => `${Math.round(100 * value)} %`,
  });
  const face = h("button", { type: "button", "data-tip": "Turns the plane, so that one looks straight at it." }, "Face the camera");
  face.addEventListener("click", () => change({ clip: "oblique", clipNormal: null }));
  const facing = h("div", { class: "chips" }, face);
  const flip = controls.toggle("clipFlipped", {
    label: "Keep the other side", tip: "Turns the plane over.",
  });
  const filled = controls.toggle("filled", {
    label: "Fill the cut", tip: "Shows the samples inside of the surfaces where they are cut, those of hidden components as well.",
  });
  const axes = controls.toggle("axes", {
    label: "Axes and box", tip: "The data's extent, with its axes: x red, y green, z blue.",
  });
  const projection = controls.choice("projection", {
    label: "Projection", tip: "How what is far becomes small.",
    words: [
      ["perspective", "Perspective", "As one sees it."],
      ["orthographic", "Parallel", "Lengths are alike near and far: the scale holds everywhere."],
    ],
  });
  const rolls = ([["Roll left", -1, "A quarter turn against the clock; [ and ] turn by a little."],
    ["Roll right", 1, "A quarter turn with the clock; [ and ] turn by a little."], ["Flip", 2, "Upside down (U)."]] as const)
    .map(([word, quarters, tip]) => {
      const button = h("button", { type: "button", "data-tip": tip }, word);
      button.addEventListener("click", () => roll((quarters * Math.PI) / 2));
      return button;
    });
  const upright = h("div", { class: "chips", role: "group", "aria-label": "Roll" }, ...rolls);
  const occlusion = controls.toggle("occlusion", {
    label: "Ambient occlusion", tip: "Makes hollows darker; where it takes long, when nothing moves.",
  });
  const theme = controls.choice("theme", {
    label: "Theme", tip: "Light or dark, or as your system has it.",
    words: [["auto", "System"], ["dark", "Dark"], ["light", "Light"]],
  });
  return {
    elements: [coloring, wireframe, shading, clip, clipAt, facing, flip, filled, axes, upright, projection, occlusion, theme],
    show: (settings) => {
      controls.show(settings);
      clipAt.hidden = facing.hidden = flip.hidden = filled.hidden = settings.clip === "off";
    },
  };
}
