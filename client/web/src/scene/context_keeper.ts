// Keeps the GPU context of a scene while it is in sight. Browsers draw about 16 scenes of a site at a time and take the
// context of the oldest one away, for good: so a scene that is out of sight gives its context back, and takes it again
// when it is seen.
import type * as THREE from "three";

const releaseAfter = 2000; // Milliseconds out of sight.
const returnsWithin = 2000; // Milliseconds after which a context that was taken away is gone.

export const contextGoneText = "The browser took the graphics of this view away: it draws only about 16 of a site at a time.";

export interface ContextEvents {
  gone: () => void; // The context was taken away and did not return.
  restored: () => void; // Everything must be drawn again.
}

export class ContextKeeper {
  private state: "held" | "released" | "lost" | "gone" = "held";
  private timer: ReturnType<typeof setTimeout> | undefined;
  private waiting: { resolve: () => void; reject: (reason: Error) => void }[] = [];
  private readonly observer: IntersectionObserver;

  constructor(
    private readonly renderer: THREE.WebGLRenderer,
    canvas: HTMLCanvasElement,
    private readonly events: ContextEvents,
  ) {
    canvas.addEventListener("webglcontextlost", () => this.lose());
    canvas.addEventListener("webglcontextrestored", () => this.restore());
    this.observer = new IntersectionObserver((entries) => this.see(entries[entries.length - 1].isIntersecting));
    this.observer.observe(canvas);
  }

  get isGone(): boolean {
    return this.state === "gone";
  }

  // Resolves when there is a context, also out of sight; rejects if it is gone.
  take(): Promise<void> {
    if (this.state === "held") return Promise.resolve();
    if (this.state === "gone") return Promise.reject(new Error(contextGoneText));
    return new Promise((resolve, reject) => {
      this.waiting.push({ resolve, reject });
      this.reclaim();
    });
  }

  dispose(): void {
    clearTimeout(this.timer);
    this.observer.disconnect();
    this.state = "gone";
  }

  private see(isSeen: boolean): void {
    if (isSeen) this.reclaim();
    if (this.state !== "held") return;
    clearTimeout(this.timer);
    if (!isSeen) this.timer = setTimeout(() => this.release(), releaseAfter);
  }

  private release(): void {
    this.state = "released";
    this.renderer.forceContextLoss();
  }

  private reclaim(): void {
    if (this.state !== "released") return;
    this.state = "lost";
    // The event of the loss may be pending: until then, the context cannot be restored.
    if (this.renderer.getContext().isContextLost()) setTimeout(() => this.renderer.forceContextRestore());
    this.expectReturn();
  }

  private lose(): void {
    if (this.state !== "held") return;
    this.state = "lost";
    this.expectReturn();
  }

  private expectReturn(): void {
    clearTimeout(this.timer);
    this.timer = setTimeout(() => {
      this.state = "gone";
      for (const { reject } of this.waiting.splice(0)) reject(new Error(contextGoneText));
      this.events.gone();
    }, returnsWithin);
  }

  private restore(): void {
    clearTimeout(this.timer);
    this.state = "held";
    this.events.restored();
    for (const { resolve } of this.waiting.splice(0)) resolve();
  }
}
