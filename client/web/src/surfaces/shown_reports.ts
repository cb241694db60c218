// Reports the steps that are drawn, for listeners: of visible surfaces only, with the place in the list of surfaces; again
// when a surface becomes visible or moves to another place.

import type { Progress, StepFacts } from "../state/progress";
import type { Settings } from "../state/settings";
import type { ViewerEvents } from "../viewer/viewer_events";

type Shown = ViewerEvents["shown"];

export interface DrawnSteps {
  progressOf: (at: number) => Pick<Progress, "shown" | "components">;
  isCurrent: (at: number) => boolean;
}

export class ShownReports {
  private reported: (StepFacts | null)[] = []; // By place.

  constructor(
    private readonly steps: DrawnSteps,
    private readonly settings: () => Settings,
    private readonly report: (shown: Shown) => void,
  ) {}

  // Returns the steps that are drawn now.
  get current(): Shown[] {
    return this.settings().surfaces.flatMap(({ visible }, at) => this.stepAt(at, visible) ?? []);
  }

  // Call when a step was shown at this place.
  add(at: number): void {
    const step = this.stepAt(at, this.settings().surfaces[at]?.visible ?? false);
    if (step) this.reportAt(at, step);
  }

  // Call when the surfaces of changed settings were requested.
  update(): void {
    const list = this.settings().surfaces;
    this.reported.length = list.length;
    list.forEach(({ visible }, at) => {
      const step = this.stepAt(at, visible);
      if (!step) this.reported[at] = null;
      else if (this.steps.progressOf(at).shown !== this.reported[at]) this.reportAt(at, step);
    });
  }

  private reportAt(at: number, step: Shown): void {
    this.reported[at] = this.steps.progressOf(at).shown;
    this.report(step);
  }

  private stepAt(at: number, visible: boolean): Shown | null {
    const { shown, components } = this.steps.progressOf(at);
    return visible && shown && this.steps.isCurrent(at) ? { ...shown, surface: at, components } : null;
  }
}
