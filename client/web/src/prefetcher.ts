// Prefetches final steps of one surface at times that are shown soon, over a connection of its own and with the least priority;
// one stream runs at a time. The steps go into the surface's memory and are not drawn.
import type { Moment } from "./swap_group";
import type { DatasetInfo } from "./protocol/messages";
import type { Settings } from "./state/settings";
import { isSameOrder, type ScalarOptions, type StreamRequest } from "./stream/conversation";
import { isosurfaceRequest, type View } from "./stream/request";
import { SurfaceClient, type SurfaceClientParts } from "./surface_client";

export interface PrefetchRequest {
  info: DatasetInfo;
  moment: Moment;
  scalars?: ScalarOptions;
}

const shareOfMemory = 0.6; // The rest is for what is shown, and what was.

export class Prefetcher {
  private client: SurfaceClient | null = null;
  private soon: readonly PrefetchRequest[] = []; // The soonest first.
  private settings: Settings | null = null;
  private view: View | null = null;
  private underWay: StreamRequest | null = null;
  private failed: StreamRequest[] = []; // There will be none of these.

  constructor(private readonly parts: SurfaceClientParts) {}

  // A running request continues only if it still is among them. None: the connection ends.
  prepare(soon: readonly PrefetchRequest[], settings: Settings, view: View | null): void {
    this.soon = soon;
    this.settings = settings;
    this.view = view;
    if (soon.length === 0) return this.close();
    const { underWay } = this;
    if (underWay && !soon.some((one) => isSameOrder(orderOf(one, settings, view), underWay))) {
      this.client!.stop();
      this.underWay = null;
    }
    this.goOn();
  }

  // Whether it is here, or will not come.
  has(one: Omit<PrefetchRequest, "moment">, settings: Settings, view: View | null): boolean {
    const order = orderOf(one, settings, view);
    return this.parts.frames.find(order) !== null || this.hasFailed(order);
  }

  close(): void {
    this.client?.close();
    this.client = null;
    this.parts.surface.release(this);
    this.underWay = null;
    this.failed = [];
  }

  // The next missing one, unless the earlier ones fill the memory. Prefetched ones are kept longer than others.
  private goOn(): void {
    if (this.underWay || !this.settings) return;
    const { surface, frames } = this.parts;
    let triangles = 0;
    surface.release(this);
    for (const one of this.soon) {
      const order = orderOf(one, this.settings, this.view);
      const frame = frames.find(order);
      if (!frame && this.hasFailed(order)) continue;
      if (!frame) return this.bring(one, order);
      surface.use(frame.ids, this);
      triangles += surface.trianglesOf(frame.ids);
      if (triangles > shareOfMemory * surface.budget) return;
    }
  }

  private bring(one: PrefetchRequest, order: StreamRequest): void {
    this.underWay = order;
    this.client ??= new SurfaceClient({ ...this.parts, isPrefetch: true }, {
      offer: () => {},
      withdraw: () => {},
      shown: () => {},
      settled: () => this.settled(),
    });
    this.client.want(one.info, this.settings!, this.view, one);
  }

  private settled(): void {
    const { client, underWay } = this;
    if (!underWay || client!.isBusy) return; // Busy: the server has it wait.
    this.underWay = null;
    if (!this.parts.frames.find(underWay)) this.failed.push(underWay);
    this.goOn();
  }

  private hasFailed(order: StreamRequest): boolean {
    return this.failed.some((one) => isSameOrder(one, order));
  }
}

function orderOf({ info, scalars }: Omit<PrefetchRequest, "moment">, settings: Settings, view: View | null): StreamRequest {
  return { info, request: isosurfaceRequest(info, settings, view), scalars };
}
