// The calls that an embedding page can make: those of the module `multitetra-viewer` (module.ts) and, as messages,
// of a frame (embedding.ts). client/web/EMBEDDING.md documents them.

import type { DatasetInfo } from "../protocol/messages";
import type { Picked } from "../scene/picking";
import { Events } from "../state/events";
import { parseSettings } from "../state/parse_settings";
import type { StepFacts } from "../state/progress";
import type { WrittenSettings } from "../state/settings";
import { written } from "../state/written_settings";
import type { Viewer } from "../viewer/viewer";
import type { PictureOptions } from "../viewer/viewer_options";
import type { EmbeddedDataset, EmbeddedEvents, EmbeddedPick, EmbeddedStep } from "./embedded_events";
import { isWeak, maxTrianglesOfWeakDevices, thisDevice } from "./weak_device";

const together = 100; // Milliseconds: changes within this time are reported together.
const maxPictureWait = 60_000; // Milliseconds without progress.

export type Timers = Pick<Window, "setTimeout" | "clearTimeout">;

export class EmbeddedViewer {
  private readonly events = new Events<EmbeddedEvents>();
  private timer = 0;
  private isFitDue = false; // When a step of the set isovalue is shown.
  private failure = ""; // Why the requested surface is not shown; empty: no failure.

  constructor(
    private readonly viewer: Viewer,
    private readonly timers: Timers = window,
  ) {
    viewer.on("settings", () => {
      timers.clearTimeout(this.timer);
      this.timer = timers.setTimeout(() => this.events.emit("state", this.get()), together);
    });
    viewer.on("dataset", (info) => {
      this.failure = "";
      this.events.emit("dataset", this.summaryOf(info));
    });
    viewer.on("shown", (facts) => {
      if (viewer.isBlank) return;
      this.failure = "";
      this.events.emit("shown", stepOf(facts));
      if (this.isFitDue) this.fit();
    });
    viewer.on("failed", (text) => this.fail(text));
    viewer.on("progress", ({ surface }) => {
      const { failure, phase } = viewer.surfaces.progressOf(surface);
      this.fail(failure?.text ?? (phase === "lost" ? "No connection to the server; trying again." : undefined));
    });
    viewer.on("picked", (place) => this.events.emit("picked", pickOf(place)));
  }

  on<K extends keyof EmbeddedEvents>(kind: K, listener: (what: EmbeddedEvents[K]) => void): () => void {
    return this.events.on(kind, listener);
  }

  // Returns the names of unknown or invalid settings, such as "error" or "surfaces[1].opacity", which are ignored.
  set(given: unknown, isDragging: boolean): string[] {
    const { settings, ignored } = parseSettings(given);
    this.failure = "";
    this.viewer.setWritten(settings, isDragging);
    return ignored;
  }

  get(): WrittenSettings {
    return written(this.viewer.get());
  }

  // Limits the triangles on weak devices, for pages that do not choose the limit.
  limitOnWeakDevices(): void {
    if (isWeak(thisDevice(this.viewer.stage.renderer.getContext()))) this.viewer.set({ maxTriangles: maxTrianglesOfWeakDevices });
  }

  // Shows the whole surface as set, once it is there.
  fit(): void {
    this.isFitDue = !this.viewer.surfaces.isCurrent(0);
    if (!this.isFitDue) this.viewer.fit();
  }

  reset(): void {
    this.viewer.reset();
  }

  // Rejects after a minute without progress: a picture of a frame that the browser does not draw, or of a very slow
  // surface, would never be complete.
  async picture(options: PictureOptions = {}): Promise<Blob> {
    options.signal?.throwIfAborted();
    const wait = new AbortController();
    const error = new Error(`Nothing more of the surface arrived for ${maxPictureWait / 1000} s.`);
    const extend = () => {
      this.timers.clearTimeout(timer);
      timer = this.timers.setTimeout(() => wait.abort(error), maxPictureWait);
    };
    let timer: number | undefined;
    extend();
    const ignore = this.viewer.on("progress", extend);
    const abort = () => wait.abort(options.signal!.reason);
    options.signal?.addEventListener("abort", abort);
    try {
      return await this.viewer.picture({ ...options, signal: wait.signal });
    } finally {
      this.timers.clearTimeout(timer);
      options.signal?.removeEventListener("abort", abort);
      ignore();
    }
  }

  // Emits the current state to a listener that was added later.
  emitMissed(): void {
    const { info, surfaces } = this.viewer;
    if (info) this.events.emit("dataset", this.summaryOf(info));
    for (const shown of surfaces.reports.current) this.events.emit("shown", stepOf(shown));
    if (this.failure) this.events.emit("error", this.failure);
  }

  private fail(text: string | undefined): void {
    if (!text || text === this.failure) return;
    this.failure = text;
    this.events.emit("error", text);
  }

  private summaryOf(info: DatasetInfo): EmbeddedDataset {
    return {
      name: info.name,
      dims: [...info.dims],
      spacing: [...info.spacing],
      min: info.min,
      max: info.max,
      lengthUnit: info.lengthUnit,
      assumed: info.assumed,
      valueUnit: info.valueUnit,
      suggestedIsovalues: [...info.suggestedIsovalues],
      member: memberOf(info),
      times: this.viewer.playback.times?.all ?? [],
    };
  }
}

function memberOf({ member }: DatasetInfo): EmbeddedDataset["member"] {
  if (!member) return null;
  const { series, field, time = null, timeUnit, label } = member;
  return { series, field, time, timeUnit, label: label ? { value: label.value, name: label.name } : null };
}

function stepOf(facts: StepFacts & Pick<EmbeddedStep, "surface" | "components">): EmbeddedStep {
  return facts.spacing > 1 ? { ...facts, errorWorld: null, errorVoxels: null } : facts;
}

function pickOf({ world, index, surface }: Picked): EmbeddedPick {
  return { world, index, isovalue: surface ? surface.tiles.shown.facts.isovalue : null };
}
