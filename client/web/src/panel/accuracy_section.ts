// Controls for the error or the size of the surface.
import type { DatasetInfo } from "../protocol/messages";
import { button, chips } from "../shared/elements";
import { counted, grouped } from "../shared/quantities";
import { qualities } from "../state/setting_formats";
import { lengthText, voxelLength } from "../stream/dataset";
import { foldedSection } from "./inputs";
import { type Change, errorScale, type PanelSection } from "./panel_section";
import { SettingControls } from "./setting_controls";

const drawablePositions = 36; // 1 to 60 million triangles.
const budgetPositions = 40; // 10 000 to 10 million triangles, then no limit.

export interface AccuracyPart extends PanelSection {
  showPaused: (isPaused: boolean) => void; // While the view-dependent error is not applied.
}

// `expected` shows the expected size of the surface.
export function accuracyPart(change: Change, expected: HTMLElement): AccuracyPart {
  let info: DatasetInfo | null = null;
  const controls = new SettingControls(change);
  const world = (voxels: number) => (info ? ` (${lengthText(voxels * voxelLength(info), info)})` : "");
  const error = controls.slider("error", "Allowed error", "Largest distance from the full-resolution surface. Larger errors need fewer triangles.", {
    ...errorScale,
    text: (value) => (value === 0 ? "none: full resolution" : counted(value, "voxel") + world(value)),
  });
  const named = [...qualities].map(([word, voxels]) => {
    const tip = voxels === 0 ? "Full resolution." : `An error of ${counted(voxels, "voxel")}.`;
    return { voxels, element: button(word[0].toUpperCase() + word.slice(1), () => change({ error: voxels }), { "data-tip": tip }) };
  });
  const bound = controls.choice("bound", "Kind of error", "How the error of removing a point is measured.", {
    certified: ["Guaranteed", "A bound: the actual distance never exceeds the allowed error."],
    paper: ["Estimated", "The estimate of the 1997 method; the actual distance may exceed it."],
  });
  const rule = controls.choice("topologyRule", "Preserving the topology", "Which points are kept to preserve parts, tunnels and cavities.", {
    exact: ["Exact", "Only points where the topology changes: fewer triangles."],
    paper: ["Cautious", "All points where a sign changes, as in the 1997 method."],
  });
  const toleranceTip = "Parts, tunnels and cavities up to this size may be removed. 0 keeps all of them.";
  const tolerance = controls.slider("topologyTolerance", "Features that may vanish", toleranceTip, {
    min: 0,
    max: 4,
    step: 1,
    toPosition: (value) => (value < 1 ? 0 : Math.min(4, Math.log2(value) + 1)),
    fromPosition: (at) => (at === 0 ? 0 : 2 ** (at - 1)),
    text: (value) => (value === 0 ? "none" : `up to ${counted(value, "voxel")}`),
  });
  const budget = controls.slider("maxTriangles", "At most", "A budget: the server uses the smallest error that fits.", {
    min: 0,
    max: budgetPositions,
    step: 1,
    toPosition: (value) => (value === 0 ? budgetPositions : Math.round(((Math.log10(value) - 4) / 3) * (budgetPositions - 1))),
    fromPosition: (at) => (at >= budgetPositions ? 0 : Number((10 ** (4 + (3 * at) / (budgetPositions - 1))).toPrecision(2))),
    text: (value) => (value === 0 ? "any number of triangles" : `${grouped(value)} triangles`),
  });
  const drawableTip =
    "Shows the full-resolution surface, where it is complete sooner than the simplified one, up to what the graphics card turns smoothly. From the next surface on.";
  const drawable = controls.slider("drawableTriangles", "Full resolution up to", drawableTip, {
    min: 0,
    max: drawablePositions,
    step: 1,
    toPosition: (value) => Math.round((Math.log(Math.max(value, 1e6) / 1e6) / Math.log(60)) * drawablePositions),
    fromPosition: (at) => Number((1e6 * 60 ** (at / drawablePositions)).toPrecision(2)),
    text: (value) => `${grouped(value)} triangles`,
  });
  const simplifyTip = "Removes triangles that the allowed error does not require: far fewer remain, the bound holds. The server needs more time.";
  const simplify = controls.toggle("simplify", "Simplify", simplifyTip);
  const followTip = "Finer than the allowed error where it exceeds this many pixels; requested again when the camera stops.";
  const follow = controls.toggle("followView", "View-dependent detail", followTip);
  const pixelsTip = "How many pixels an error may cover in the view. The allowed error applies everywhere.";
  const pixels = controls.slider("pixels", "Error on the screen", pixelsTip, { min: 0.5, max: 8, step: 0.5, text: (value) => counted(value, "pixel") });
  const qualitiesRow = chips("Qualities", ...named.map(({ element }) => element));
  return {
    elements: [error, qualitiesRow, expected, budget, simplify, follow, pixels, foldedSection("More about accuracy", false, drawable, bound, rule, tolerance)],
    show: ({ settings, info: shown }) => {
      info = shown;
      controls.show(settings);
      pixels.hidden = !settings.followView;
      for (const { element, voxels } of named) element.setAttribute("aria-pressed", String(settings.error === voxels));
    },
    showPaused: (isPaused) => {
      follow.classList.toggle("is-off", isPaused);
      follow.setAttribute("data-tip", isPaused ? "Paused because the first surface was slow. Switch it off and on to use it." : followTip);
    },
  };
}
