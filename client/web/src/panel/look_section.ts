// The display of the surface. Nothing here changes its shape; shading decides if normals are sent.
import { button, chips } from "../shared/elements";
import type { Change, PanelSection } from "./panel_section";
import { SettingControls } from "./setting_controls";

export function lookPart(change: Change, roll: (radians: number) => void): PanelSection {
  // These need no new surface, so dragging them costs the server nothing.
  const controls = new SettingControls((changes) => change(changes));
  const turn = (word: string, quarters: number, tip: string) => button(word, () => roll((quarters * Math.PI) / 2), { "data-tip": tip });
  return {
    elements: [
      controls.choice("coloring", "Colors", "See the method at work.", {
        plain: "Plain",
        tiles: ["Tiles", "One color for each tile, the unit of encoding, sending and caching."],
        steps: ["Steps", "By the step in which a tile was received: red first, then orange, yellow, green."],
      }),
      controls.toggle("wireframe", "Wireframe", "Shows the triangles: large where the surface is flat."),
      controls.choice("shading", "Shading", "How normals are computed.", {
        smooth: ["Computed", "From the triangles, averaged at vertices: the smallest transfer."],
        field: ["From the data", "The field's gradients, sent with the surface: the smoothest, with a transfer several times as large."],
        facets: ["Facets", "Flat triangles."],
      }),
      controls.toggle("axes", "Axes and box", "The data's extent, with its axes: x red, y green, z blue."),
      chips(
        "Roll",
        turn("Roll left", -1, "A quarter turn counterclockwise; [ and ] turn in small steps."),
        turn("Roll right", 1, "A quarter turn clockwise; [ and ] turn in small steps."),
        turn("Flip", 2, "Upside down (U)."),
      ),
      controls.choice("projection", "Projection", "Whether distant parts appear smaller.", {
        perspective: ["Perspective", "Distant parts appear smaller."],
        orthographic: ["Parallel", "Equal lengths near and far: the scale bar applies everywhere."],
      }),
      controls.toggle("occlusion", "Ambient occlusion", "Darkens cavities; if it is slow, only when nothing moves."),
      controls.choice("theme", "Theme", "Light, dark, or the system's setting.", { auto: "System", dark: "Dark", light: "Light" }),
    ],
    show: ({ settings }) => controls.show(settings),
  };
}
