// The events that an embedding page receives: from the module (module.ts) or as messages of a frame (embedding.ts).
import type { ShownComponents, StepFacts } from "../state/progress";
import type { WrittenSettings } from "../state/settings";

// A dataset, or another time of a series.
export interface EmbeddedDataset {
  name: string;
  dims: number[];
  spacing: number[];
  min: number;
  max: number;
  lengthUnit: string; // Empty: unknown.
  assumed: string; // What of the placement the source does not state: "spacing along z, origin".
  valueUnit: string;
  suggestedIsovalues: number[];
  member: { series: string; field: string; time: number | null; timeUnit: string; label: { value: number; name: string } | null } | null;
  times: readonly number[];
}

// A drawn step of a visible surface: 0 is the main one, 1 the first of `surfaces`. Errors are null for previews, whose
// distance to the surface is not bounded.
export type EmbeddedStep = Omit<StepFacts, "errorWorld" | "errorVoxels"> & {
  surface: number;
  components: ShownComponents | null; // Null: all are visible.
  errorWorld: number | null;
  errorVoxels: number | null;
};

export interface EmbeddedPick {
  world: readonly number[];
  index: readonly number[]; // Sample indices.
  isovalue: number | null; // Null: on a slice.
}

export interface EmbeddedEvents {
  state: WrittenSettings; // All settings, after changes.
  dataset: EmbeddedDataset;
  shown: EmbeddedStep;
  picked: EmbeddedPick;
  error: string; // The reason why the current settings cannot be shown.
}
