// The side panel: everything one can turn, in the order in which one needs it.
import type { DatasetInfo } from "../protocol/messages";
import type { Settings } from "../state/settings";
import { defaults } from "../state/settings";
import type { Store } from "../state/store";
import { suggestedIsovalue } from "../stream/request";
import { voxelLength, worldBox } from "../stream/dataset";
import { counted, grouped, h, inDigits } from "./dom";
import { HistogramView } from "./histogram";
import { choice, folded, section, slider, toggle } from "./inputs";

export interface PanelEvents {
  // The isovalue or the error moves and will move on.
  dragging: (isDragging: boolean) => void;
  fit: () => void;
  reset: () => void;
  screenshot: () => void;
  download: (format: "glb" | "ply" | "stl") => void;
  copyLink: () => void;
}

const maxError = 8;
const budgetPositions = 40; // 10 000 to 10 million triangles, then no limit.

export class Panel {
  readonly element: HTMLElement;
  readonly histogram: HistogramView;
  private readonly shows: ((settings: Settings) => void)[] = [];
  private readonly suggestions = h("div", { class: "chips" });
  private readonly isovalueInput = h("input", {
    type: "number", step: "any", "aria-label": "Isovalue", class: "number",
  });
  // Until it was done once.
  private readonly dragHint = h("p", { class: "hint" },
    "Drag the line: the surface runs where the data has this value.");
  private info: DatasetInfo | null = null;

  constructor(
    private readonly settings: Store<Settings>,
    private readonly events: PanelEvents,
    datasets: HTMLElement,
  ) {
    this.histogram = new HistogramView({
      moved: (isovalue, isDragging) => {
        this.dragHint.hidden = true;
        localStorage.setItem("hasDragged", "yes");
        this.change({ isovalue }, isDragging);
      },
    });
    this.dragHint.hidden = localStorage.getItem("hasDragged") !== null;
    this.isovalueInput.addEventListener("change", () => {
      const isovalue = this.isovalueInput.valueAsNumber;
      if (Number.isFinite(isovalue)) this.change({ isovalue });
    });
    this.element = h("aside", { class: "panel", "aria-label": "Controls" },
      h("header", {}, h("h1", {}, "Multi-Tetra"), h("p", {}, "surfaces of volume data, streamed")),
      section("Dataset", datasets),
      this.isovalueSection(),
      this.accuracySection(),
      folded("Finer in one place", false, ...this.regionControls()),
      folded("Appearance", false, ...this.lookControls()),
      folded("Take it with you", false, ...this.takeAway()),
    );
    settings.watch((now) => this.show(now));
  }

  setDataset(info: DatasetInfo): void {
    this.info = info;
    const chips = info.suggestedIsovalues.slice(0, 5).map((value) => {
      const chip = h("button", { type: "button" }, inDigits(value));
      chip.addEventListener("click", () => this.change({ isovalue: value }));
      return chip;
    });
    this.suggestions.replaceChildren(...(chips.length > 1 ? chips : []));
    this.show(this.settings.get());
  }

  private show(settings: Settings): void {
    for (const show of this.shows) show(settings);
    if (!this.info) return;
    const isovalue = settings.isovalue ?? suggestedIsovalue(this.info);
    this.histogram.show(this.info, isovalue, settings.logScale);
    if (document.activeElement !== this.isovalueInput) this.isovalueInput.value = String(isovalue);
  }

  private change(change: Partial<Settings>, isDragging = false): void {
    if (isDragging) this.events.dragging(true);
    this.settings.set(change);
    if (!isDragging) this.events.dragging(false);
  }

  private isovalueSection(): HTMLElement {
    const log = toggle({
      label: "log", tip: "Logarithmic heights: rare values become visible.",
      turned: (logScale) => this.change({ logScale }),
    });
    this.shows.push(({ logScale }) => log.show(logScale));
    return h("section", {},
      h("div", { class: "section-head" }, h("h2", {}, "Isovalue"), this.isovalueInput, log.element),
      this.histogram.element, this.suggestions, this.dragHint);
  }

