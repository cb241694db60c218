// What the parts of the panel have in common.
import type { DatasetInfo } from "../protocol/messages";
import type { Settings } from "../state/settings";

// Some controls that show settings and change them.
export interface PanelSection {
  elements: HTMLElement[];
  show: (settings: Settings, info: DatasetInfo | null) => void;
}

// `isDragging`: more changes will follow at once.
export type Change = (change: Partial<Settings>, isDragging?: boolean) => void;

export const maxError = 8; // Voxels, of sliders.

// Sliders have more room for small errors, which matter most.
export const errorScale = {
  min: 0,
  max: 1,
  step: 0.001,
  toPosition: (error: number) => Math.sqrt(Math.min(error, maxError) / maxError),
  fromPosition: (at: number) => Number((Math.round(at * at * maxError * 40) / 40).toFixed(3)),
};
