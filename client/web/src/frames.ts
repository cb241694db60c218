// A cache of final steps: showing one again, or a prefetched one, needs no server as long as all its tiles are cached.
import { toBinary } from "@bufbuild/protobuf";

import { IsosurfaceRequestSchema } from "./protocol/messages";
import type { ShownSurface } from "./shown_surface";
import { type HiddenParts, nothingHidden } from "./state/hidden_parts";
import type { StreamRequest } from "./stream/conversation";
import type { Selection } from "./workers/worker_messages";

export interface Frame {
  ids: readonly string[]; // Tile ids.
  shown: ShownSurface;
  chosen: Chosen; // Its visible components when it was last shown.
}

// The visible part of a step.
export interface Chosen {
  hidden: HiddenParts;
  selection: Selection | null; // Null: all components are visible.
}

export const allChosen: Chosen = { hidden: nothingHidden, selection: null };

export class Frames {
  private readonly kept = new Map<string, Frame>();
  private readonly colors = new Map<string, string>(); // The latest coloring of each dataset's tiles.

  constructor(private readonly hasTiles: (ids: readonly string[]) => boolean) {}

  find(order: StreamRequest): Frame | null {
    if (this.kept.size === 0) return null;
    const key = keyOf(order);
    const frame = this.kept.get(key);
    if (!frame) return null;
    if (this.hasTiles(frame.ids)) return frame;
    this.kept.delete(key);
    return null;
  }

  keep(order: StreamRequest, frame: Frame): void {
    for (const [key, { ids }] of this.kept) if (!this.hasTiles(ids)) this.kept.delete(key);
    this.kept.set(keyOf(order), frame);
  }

  // Call when a stream begins. Tiles have one coloring at a time, so steps with another coloring are dropped.
  expect(order: StreamRequest): void {
    const { name } = order.info;
    const coloring = coloringOf(order);
    if ((this.colors.get(name) ?? coloring) !== coloring) {
      for (const [key, { shown }] of this.kept) if (shown.info.name === name) this.kept.delete(key);
    }
    this.colors.set(name, coloring);
  }
}

// Equal for orders that give equal surfaces in equal colors.
function keyOf(order: StreamRequest): string {
  const { name, contentId } = order.info;
  return [name, contentId, coloringOf(order), toBinary(IsosurfaceRequestSchema, order.request).join()].join("\n");
}

function coloringOf({ scalars }: StreamRequest): string {
  return scalars ? `${scalars.dataset} ${scalars.low} ${scalars.high}` : "";
}
