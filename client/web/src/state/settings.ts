// All settings of a user as one plain value: the request, and how it is
// shown. The whole of it is in the page's address.
import type { ColorMap } from "../shared/color_maps";

export interface BoxRegion {
  kind: "box";
  low: [number, number, number]; // World coordinates.
  high: [number, number, number];
  error: number; // Voxels.
}
export interface BallRegion {
  kind: "ball";
  centre: [number, number, number];
  radius: number;
  error: number;
}
export type Region = BoxRegion | BallRegion;

export type Shading = "field" | "smooth" | "facets";
export type Coloring = "plain" | "tiles" | "steps";
export type Axis = "off" | "x" | "y" | "z";
export type Cut = Axis | "oblique";
export type Projection = "perspective" | "orthographic";
export const materials = ["neutral", "skin", "bone", "glossy", "matcap"] as const;
export type Material = (typeof materials)[number];
export type Layout = "surface" | "four";
export type Theme = "auto" | "dark" | "light";

export const mostHiddenParts = 64; // For each surface.
export const mostNote = 80; // Characters; also of a label's name.
export const mostPlaces = 3; // That are measured at a time: two lengths and an angle.

// A place that was picked to be measured.
export interface MeasuredPlace {
  world: [number, number, number];
  bound: number | null; // How far it may lie from where it was meant, in world units; null: not known.
  note?: string; // What the user has written on it.
}

// A surface beside the first one, of the same dataset or of another one in the same world.
export interface AdditionalSurface {
  dataset?: string; // Empty or absent: that of the first one.
  isovalue: number;
  error: number | null; // Voxels; null: as the first one.
  color: string; // "#rrggbb"
  opacity: number; // 0 to 1: nothing to see through.
  visible: boolean;
  minComponent?: number; // In samples, as for the first surface; default 0.
  hiddenParts?: readonly [number, number, number][]; // As for the first surface; default: none.
  material?: Material; // Default: neutral.
  largestOnly?: boolean; // As for the first surface; default: no.
}

export interface LabelName {
  label: number;
  name: string;
}

export interface Settings {
  // The request.
  dataset: string; // Or a series of datasets: the first of it.
  t: number | null; // The time that is shown, of a series that has times: the nearest. Null: the dataset's own.
  isovalue: number | null; // Null: the dataset's own suggestion.
  error: number; // Voxels, 0 to 8.
  bound: "certified" | "paper";
  topologyRule: "exact" | "paper";
  topologyTolerance: number; // Voxels.
  region: Region | null;
  followView: boolean; // Finer than the error where that is more than `pixels`.
  pixels: number; // Allowed error on the screen where the view is followed.
  maxTriangles: number; // 0: no limit.
  simplify: boolean; // Without the triangles that the error does not need.
  surfaces: readonly AdditionalSurface[]; // All but the first: state/surfaces.ts has all as one list.
  labels: string; // The labels of a segmentation that are shown, as label_ranges.ts writes them, until they are surfaces; then empty.
  labelNames: readonly LabelName[]; // Names that the user gives.
  // How it is shown.
  color: string; // This and the next six belong to the first surface.
  material: Material;
  opacity: number;
  visible: boolean;
  minComponent: number; // Samples: components whose bounding box has a shorter diagonal are hidden. 0: none.
  hiddenParts: readonly [number, number, number][]; // World coordinates: the component nearest to each is hidden.
  largestOnly: boolean; // Every component but the one with the largest bounding box is hidden.
  colorBy: string; // A dataset whose values color the surfaces; empty: none.
  colors: ColorMap; // These three are settings of those values.
  fieldLevel: number | null;
  fieldWindow: number | null;
  fieldLog: boolean; // Equal factors of the values have equal steps of color.
  noValueColor: string; // The color where the field has no value.
  shading: Shading;
  wireframe: boolean;
  coloring: Coloring;
  clip: Cut;
  clipAt: number; // 0 to 1 along the plane's normal.
  clipNormal: [number, number, number] | null; // Of an oblique cut: a unit vector in world coordinates; null: none was chosen.
  clipFlipped: boolean;
  filled: boolean; // The cut shows the samples inside of the surfaces.
  slice: Axis; // A plane of samples in the picture.
  transparentAir: boolean; // Samples of air are hidden.
  sliceAt: number; // 0 to 1 along the axis.
  layout: Layout; // The surface alone, or with three slices beside it that meet
  cross: [number, number, number] | null; // there, in world coordinates; null: in the middle of the data.
  sliceColors: ColorMap; // The colors of samples.
  level: number | null; // The sample value in the middle of the colors, and how many they span: null
  windowWidth: number | null; // for those that show most of the data.
  samplesLog: boolean;
  axes: boolean;
  projection: Projection;
  occlusion: boolean; // Hollows are darker.
  logScale: boolean;
  theme: Theme;
  playing: boolean; // One time after the other.
  speed: number; // Times a second, 0.1 to 60.
  loop: boolean; // After the last time comes the first.
  up: [number, number, number]; // A unit vector in world coordinates: up in the picture.
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
  largestOnly: false,
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
  filled: true,
  slice: "off",
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

// Whether a new request is needed now. Not for another dataset or time: the code that changes
// those requests when the dataset is there. Surfaces beside the first are requested when they are visible.
export function isOtherRequest(now: Settings, before: Settings): boolean {
  if (now.dataset !== before.dataset || now.t !== before.t) return false;
  const hasNormals = (s: Settings) => s.shading === "field";
  const isOther = (name: keyof Settings) => now[name] !== before[name];
  const further = ({ surfaces }: Settings) => surfaces.map(({ dataset, isovalue, error, visible }) => `${dataset ?? ""} ${isovalue} ${error} ${visible}`).join();
  return (
    further(now) !== further(before) || asking.some(isOther) || (now.followView && isOther("pixels")) || hasNormals(now) !== hasNormals(before)
  );
}

const asking = [
  "isovalue", "error", "bound", "topologyRule", "topologyTolerance", "region", "followView", "maxTriangles", "simplify",
  "colorBy",
] as const;