  private accuracySection(): HTMLElement {
    const world = (voxels: number) =>
      this.info ? ` (${counted(voxels * voxelLength(this.info), "unit")})` : "";
    const error = slider({
      label: "Allowed error",
      tip: "How far the surface may be from the one at full resolution. Larger errors need fewer triangles.",
      min: 0, max: 1, step: 0.001,
      // More room for small errors, which matter most.
      toPosition: (value) => Math.sqrt(Math.min(value, maxError) / maxError),
      fromPosition: (at) => Number((Math.round(at * at * maxError * 40) / 40).toFixed(3)),
      text: (value) => (value === 0 ? "none: full resolution" : counted(value, "voxel") + world(value)),
      moved: (value, isDragging) => this.change({ error: value }, isDragging),
    });
    const bound = choice({
      label: "Kind of error",
      tip: "How the error of leaving out a point is measured.",
      words: [
        ["certified", "Guaranteed", "A bound: the real distance is never larger than the allowed error."],
        ["paper", "Estimated", "The measure of the 1997 method; the real distance may exceed it."],
      ],
      chosen: (value) => this.change({ bound: value }),
    });
    const rule = choice({
      label: "Keeping the topology",
      tip: "Which points must stay so that parts, tunnels and hollows stay.",
      words: [
        ["exact", "Exact", "Only points where the topology really changes: fewer triangles."],
        ["paper", "Cautious", "Every change of sign counts, as in the 1997 method."],
      ],
      chosen: (value) => this.change({ rule: value }),
    });
    const tolerance = slider({
      label: "Features that may vanish",
      tip: "Parts, tunnels and hollows up to this size may be left out. 0 keeps every one of them.",
      min: 0, max: 4, step: 1,
      toPosition: (value) => (value < 1 ? 0 : Math.min(4, Math.log2(value) + 1)),
      fromPosition: (at) => (at === 0 ? 0 : 2 ** (at - 1)),
      text: (value) => (value === 0 ? "none" : `up to ${counted(value, "voxel")}`),
      moved: (value, isDragging) => this.change({ tolerance: value }, isDragging),
    });
    const budget = slider({
      label: "At most",
      tip: "A budget: the server takes the smallest error that fits.",
      min: 0, max: budgetPositions, step: 1,
      toPosition: (value) => value === 0 ? budgetPositions : Math.round(((Math.log10(value) - 4) / 3) * (budgetPositions - 1)),
      fromPosition: (at) => at >= budgetPositions ? 0 : Number((10 ** (4 + (3 * at) / (budgetPositions - 1))).toPrecision(2)),
      text: (value) => (value === 0 ? "any number of triangles" : `${grouped(value)} triangles`),
      moved: (value, isDragging) => this.change({ maxTriangles: value }, isDragging),
    });
    const follow = toggle({
      label: "Follow the camera",
      tip: "Fine where you look and near, coarse elsewhere; asks anew when the camera rests.",
      turned: (followView) => this.change({ followView }),
    });
    const pixels = slider({
      label: "Error on the screen", tip: "How many pixels of your screen an error may cover.",
      min: 0.5, max: 8, step: 0.5,
      text: (value) => counted(value, "pixel"),
      moved: (value, isDragging) => this.change({ pixels: value }, isDragging),
    });
    this.shows.push((s) => {
      error.show(s.error);
      bound.show(s.bound);
      rule.show(s.rule);
      tolerance.show(s.tolerance);
      budget.show(s.maxTriangles);
      follow.show(s.followView);
      pixels.show(s.pixels);
      pixels.element.hidden = !s.followView;
      error.element.classList.toggle("is-off", s.followView);
    });
    return section("Accuracy", error.element, budget.element, follow.element, pixels.element,
      folded("More about accuracy", false, bound.element, rule.element, tolerance.element));
  }

  private regionControls(): HTMLElement[] {
    const shape = choice({
      label: "Region",
      tip: "A place where another error holds. Drag its handles in the picture.",
      words: [["none", "None"], ["box", "Box"], ["ball", "Ball"]],
      chosen: (kind) => this.chooseRegion(kind),
    });
    const error = slider({
      label: "Error inside", tip: "The error allowed in the region.",
      min: 0, max: 1, step: 0.001,
      toPosition: (value) => Math.sqrt(Math.min(value, maxError) / maxError),
      fromPosition: (at) => Number((Math.round(at * at * maxError * 40) / 40).toFixed(3)),
      text: (value) => (value === 0 ? "none: full resolution" : counted(value, "voxel")),
      moved: (value, isDragging) => {
        const { region } = this.settings.get();
        if (region) this.change({ region: { ...region, error: value } }, isDragging);
      },
    });
    const hint = h("p", { class: "hint" }, "Allow a larger error above to see the difference.");
    this.shows.push(({ region, error: everywhere }) => {
      shape.show(region?.kind ?? "none");
      error.element.hidden = !region;
      if (region) error.show(region.error);
      hint.hidden = !region || everywhere > region.error;
    });
    return [shape.element, error.element, hint];
  }

