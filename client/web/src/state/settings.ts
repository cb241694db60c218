// All settings of a user as one plain value: the request and its display. The page's address contains all of them.
import type { ColorMap } from "../shared/color_maps";

export interface BoxRegion {
  kind: "box";
  low: [number, number, number]; // World coordinates.
  high: [number, number, number];
  error: number; // Voxels.
}
export interface BallRegion {
  kind: "ball";
  center: [number, number, number];
  radius: number;
  error: number;
}
export type Region = BoxRegion | BallRegion;

// A box in world coordinates.
export type Crop = Pick<BoxRegion, "low" | "high">;

export type Shading = "field" | "smooth" | "facets";
export type Coloring = "plain" | "tiles" | "steps";
export type Axis = "off" | "x" | "y" | "z";
export type Cut = Axis | "oblique";
export type Projection = "perspective" | "orthographic";
export const materials = ["neutral", "skin", "bone", "glossy", "matcap"] as const;
export type Material = (typeof materials)[number];
export type Layout = "surface" | "four";
export type Theme = "auto" | "dark" | "light";

export const maxHiddenParts = 64; // Per surface.
export const maxNoteLength = 80; // Characters of a note or a label's name.
export const maxPlaces = 3; // Measured at a time: two lengths and an angle.

// In samples: components whose bounding box has a shorter diagonal are hidden; or all but the one with the longest.
export type MinComponent = number | "largest";

// A place that the user picked to measure.
export interface MeasuredPlace {
  world: [number, number, number];
  bound: number | null; // The largest distance from the intended place, in world units; null: unknown.
  note?: string; // The user's note.
}

// A further surface, of the same dataset or another one in the same world.
export interface AdditionalSurface {
  dataset?: string; // Empty or absent: that of the first surface.
  isovalue: number;
  error: number | null; // Voxels; null: that of the first surface.
  color: string; // "#rrggbb"
  opacity: number; // 0 to 1 (opaque).
  visible: boolean;
  minComponent?: MinComponent; // See Settings; default: 0.
  hiddenParts?: readonly [number, number, number][]; // See Settings; default: none.
  material?: Material; // Default: neutral.
}

export interface LabelName {
  label: number;
  name: string;
}

export interface Settings {
  // The request.
  dataset: string; // Or a series of datasets: its first member.
  t: number | null; // The time within a series; the nearest one is shown. Null: the dataset's own.
  isovalue: number | null; // Null: the dataset's own suggestion.
  error: number; // Voxels.
  bound: "certified" | "paper";
  topologyRule: "exact" | "paper";
  topologyTolerance: number; // Voxels.
  region: Region | null;
  followView: boolean; // Reduces the error where it exceeds `pixels` on the screen.
  pixels: number; // Allowed error on the screen, with followView.
  maxTriangles: number; // 0: no limit.
  simplify: boolean; // Removes triangles that the error does not require.
  surfaces: readonly AdditionalSurface[]; // All but the first; state/surfaces.ts has all as one list.
  labels: string; // The visible labels of a segmentation, in a form of label_ranges.ts, until they become surfaces; then empty.
  labelNames: readonly LabelName[]; // Names given by the user.
  // Display.
  color: string; // This and the next five are of the first surface.
  material: Material;
  opacity: number;
  visible: boolean;
  minComponent: MinComponent; // 0: none is hidden.
  hiddenParts: readonly [number, number, number][]; // World coordinates: the component nearest to each is hidden.
  colorBy: string; // The dataset whose values color the surfaces; empty: none.
  colors: ColorMap; // This and the next four: the color scale of those values.
  fieldLevel: number | null;
  fieldWindow: number | null;
  fieldLog: boolean; // Logarithmic color scale.
  noValueColor: string; // The color where the field has no value.
  shading: Shading;
  wireframe: boolean;
  coloring: Coloring;
  clip: Cut;
  clipAt: number; // 0 to 1 along the plane's normal.
  // The normal of an oblique cut, a unit vector in world coordinates; null: none chosen.
  clipNormal: [number, number, number] | null;
  clipFlipped: boolean;
  crop: Crop | null; // The box outside of which everything is hidden; null: nothing is.
  filled: boolean; // Fills the cut and the crop's faces with the samples inside the surfaces.
  slice: Axis; // A plane of samples in the scene.
  samplesOf: string; // The dataset whose samples planes show; empty: the first surface's, or the image of a segmentation.
  transparentAir: boolean; // Hides samples of air.
  sliceAt: number; // 0 to 1 along the axis.
  layout: Layout; // The surface alone, or with three orthogonal slices.
  // The point where the three slices intersect, in world coordinates; null: the center of the data.
  cross: [number, number, number] | null;
  sliceColors: ColorMap; // The colors of samples.
  // The center and the length of the sample colors' range; null: a range that shows most of the data.
  level: number | null;
  windowWidth: number | null;
  samplesLog: boolean;
  axes: boolean;
  projection: Projection;
  occlusion: boolean; // Darkens hollows.
  logScale: boolean;
  theme: Theme;
  playing: boolean; // Plays the times.
  speed: number; // Times per second, 0.1 to 60.
  loop: boolean; // Restarts after the last time.
  up: [number, number, number]; // The up direction, a unit vector in world coordinates.
  eye: [number, number, number] | null; // World coordinates; null: the default view.
  target: [number, number, number] | null;
  places: readonly MeasuredPlace[]; // At most three.
}

