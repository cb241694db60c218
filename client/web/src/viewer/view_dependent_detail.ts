// View-dependent detail: decides whether requests include the view, for finer surfaces near the camera. Starts after
// the first surface has shown that network and machine are fast, or when the user switches it on.
import type { Settings } from "../state/settings";
import type { View } from "../stream/request";

const maxSurfacesInView = 24;
const slowSurface = 2000; // Milliseconds from the first request to its final step.

export class ViewDependentDetail {
  private isSlow: boolean | null = null; // Null: no surface was complete yet.
  private readonly requiredBy = new Set<string>();

  // Call when the user requests it, regardless of speed.
  enable(): void {
    this.isSlow = false;
  }

  // Call when a surface, given by its key, is too large to be shown without a view. Returns whether that was unknown.
  require(surface: string): boolean {
    return this.requiredBy.size < this.requiredBy.add(surface).size;
  }

  // Returns whether it is requested but paused because the first surface was slow.
  isPaused({ followView }: Settings): boolean {
    return this.isSlow === true && followView;
  }

  // Returns the view for requests; null: none. During playback all times have the same error; with many labels every
  // camera turn would request all of them again.
  view(settings: Settings, current: () => View): View | null {
    const isMany = settings.surfaces.filter(({ visible }) => visible).length > maxSurfacesInView;
    const isOnlyRequired = this.isSlow !== false;
    if (settings.playing || isMany || (isOnlyRequired && this.requiredBy.size === 0)) return null;
    return { ...current(), requiredBy: this.requiredBy, isOnlyRequired };
  }

  // Call when the first surface is complete, with the milliseconds since its request; null: it was not requested.
  // Returns whether all requests include the view from now on.
  recordDuration(complete: number | null): boolean {
    if (this.isSlow !== null || complete === null) return false;
    this.isSlow = complete > slowSurface;
    return !this.isSlow;
  }
}
