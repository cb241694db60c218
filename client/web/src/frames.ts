// A cache of final steps: showing one again, or a prefetched one, needs no server as long as all its tiles are here.
import { toBinary } from "@bufbuild/protobuf";

import { IsosurfaceRequestSchema } from "./protocol/messages";
import type { ShownSurface } from "./shown_surface";
import type { Wanted } from "./stream/conversation";
import type { Selection } from "./workers/worker_messages";

export interface Frame {
  ids: readonly string[]; // The ids of its tiles.
  shown: ShownSurface;
  chosen: Chosen; // Its components, when it was shown last.
}

// What of a step is shown: components from that size on.
export interface Chosen {
  minComponent: number; // Samples.
  selection: Selection | null; // Null: all of them are.
}

export const allChosen: Chosen = { minComponent: 0, selection: null };

export class Frames {
  private readonly kept = new Map<string, Frame>();
  private readonly colours = new Map<string, string>(); // The colours of a dataset's tiles that were set last.

  constructor(private readonly hasTiles: (ids: readonly string[]) => boolean) {}

  find(order: Wanted): Frame | null {
    const key = keyOf(order);
    const frame = this.kept.get(key);
    if (!frame) return null;
    if (this.hasTiles(frame.ids)) return frame;
    this.kept.delete(key);
    return null;
  }

  keep(order: Wanted, frame: Frame): void {
    for (const [key, { ids }] of this.kept) if (!this.hasTiles(ids)) this.kept.delete(key);
    this.kept.set(keyOf(order), frame);
  }

  // A stream of this order begins: tiles have one colouring at a time, so steps that have another are no more.
  expect(order: Wanted): void {
    const { name } = order.info;
    const colouring = colouringOf(order);
    if ((this.colours.get(name) ?? colouring) !== colouring) {
      for (const [key, { shown }] of this.kept) if (shown.info.name === name) this.kept.delete(key);
    }
    this.colours.set(name, colouring);
  }
}

// Equal for orders with equal surfaces in equal colours.
function keyOf(order: Wanted): string {
  const { name, contentId } = order.info;
  return [name, contentId, colouringOf(order), toBinary(IsosurfaceRequestSchema, order.request).join()].join("\n");
}

function colouringOf({ scalars }: Wanted): string {
  return scalars ? `${scalars.dataset} ${scalars.low} ${scalars.high}` : "";
}
