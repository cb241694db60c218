// The interface of the panel's sections.
import type { DatasetInfo } from "../protocol/messages";
import type { Settings } from "../state/settings";

// Controls that show and change settings.
export interface PanelSection {
  elements: HTMLElement[];
  show: (settings: Settings, info: DatasetInfo | null) => void;
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
