// The interface of the panel's sections.
import type { DatasetInfo } from "../protocol/messages";
import { type ColorMap, colorMaps } from "../shared/color_maps";
import type { Settings } from "../state/settings";
import type { Choices } from "./inputs";

// What the panel shows.
export interface Shown {
  settings: Settings;
  info: DatasetInfo | null; // The dataset of the first surface.
  list: readonly DatasetInfo[]; // All datasets of the server; empty: not received yet.
  permitsSamples: boolean; // Whether the server permits more than surfaces.
}

// Controls that show and change settings.
export interface PanelSection {
  elements: HTMLElement[];
  show: (shown: Shown) => void;
}

// `isDragging`: more changes follow immediately.
export type Change = (change: Partial<Settings>, isDragging?: boolean) => void;

export const maxError = 8; // Voxels; the end of the sliders.

// Gives small errors, which matter most, more space on sliders.
export const errorScale = {
  min: 0,
  max: 1,
  step: 0.001,
  toPosition: (error: number) => Math.sqrt(Math.min(error, maxError) / maxError),
  fromPosition: (at: number) => Number((Math.round(at * at * maxError * 40) / 40).toFixed(3)),
};

// Along an axis or a normal.
export const shareScale = { min: 0, max: 1, step: 0.002 };

export const colorChoices = Object.fromEntries(colorMaps.map((map) => [map, map])) as Choices<ColorMap>;
export const noSamples = "The server permits surfaces only here, no samples.";
