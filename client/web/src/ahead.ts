// Final steps of one surface at times that are wanted soon, over a connection of its own and with the
// least priority; one stream runs at a time. They go into the surface's memory, unseen.
import type { Moment } from "./curtain";
import type { DatasetInfo } from "./protocol/messages";
import type { Settings } from "./state/settings";
import type { ScalarWish, Wanted } from "./stream/conversation";
import { isosurfaceRequest, type View } from "./stream/request";
import { SurfaceClient, type SurfaceClientParts } from "./surface_client";

export interface WantedSoon {
  info: DatasetInfo;
  moment: Moment;
  scalars?: ScalarWish;
}

const shareOfMemory = 0.6; // The rest is for what is shown, and what was.

export class Ahead {
  private client: SurfaceClient | null = null;
  private soon: readonly WantedSoon[] = []; // The soonest first.
  private settings: Settings | null = null;
  private view: View | null = null;
  private underWay = ""; // The dataset's name.
  private readonly failed = new Set<string>(); // Names, until something else is asked of them.

  constructor(private readonly parts: SurfaceClientParts) {}

  // What was under way goes on only if it still is among them. None: the connection ends.
  prepare(soon: readonly WantedSoon[], settings: Settings, view: View): void {
    this.soon = soon;
    this.settings = settings;
    this.view = view;
    if (soon.length === 0) return this.close();
    if (this.underWay && !soon.some(({ info }) => info.name === this.underWay)) {
      this.client!.stop();
      this.underWay = "";
    }
    this.goOn();
  }

  has(info: DatasetInfo, settings: Settings, view: View | null, scalars?: ScalarWish): boolean {
    const order: Wanted = { info, request: isosurfaceRequest(info, settings, view), scalars };
    return this.failed.has(info.name) || this.parts.frames.find(order) !== null;
  }

  close(): void {
    this.client?.close();
    this.client = null;
    this.parts.surface.release(this);
    this.underWay = "";
    this.failed.clear();
  }

  // The next that is missing, unless those before it fill the memory. What is kept of them stays longer
  // than what nobody waits for.
  private goOn(): void {
    if (this.underWay || !this.settings) return;
    const { surface, frames } = this.parts;
    let triangles = 0;
    surface.release(this);
    for (const one of this.soon) {
      if (this.failed.has(one.info.name)) continue;
      const frame = frames.find({ ...one, request: isosurfaceRequest(one.info, this.settings, this.view) });
      if (!frame) return this.bring(one);
      surface.use(frame.ids, this);
      triangles += surface.trianglesOf(frame.ids);
      if (triangles > shareOfMemory * surface.budget) return;
    }
  }

  private bring(one: WantedSoon): void {
    this.underWay = one.info.name;
    this.client ??= new SurfaceClient({ ...this.parts, isAhead: true }, {
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
    this.underWay = "";
    const one = this.soon.find(({ info }) => info.name === underWay);
    if (one && !this.has(one.info, this.settings!, this.view, one.scalars)) this.failed.add(underWay);
    this.goOn();
  }
}
