// The events of a viewer.
import type { DatasetInfo } from "../protocol/messages";
import type { Picked } from "../scene/picking";
import type { ShownLevel } from "../scene/volume/volume";
import type { ShownComponents, StepFacts } from "../state/progress";
import type { Settings } from "../state/settings";

export interface ViewerEvents {
  settings: Settings; // All of them, after any change.
  dataset: DatasetInfo; // Another dataset is selected, or the current one was prepared again.
  // A drawn step of a visible surface (0 for the first) and its visible components; null: all. Again when the surface
  // becomes visible or moves to another place.
  shown: StepFacts & { surface: number; components: ShownComponents | null };
  progress: { surface: number };
  volume: ShownLevel | null; // The shown samples of the volume; null: none.
  failed: string; // A nonexistent dataset was named, or nothing can be drawn: the reason in a sentence. Failures of a surface are in its progress.
  picked: Picked;
}
