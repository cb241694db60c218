// The help page: mouse, touch and keyboard.
import { button, h } from "../shared/elements";

const hands = [
  ["Rotate", "drag", "one finger"],
  ["Zoom", "scroll", "pinch"],
  ["Pan", "right button, or Shift and drag", "two fingers"],
  ["Coordinates of a point", "click on the surface", "tap"],
  ["Add a note, hide a part", "in the box that a click opens", "tap"],
  ["Measure a length, an angle", "click a second and a third point", "tap"],
  ["Slices: move, next, zoom", "click, scroll, Ctrl and scroll", "drag, pinch"],
  ["Slices: measure", "double-click, or M at the crosshair", "double tap"],
] as const;

const keys = [
  ["Arrows", "rotate"],
  ["+ −", "zoom in, zoom out"],
  ["F", "fit the whole surface in the picture"],
  ["R", "reset view"],
  ["U", "flip: upside down"],
  ["[ ]", "roll"],
  ["W", "wireframe: the triangles"],
  ["C", "colors: plain, tiles, steps"],
  ["A", "axes, box and scale"],
  ["P", "perspective or parallel projection"],
  ["O", "ambient occlusion"],
  ["X", "clip along x, y, z, obliquely, off"],
  ["V", "three linked slices beside the surface"],
  ["Z", "fullscreen"],
  ["Space", "play or stop the times of a series"],
  [", .", "previous, next time"],
  ["Ctrl Z, Ctrl Y", "undo, redo"],
  ["Shift ↑ ↓, Space, Ctrl A on a label", "select several labels"],
  ["Esc", "close the list of checks, clear the measurement"],
  ["← → on the histogram", "move the isovalue"],
  ["?", "this page"],
] as const;

export class Help {
  readonly element: HTMLDialogElement;

  constructor() {
    const closeOutside = (event: Event) => event.target === this.element && this.element.close();
    this.element = h(
      "dialog",
      { class: "help", "aria-label": "How to use it", click: closeOutside },
      button("×", () => this.element.close(), { class: "close", "aria-label": "Close" }),
      h("h2", {}, "In the picture"),
      h(
        "table",
        {},
        h("tr", {}, h("td"), h("th", {}, "mouse"), h("th", {}, "touch")),
        ...hands.map(([what, mouse, touch]) => h("tr", {}, h("td", {}, what), h("td", {}, mouse), h("td", {}, touch))),
      ),
      h("h2", {}, "Keys"),
      h("table", {}, ...keys.map(([key, act]) => h("tr", {}, h("td", {}, h("kbd", {}, key)), h("td", {}, act)))),
      h("p", { class: "hint" }, "All other controls have tooltips: hover over a control with the mouse, or reach it with the " + "Tab key."),
    );
  }

  toggle(): void {
    if (this.element.open) this.element.close();
    else this.element.showModal();
  }
}
