// The values of settings that are more than a number or a word.
export type Place = [number, number, number]; // World coordinates.

export interface BoxRegion {
  kind: "box";
  low: Place;
  high: Place;
  error: number; // Voxels.
}
export interface BallRegion {
  kind: "ball";
  center: Place;
  radius: number;
  error: number;
}
export type Region = BoxRegion | BallRegion;

// A box in world coordinates.
export type Crop = Pick<BoxRegion, "low" | "high">;

export const materials = ["neutral", "skin", "bone", "glossy", "matcap"] as const;
export type Material = (typeof materials)[number];

export const maxLabels = 1024; // Of a segmentation.
export const maxMinComponent = 1e6; // In samples, as everywhere in the project.
export const maxHiddenParts = 64; // Per surface.
export const maxNoteLength = 80; // Characters of a note or a label's name.
export const maxPlaces = 3; // Measured at a time: two lengths and an angle.

// In samples: components whose bounding box has a shorter diagonal are hidden; or all but the one with the longest.
export type MinComponent = number | "largest";

// A place that the user picked to measure.
export interface MeasuredPlace {
  world: Place;
  bound: number | null; // The largest distance from the intended place, in world units; null: unknown.
  note?: string; // The user's note.
}

// A surface, of the view's dataset or another one in the same world.
export interface SurfaceSettings {
  dataset: string; // Empty: the view's, as always of the first surface.
  isovalue: number | null; // Null: the dataset's own suggestion.
  error: number | null; // Voxels; null: the view's.
  color: string; // "#rrggbb"
  opacity: number; // 0 to 1 (opaque).
  visible: boolean;
  minComponent: MinComponent; // 0: none is hidden.
  hiddenParts: readonly Place[]; // The component nearest to each is hidden.
  material: Material;
}

// The opacity of one voxel with this value, 0 to 1.
export interface OpacityPoint {
  value: number;
  opacity: number;
}
export const maxOpacityPoints = 16;

export interface LabelName {
  label: number;
  name: string;
}
