// Controls for the error or the size of the surface.
import type { DatasetInfo } from "../protocol/messages";
import { h } from "../shared/elements";
import { counted, grouped } from "../shared/quantities";
import { qualities } from "../state/setting_formats";
import { lengthText, voxelLength } from "../stream/dataset";
import { foldedSection } from "./inputs";
import { type Change, errorScale, type PanelSection } from "./panel_section";
import { SettingControls } from "./setting_controls";

const budgetPositions = 40; // 10 000 to 10 million triangles, then no limit.

export interface AccuracyPart extends PanelSection {
  showPaused: (isPaused: boolean) => void; // While the view-dependent error is not applied.
}

// `expected` shows the expected size of the surface.
export function accuracyPart(change: Change, expected: HTMLElement): AccuracyPart {
  let info: DatasetInfo | null = null;
  const controls = new SettingControls(change);
  const world = (voxels: number) => (info ? ` (${lengthText(voxels * voxelLength(info), info)})` : "");
  const error = controls.slider("error", {
    label: "Allowed error",
    tip: "Largest distance from the full-resolution surface. Larger errors need fewer triangles.",
    ...errorScale,
    text: (value) => (value === 0 ? "none: full resolution" : counted(value, "voxel") + world(value)),
  });
  const named = [...qualities].map(([word, voxels]) => {
    const button = h(
      "button",
      { type: "button", "data-tip": voxels === 0 ? "Full resolution." : `An error of ${counted(voxels, "voxel")}.` },
      word[0].toUpperCase() + word.slice(1),
    );
    button.addEventListener("click", () => change({ error: voxels }));
    return { button, voxels };
  });
  const chips = h("div", { class: "chips", role: "group", "aria-label": "Qualities" }, ...named.map(({ button }) => button));
  const bound = controls.choice("bound", {
    label: "Kind of error",
    tip: "How the error of removing a point is measured.",
    choices: [
      ["certified", "Guaranteed", "A bound: the actual distance never exceeds the allowed error."],
      ["paper", "Estimated", "The estimate of the 1997 method; the actual distance may exceed it."],
    ],
  });
  const rule = controls.choice("topologyRule", {
    label: "Preserving the topology",
    tip: "Which points are kept to preserve parts, tunnels and cavities.",
    choices: [
      ["exact", "Exact", "Only points where the topology changes: fewer triangles."],
      ["paper", "Cautious", "All points where a sign changes, as in the 1997 method."],
    ],
  });
  const tolerance = controls.slider("topologyTolerance", {
    label: "Features that may vanish",
    tip: "Parts, tunnels and cavities up to this size may be removed. 0 keeps all of them.",
    min: 0,
    max: 4,
    step: 1,
    toPosition: (value) => (value < 1 ? 0 : Math.min(4, Math.log2(value) + 1)),
    fromPosition: (at) => (at === 0 ? 0 : 2 ** (at - 1)),
    text: (value) => (value === 0 ? "none" : `up to ${counted(value, "voxel")}`),
  });
  const budget = controls.slider("maxTriangles", {
    label: "At most",
    tip: "A budget: the server uses the smallest error that fits.",
    min: 0,
    max: budgetPositions,
    step: 1,
    toPosition: (value) => (value === 0 ? budgetPositions : Math.round(((Math.log10(value) - 4) / 3) * (budgetPositions - 1))),
    fromPosition: (at) => (at >= budgetPositions ? 0 : Number((10 ** (4 + (3 * at) / (budgetPositions - 1))).toPrecision(2))),
    text: (value) => (value === 0 ? "any number of triangles" : `${grouped(value)} triangles`),
  });
  const simplify = controls.toggle("simplify", {
    label: "Simplify",
    tip: "Removes triangles that the allowed error does not require: far fewer remain, the bound " + "holds. The server needs more time.",
  });
  const follow = controls.toggle("followView", {
    label: "View-dependent detail",
    tip: "Finer than the allowed error where it exceeds this many pixels; requested again when the camera stops.",
  });
  const followTip = follow.getAttribute("data-tip")!;
  const pixels = controls.slider("pixels", {
    label: "Error on the screen",
    tip: "How many pixels an error may cover in the view. The allowed error applies everywhere.",
    min: 0.5,
    max: 8,
    step: 0.5,
    text: (value) => counted(value, "pixel"),
  });
  return {
    elements: [error, chips, expected, budget, simplify, follow, pixels, foldedSection("More about accuracy", false, bound, rule, tolerance)],
    show: (settings, shown) => {
      info = shown;
      controls.show(settings);
      pixels.hidden = !settings.followView;
      for (const { button, voxels } of named) button.setAttribute("aria-pressed", String(settings.error === voxels));
    },
    showPaused: (isPaused) => {
      follow.classList.toggle("is-off", isPaused);
      follow.setAttribute("data-tip", isPaused ? "Paused because the first surface was slow. Switch it off and on to use it." : followTip);
    },
  };
}
