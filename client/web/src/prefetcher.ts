// Prefetches final steps of one surface at upcoming times, over its own connection with the lowest priority; one stream
// runs at a time. The steps are cached by the surface and not drawn.
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

const shareOfMemory = 0.6; // The rest is for shown and earlier steps.

export class Prefetcher {
  private client: SurfaceClient | null = null;
  private soon: readonly PrefetchRequest[] = []; // The soonest first.
  private settings: Settings | null = null;
  private view: View | null = null;
  private underWay: StreamRequest | null = null;
  private failed: StreamRequest[] = []; // Orders without a result.

  constructor(private readonly parts: SurfaceClientParts) {}

  // Replaces the requests; a running one continues only if it is among them. Empty: closes the connection.
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

  // Returns whether the step is cached or has failed.
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

  // Requests the next missing step, unless earlier ones fill the memory. Prefetched steps are kept longer than others.
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
    if (!underWay || client!.isBusy) return; // Busy: the server postponed it.
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
