// Prefetches final steps of one surface at upcoming times, over its own connection with the lowest priority; one stream
// runs at a time. The steps are cached by the surface and not drawn.

import type { DatasetInfo } from "../protocol/messages";
import type { OwnSettings } from "../state/surfaces";
import { isosurfaceRequest, type View } from "../stream/request";
import { isSameStream, type ScalarOptions, type StreamRequest } from "../stream/stream_request";
import { SurfaceClient, type SurfaceClientParts } from "./surface_client";
import type { SceneTime } from "./swap_group";

export interface PrefetchRequest {
  info: DatasetInfo;
  time: SceneTime;
  scalars?: ScalarOptions;
}

const memoryFraction = 0.6; // The rest is for shown and earlier steps.

export class Prefetcher {
  private client: SurfaceClient | null = null;
  private upcoming: readonly PrefetchRequest[] = []; // The soonest first.
  private settings: OwnSettings | null = null;
  private view: View | null = null;
  private running: StreamRequest | null = null;
  private failed: StreamRequest[] = []; // Orders without a result.

  constructor(private readonly parts: SurfaceClientParts) {}

  // Replaces the requests; a running one continues only if it is among them. Empty: closes the connection.
  prepare(requests: readonly PrefetchRequest[], settings: OwnSettings, view: View | null): void {
    this.upcoming = requests;
    this.settings = settings;
    this.view = view;
    if (requests.length === 0) return this.close();
    const { running } = this;
    if (running && !requests.some((one) => isSameStream(requestOf(one, settings, view), running))) {
      this.client!.stop();
      this.running = null;
    }
    this.requestNext();
  }

  // Returns whether the step is cached or has failed.
  has(one: Omit<PrefetchRequest, "time">, settings: OwnSettings, view: View | null): boolean {
    const request = requestOf(one, settings, view);
    return this.parts.stepCache.find(request) !== null || this.hasFailed(request);
  }

  close(): void {
    this.client?.close();
    this.client = null;
    this.parts.connections.close();
    this.parts.surface.release(this);
    this.running = null;
    this.failed = [];
  }

  // Requests the next missing step, unless earlier ones fill the memory. Prefetched steps are kept longer than others.
  private requestNext(): void {
    if (this.running || !this.settings) return;
    const { surface, stepCache } = this.parts;
    let triangles = 0;
    surface.release(this);
    for (const one of this.upcoming) {
      const request = requestOf(one, this.settings, this.view);
      const step = stepCache.find(request);
      if (!step && this.hasFailed(request)) continue;
      if (!step) return this.fetch(one, request);
      surface.use(step.ids, this);
      triangles += surface.trianglesOf(step.ids);
      if (triangles > memoryFraction * surface.budget) return;
    }
  }

  private fetch(one: PrefetchRequest, request: StreamRequest): void {
    this.running = request;
    this.client ??= new SurfaceClient(
      { ...this.parts, isPrefetch: true },
      {
        offer: () => {},
        withdraw: () => {},
        shown: () => {},
        settled: () => this.settled(),
      },
    );
    this.client.request(one.info, this.settings!, this.view, one);
  }

  private settled(): void {
    const { client, running } = this;
    if (!running || client!.isBusy) return; // Busy: the server has postponed it.
    this.running = null;
    if (!this.parts.stepCache.find(running)) this.failed.push(running);
    this.requestNext();
  }

  private hasFailed(request: StreamRequest): boolean {
    return this.failed.some((one) => isSameStream(one, request));
  }
}

function requestOf({ info, scalars }: Omit<PrefetchRequest, "time">, settings: OwnSettings, view: View | null): StreamRequest {
  return { info, isosurface: isosurfaceRequest(info, settings, view), scalars };
}
