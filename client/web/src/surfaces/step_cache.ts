// A cache of final steps: showing one again, or a prefetched one, needs no server as long as all its tiles are cached.
import { toBinary } from "@bufbuild/protobuf";

import { IsosurfaceRequestSchema } from "../protocol/messages";
import { type HiddenParts, nothingHidden } from "../state/hidden_parts";
import type { StreamRequest } from "../stream/stream_request";
import type { Selection } from "../workers/worker_messages";
import type { ShownSurface } from "./shown_surface";

export interface CachedStep {
  ids: readonly string[]; // Tile ids.
  shown: ShownSurface;
  visible: VisibleComponents; // Its visible components when it was last shown.
}

// The visible part of a step.
export interface VisibleComponents {
  hidden: HiddenParts;
  selection: Selection | null; // Null: all components are visible.
}

export const allComponents: VisibleComponents = { hidden: nothingHidden, selection: null };

export class StepCache {
  private readonly steps = new Map<string, CachedStep>();
  private readonly colors = new Map<string, string>(); // The latest coloring of each dataset's tiles.

  constructor(private readonly hasTiles: (ids: readonly string[]) => boolean) {}

  find(request: StreamRequest): CachedStep | null {
    if (this.steps.size === 0) return null;
    const key = keyOf(request);
    const step = this.steps.get(key);
    if (!step) return null;
    if (this.hasTiles(step.ids)) return step;
    this.steps.delete(key);
    return null;
  }

  keep(request: StreamRequest, step: CachedStep): void {
    for (const [key, { ids }] of this.steps) if (!this.hasTiles(ids)) this.steps.delete(key);
    this.steps.set(keyOf(request), step);
  }

  // Call when a stream begins. Tiles have one coloring at a time, so steps with another coloring are dropped.
  beginColoring(request: StreamRequest): void {
    const { name } = request.info;
    const coloring = coloringOf(request);
    if ((this.colors.get(name) ?? coloring) !== coloring) {
      for (const [key, { shown }] of this.steps) if (shown.info.name === name) this.steps.delete(key);
    }
    this.colors.set(name, coloring);
  }
}

// Equal for requests that give equal surfaces in equal colors.
function keyOf(request: StreamRequest): string {
  const { name, contentId } = request.info;
  return [name, contentId, coloringOf(request), toBinary(IsosurfaceRequestSchema, request.isosurface).join()].join("\n");
}

function coloringOf({ scalars }: StreamRequest): string {
  return scalars ? `${scalars.dataset} ${scalars.low} ${scalars.high}` : "";
}