export const defaults: Settings = {
  dataset: "",
  t: null,
  isovalue: null,
  error: 0.25,
  bound: "certified",
  topologyRule: "exact",
  topologyTolerance: 0,
  region: null,
  followView: true,
  pixels: 1,
  maxTriangles: 0,
  simplify: true,
  surfaces: [],
  labels: "",
  labelNames: [],
  color: "#e0cdb4",
  material: "neutral",
  opacity: 1,
  visible: true,
  minComponent: 0,
  hiddenParts: [],
  colorBy: "",
  colors: "viridis",
  fieldLevel: null,
  fieldWindow: null,
  fieldLog: false,
  noValueColor: "#808080",
  shading: "smooth",
  wireframe: false,
  coloring: "plain",
  clip: "off",
  clipAt: 0.5,
  clipNormal: null,
  clipFlipped: false,
  crop: null,
  filled: true,
  slice: "off",
  samplesOf: "",
  transparentAir: true,
  sliceAt: 0.5,
  layout: "surface",
  cross: null,
  sliceColors: "gray",
  level: null,
  windowWidth: null,
  samplesLog: false,
  axes: true,
  projection: "perspective",
  occlusion: true,
  logScale: true,
  theme: "auto",
  playing: false,
  speed: 10,
  loop: true,
  up: [0, 0, 1],
  eye: null,
  target: null,
  places: [],
};

// Returns whether a new request is needed now. Not for another dataset or time: these are requested when the dataset is
// available. Surfaces other than the first are requested when they become visible.
export function isOtherRequest(now: Settings, before: Settings): boolean {
  if (now.dataset !== before.dataset || now.t !== before.t) return false;
  const hasNormals = (s: Settings) => s.shading === "field";
  const isOther = (name: keyof Settings) => now[name] !== before[name];
  const further = ({ surfaces }: Settings) => surfaces.map(({ dataset, isovalue, error, visible }) => `${dataset ?? ""} ${isovalue} ${error} ${visible}`).join();
  return (
    further(now) !== further(before) || requestSettings.some(isOther) || (now.followView && isOther("pixels")) || hasNormals(now) !== hasNormals(before)
  );
}

const requestSettings = [
  "isovalue", "visible", "error", "bound", "topologyRule", "topologyTolerance", "region", "followView", "maxTriangles", "simplify",
  "colorBy",
] as const;
