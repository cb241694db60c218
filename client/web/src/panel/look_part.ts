// How the surface is shown: nothing here changes what it is, but that normals are sent or not.
import { choice, slider, toggle } from "./inputs";
import type { Change, Part } from "./part";

export function lookPart(change: Change): Part {
  const shading = choice({
    label: "Shading", tip: "Where the directions for light come from.",
    words: [
      ["field", "From the data", "The field's own gradients, sent with the surface: the smoothest."],
      ["smooth", "Computed", "From the triangles, averaged where they meet: less to send."],
      ["facets", "Facets", "Each triangle flat, as it is."],
    ],
    chosen: (value) => change({ shading: value }),
  });
  const colouring = choice({
    label: "Colours", tip: "See the method at work.",
    words: [
      ["plain", "Plain"],
      ["tiles", "Tiles", "One colour for each tile: what is encoded, sent and kept as one."],
      ["steps", "Steps", "By the step in which a tile came: red first, then orange, yellow, green."],
    ],
    chosen: (value) => change({ colouring: value }),
  });
  const wireframe = toggle({
    label: "Wireframe", tip: "Shows the triangles: large where the surface is flat.",
    turned: (value) => change({ wireframe: value }),
  });
  const clip = choice({
    label: "Cut", tip: "A plane that cuts the surface open.",
    words: [["off", "Off"], ["x", "x"], ["y", "y"], ["z", "z"]],
    chosen: (value) => change({ clip: value }),
  });
  const clipAt = slider({
    label: "Cut at", tip: "Where the plane lies along its axis.",
    min: 0, max: 1, step: 0.002,
    text: (value) => `${Math.round(100 * value)} %`,
    moved: (value) => change({ clipAt: value }),
  });
  const flip = toggle({
    label: "Keep the other side", tip: "Turns the plane over.",
    turned: (value) => change({ clipFlipped: value }),
  });
  const axes = toggle({
    label: "Axes and box", tip: "The data's extent, with its axes: x red, y green, z blue.",
    turned: (value) => change({ axes: value }),
  });
  const theme = choice({
    label: "Theme", tip: "Light or dark, or as your system has it.",
    words: [["auto", "System"], ["dark", "Dark"], ["light", "Light"]],
    chosen: (value) => change({ theme: value }),
  });
  return {
    elements: [
      colouring.element, wireframe.element, shading.element, clip.element, clipAt.element,
      flip.element, axes.element, theme.element,
    ],
    show: (s) => {
      shading.show(s.shading);
      colouring.show(s.colouring);
      wireframe.show(s.wireframe);
      clip.show(s.clip);
      clipAt.show(s.clipAt);
      flip.show(s.clipFlipped);
      clipAt.element.hidden = flip.element.hidden = s.clip === "off";
      axes.show(s.axes);
      theme.show(s.theme);
    },
  };
}