  private chooseRegion(kind: "none" | "box" | "ball"): void {
    if (kind === "none" || !this.info) return this.change({ region: null });
    const error = this.settings.get().region?.error ?? 0;
    const { low, high } = worldBox(this.info);
    const centre = low.map((value, axis) => (value + high[axis]) / 2) as [number, number, number];
    const size = low.map((value, axis) => high[axis] - value);
    if (kind === "ball") {
      this.change({ region: { kind, centre, radius: Math.min(...size) / 5, error } });
      return;
    }
    const corner = (sign: number) =>
      centre.map((value, axis) => value + (sign * size[axis]) / 6) as [number, number, number];
    this.change({ region: { kind, low: corner(-1), high: corner(1), error } });
  }

  private lookControls(): HTMLElement[] {
    const shading = choice({
      label: "Shading", tip: "Where the directions for light come from.",
      words: [
        ["field", "From the data", "The field's own gradients, sent with the surface: the smoothest."],
        ["smooth", "Computed", "From the triangles, averaged where they meet: less to send."],
        ["facets", "Facets", "Each triangle flat, as it is."],
      ],
      chosen: (value) => this.change({ shading: value }),
    });
    const colouring = choice({
      label: "Colours", tip: "See the method at work.",
      words: [
        ["plain", "Plain"],
        ["tiles", "Tiles", "One colour for each tile: what is encoded, sent and kept as one."],
        ["steps", "Steps", "By the step in which a tile came: red first, then orange, yellow, green."],
      ],
      chosen: (value) => this.change({ colouring: value }),
    });
    const wireframe = toggle({
      label: "Wireframe", tip: "Shows the triangles: large where the surface is flat.",
      turned: (value) => this.change({ wireframe: value }),
    });
    const clip = choice({
      label: "Cut", tip: "A plane that cuts the surface open.",
      words: [["off", "Off"], ["x", "x"], ["y", "y"], ["z", "z"]],
      chosen: (value) => this.change({ clip: value }),
    });
    const clipAt = slider({
      label: "Cut at", tip: "Where the plane lies along its axis.",
      min: 0, max: 1, step: 0.002,
      text: (value) => `${Math.round(100 * value)} %`,
      moved: (value) => this.change({ clipAt: value }),
    });
    const flip = toggle({
      label: "Keep the other side", tip: "Turns the plane over.",
      turned: (value) => this.change({ clipFlipped: value }),
    });
    const axes = toggle({
      label: "Axes and box", tip: "The data's extent, with its axes: x red, y green, z blue.",
      turned: (value) => this.change({ axes: value }),
    });
    const theme = choice({
      label: "Theme", tip: "Light or dark, or as your system has it.",
      words: [["auto", "System"], ["dark", "Dark"], ["light", "Light"]],
      chosen: (value) => this.change({ theme: value }),
    });
    this.shows.push((s) => {
      shading.show(s.shading);
      colouring.show(s.colouring);
      wireframe.show(s.wireframe);
      clip.show(s.clip);
      clipAt.show(s.clipAt);
      flip.show(s.clipFlipped);
      clipAt.element.hidden = flip.element.hidden = s.clip === "off";
      axes.show(s.axes);
      theme.show(s.theme);
    });
    return [colouring.element, wireframe.element, shading.element, clip.element, clipAt.element,
      flip.element, axes.element, theme.element];
  }

  private takeAway(): HTMLElement[] {
    const button = (word: string, tip: string, act: () => void) => {
      const element = h("button", { type: "button", class: "action", "data-tip": tip }, word);
      element.addEventListener("click", act);
      return element;
    };
    const { events } = this;
    return [
      h("div", { class: "actions" },
        button("Copy link", "The address of exactly this view, with all settings.", events.copyLink),
        button("Picture", "What you see, as PNG.", events.screenshot),
        button("GLB", "The shown surface for Blender, web and office programs.", () => events.download("glb")),
        button("PLY", "The shown surface for ParaView, MeshLab, CloudCompare.", () => events.download("ply")),
        button("STL", "The shown surface for 3D printing.", () => events.download("stl")),
        button("Start over", "All settings as they were in the beginning.", () => {
          const { dataset, theme } = this.settings.get();
          this.change({ ...defaults, dataset, theme });
          events.reset();
        })),
    ];
  }
}
