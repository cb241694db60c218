// The display of the surface. Nothing here changes its shape; shading decides if normals are sent.
import { h } from "../shared/elements";
import type { Change, PanelSection } from "./panel_section";
import { SettingControls } from "./setting_controls";

export function lookPart(change: Change, roll: (radians: number) => void): PanelSection {
  // These need no new surface, so dragging them costs the server nothing.
  const controls = new SettingControls((changes) => change(changes));
  const coloring = controls.choice("coloring", {
    label: "Colors",
    tip: "See the method at work.",
    choices: [
      ["plain", "Plain"],
      ["tiles", "Tiles", "One color for each tile, the unit of encoding, sending and caching."],
      ["steps", "Steps", "By the step in which a tile was received: red first, then orange, yellow, green."],
    ],
  });
  const wireframe = controls.toggle("wireframe", {
    label: "Wireframe",
    tip: "Shows the triangles: large where the surface is flat.",
  });
  const shading = controls.choice("shading", {
    label: "Shading",
    tip: "How normals are computed.",
    choices: [
      ["smooth", "Computed", "From the triangles, averaged at vertices: the smallest transfer."],
      ["field", "From the data", "The field's gradients, sent with the surface: the smoothest, with a transfer several times as large."],
      ["facets", "Facets", "Flat triangles."],
    ],
  });
  const axes = controls.toggle("axes", {
    label: "Axes and box",
    tip: "The data's extent, with its axes: x red, y green, z blue.",
  });
  const projection = controls.choice("projection", {
    label: "Projection",
    tip: "Whether distant parts appear smaller.",
    choices: [
      ["perspective", "Perspective", "Distant parts appear smaller."],
      ["orthographic", "Parallel", "Equal lengths near and far: the scale bar applies everywhere."],
    ],
  });
  const rolls = (
    [
      ["Roll left", -1, "A quarter turn counterclockwise; [ and ] turn in small steps."],
      ["Roll right", 1, "A quarter turn clockwise; [ and ] turn in small steps."],
      ["Flip", 2, "Upside down (U)."],
    ] as const
  ).map(([word, quarters, tip]) => {
    const button = h("button", { type: "button", "data-tip": tip }, word);
    button.addEventListener("click", () => roll((quarters * Math.PI) / 2));
    return button;
  });
  const upright = h("div", { class: "chips", role: "group", "aria-label": "Roll" }, ...rolls);
  const occlusion = controls.toggle("occlusion", {
    label: "Ambient occlusion",
    tip: "Darkens cavities; if it is slow, only when nothing moves.",
  });
  const theme = controls.choice("theme", {
    label: "Theme",
    tip: "Light, dark, or the system's setting.",
    choices: [
      ["auto", "System"],
      ["dark", "Dark"],
      ["light", "Light"],
    ],
  });
  return {
    elements: [coloring, wireframe, shading, axes, upright, projection, occlusion, theme],
    show: (settings) => controls.show(settings),
  };
}
