// View-dependent detail: whether requests name the view, so that what is near has a finer surface. It waits until the
// first surface has shown that link and machine are fast, or until the user switches it on.
import type { Settings } from "./state/settings";
import { surfacesOf } from "./state/surfaces";
import type { View } from "./stream/request";

const mostSurfacesInView = 24;
const slowSurface = 2000; // Milliseconds from the first request to its final step.

export class DetailByPixels {
  private isSlow: boolean | null = null; // Null: no surface was complete yet.

  // The user wants it, however slow surfaces come.
  switchOn(): void {
    this.isSlow = false;
  }

  // Whether it is wanted, and waits because the first surface was slow.
  isPaused({ followView }: Settings): boolean {
    return this.isSlow === true && followView;
  }

  // The view that requests name. Null: none. While times play, all of them have one error; of a thousand labels each turn
  // of the camera would request all again.
  view(settings: Settings, current: () => View): View | null {
    const isMany = surfacesOf(settings).filter(({ visible }) => visible).length > mostSurfacesInView;
    return this.isSlow !== false || settings.playing || isMany ? null : current();
  }

  // The first surface is complete, so many milliseconds after its request; null: it came without one. Returns whether
  // requests name the view from now on.
  learn(complete: number | null): boolean {
    if (this.isSlow !== null || complete === null) return false;
    this.isSlow = complete > slowSurface;
    return !this.isSlow;
  }
}
