// Streams one surface: converts settings to requests on its own connection. surface_steps.ts shows the steps.
//
// While the isovalue is dragged, only one request is in flight: the next one follows when the previous surface was
// shown or takes too long. At the end of the drag the last request continues to its final step.
//
// The size of a surface is estimated in parallel with its stream. A surface too large for most machines is replaced by
// the best one of a safe size, and the user may request it anyway.
//
// With several surfaces the previews of all precede the final step of any: clients request previews first, and the rest
// when all previews have arrived. A client with `isPrefetch` fetches final steps that are needed soon, and shows
// nothing.

import { type DatasetInfo, ErrorCode, Priority, type ServerKind } from "../protocol/messages";
import { type HiddenParts, hiddenPartsOf } from "../state/hidden_parts";
import { noDatasets, noFailure, noProgress, type Progress, type ServedDatasets } from "../state/progress";
import { Store } from "../state/store";
import type { OwnSettings } from "../state/surfaces";
import type { ConnectionPool } from "../stream/connection_pool";
import { Conversation, type Effect } from "../stream/conversation";
import { isosurfaceRequest, isSameRequest, type View } from "../stream/request";
import { type PreviewClient, type SharedPreviews, shareableRequest } from "../stream/shared_previews";
import { isSameStream, type RequestedSteps, type ScalarOptions, type StreamRequest } from "../stream/stream_request";
import type { DrawnTiles } from "../workers/worker_messages";
import { ExpectedSizes } from "./expected_sizes";
import { type ShownSurface, tileIdPrefix } from "./shown_surface";
import type { CachedStep } from "./step_cache";
import { SurfaceConnection } from "./surface_connection";
import { type RequestAtTime, SurfaceSteps, type SurfaceStepsEvents, type SurfaceStepsParts } from "./surface_steps";
import type { SceneTime } from "./swap_group";

const listInterval = 3000; // Milliseconds between checks for a changed list of datasets.
const maxDragWait = 400; // Milliseconds that a drag waits for a preview.

export interface SurfaceClientParts extends SurfaceStepsParts {
  address: string;
  token: () => string;
  connectionPool: ConnectionPool; // For the connections of all surfaces but the first.
  sharedPreviews: SharedPreviews; // For the coarse previews of all surfaces but the first.
}

export interface SurfaceClientEvents extends SurfaceStepsEvents {
  settled: () => void; // Nothing is in progress or scheduled.
}

// How a surface is requested.
export interface SurfaceRequest {
  time: SceneTime;
  scalars?: ScalarOptions;
  isDragging?: boolean; // More requests follow soon.
  steps?: RequestedSteps; // Default: all. After "previews" or "coarse", finish() requests the rest.
}

export class SurfaceClient implements PreviewClient {
  readonly progress = new Store<Progress>(noProgress);
  readonly datasets = new Store<ServedDatasets>(noDatasets);
  readonly sizes = new ExpectedSizes();
  private readonly conversation: Conversation;
  private readonly connection: SurfaceConnection;
  private readonly steps: SurfaceSteps;
  private requested: RequestAtTime | null = null; // The request that is running or shown.
  private current: StreamRequest | null = null; // The running request, with a budget if it is too large.
  private next: RequestAtTime | null = null; // Waits for the running request.
  private isDragging = false;
  private dragTimer = 0;
  private isFirst = false; // Always connected; requests the list of datasets.
  private listTimer = 0; // Checks for a changed list.
  private isActive = false; // Streaming, or preparing to.
  private isFinishing = false; // Receiving the rest of a stream after its previews.
  private hasFinal = false; // The final step of the stream has begun.
  private postponed = 0; // The timer of a postponed stream.

  constructor(
    private readonly parts: SurfaceClientParts,
    private readonly events: SurfaceClientEvents,
  ) {
    const { number, address, token, surface, speed, isPrefetch, connectionPool } = parts;
    this.conversation = new Conversation({
      part: isPrefetch ? "prefetch" : "",
      token,
      cachedTiles: (request) => {
        const prefix = tileIdPrefix(number, request);
        return surface.ids(prefix).map((id) => id.slice(prefix.length));
      },
      priority: isPrefetch ? Priority.BACKGROUND : undefined,
      trianglesPerSecond: () => speed.trianglesPerSecond,
      isListing: () => this.isFirst,
    });
    this.steps = new SurfaceSteps(
      parts,
      this.progress,
      {
        decoded: (stream, key) => this.perform(this.conversation.decoded(stream, key)),
        damaged: (stream, text) => this.perform(this.conversation.damaged(stream, text)),
        checked: (stream, step, topology) => this.perform(this.conversation.checked(stream, step, topology)),
      },
      events,
    );
    this.connection = new SurfaceConnection(
      {
        address,
        pool: connectionPool,
        conversation: this.conversation,
        progress: this.progress,
        isActive: () => this.isActive,
        perform: (effects) => this.perform(effects),
      },
      isPrefetch === true,
    );
  }

  // Reconnects on request. All but the first surface wait until they have a request.
  connect(): void {
    this.connection.reconnect();
    if (this.isFirst || this.isActive) this.connection.ensure();
  }

  // Requests the list of datasets if it has changed.
  checkList(): void {
    this.perform(this.conversation.checkList());
  }

  // Makes it the first of the view.
  makeFirst(): void {
    if (!this.isFirst) this.listTimer = window.setInterval(() => document.hidden || this.checkList(), listInterval);
    this.isFirst = true;
    this.connection.makeOwn();
  }

  // Ends permanently.
  close(): void {
    clearInterval(this.listTimer);
    clearTimeout(this.postponed);
    clearTimeout(this.dragTimer);
    this.steps.cancel();
    this.connection.close();
    this.parts.sharedPreviews.cancel(this);
  }

  // Requests another surface.
  request(info: DatasetInfo, settings: OwnSettings, view: View | null, options: SurfaceRequest): void {
    const { time, scalars, isDragging = false } = options;
    const steps = this.parts.isPrefetch ? "final" : (options.steps ?? "all");
    const request: StreamRequest = { info, isosurface: isosurfaceRequest(info, settings, view), scalars, steps };
    this.isDragging = isDragging;
    this.hide(hiddenPartsOf(settings));
    this.requestSize(request, isDragging);
    if (this.requested && isSameStream(this.requested.request, request) && !this.progress.get().failure) {
      this.next = null;
      return;
    }
    const cached = this.parts.stepCache.find(request);
    if (cached) this.showCached({ request, time }, cached);
    else if (isDragging && this.dragTimer) this.next = { request, time };
    else this.open({ request, time });
  }

  get shown(): ShownSurface | null {
    return this.steps.shown;
  }

  // Whether the shown surface is the one requested last.
  get isCurrent(): boolean {
    const latest = (this.next ?? this.requested)?.request;
    const { shown } = this;
    return shown?.info.name === latest?.info.name && shown?.request.isovalue === latest?.isosurface.isovalue;
  }

  get drawn(): DrawnTiles {
    return this.steps.drawn;
  }

  // Hides components; needs no request.
  hide(parts: HiddenParts): void {
    this.steps.hide(parts);
  }

  // Whether previews have arrived and the final step was not requested.
  get isPreviewed(): boolean {
    return !this.isActive && isPreviews(this.current) && !this.hasFinal;
  }

  // Whether previews are being received.
  get isPreviewing(): boolean {
    return this.isActive && isPreviews(this.current) && !this.progress.get().postponed;
  }

  // Whether it is waiting for the server.
  get isBusy(): boolean {
    return this.connection.isBusy;
  }

  // Whether nothing more is being received, and the shown surface is up to date.
  get isSettled(): boolean {
    return !this.isActive && !this.isPreviewed && this.steps.hasCurrentComponents;
  }

  // Cancels the current request.
  stop(): void {
    this.next = this.requested = this.current = null;
    this.parts.sharedPreviews.cancel(this);
    clearTimeout(this.postponed);
    this.perform(this.conversation.cancel());
    this.steps.cancel();
    this.isActive = false;
  }

  // Requests the final step after the previews.
  finish(): void {
    if (!this.isPreviewed) return;
    this.isFinishing = this.isActive = true;
    this.startStream({ ...this.current!, steps: "final" });
  }

  // Requests the surface that the server sent with a budget because of its size.
  confirmSize(): void {
    const { sizeToConfirm } = this.progress.get();
    if (!sizeToConfirm || !this.requested) return;
    this.sizes.confirm(sizeToConfirm);
    this.open(this.requested);
  }

  // ----

  private requestSize(request: StreamRequest, isDragging: boolean): void {
    if (!this.isFirst && this.sizes.isSmall(request.info)) return; // Only the first one's size is shown.
    if (this.progress.get().phase !== "ready" || !this.sizes.isWanted(request, isDragging)) return;
    this.perform(this.conversation.requestSize(request));
  }

  // A stream repeated on another connection must also not send an oversized surface without confirmation.
  private repeatSizeRequest(): void {
    const { requested } = this;
    if (requested && !this.progress.get().sizeToConfirm) this.requestSize(requested.request, this.isDragging);
  }

  private receiveSize(effect: Effect & { kind: "size" }): void {
    const expected = this.sizes.record(effect);
    const isCurrent = this.requested && isSameRequest(this.requested.request.isosurface, effect.request.isosurface);
    if (!isCurrent || this.isDragging || this.sizes.isAllowed(expected)) return;
    this.progress.set({ sizeToConfirm: expected });
    this.isActive = true;
    this.startStream(this.sizes.withBudget(effect.request));
  }

  private open(requested: RequestAtTime): void {
    const { request } = requested;
    this.next = null;
    this.requested = requested;
    this.isActive = true;
    this.isFinishing = false;
    this.progress.set({ sizeToConfirm: null });
    this.parts.stepCache.beginColoring(request);
    this.parts.surface.dropUnused();
    clearTimeout(this.dragTimer);
    this.dragTimer = this.isDragging ? window.setTimeout(() => this.requestNext(), maxDragWait) : 0;
    this.startStream(request);
  }

  private startStream(request: StreamRequest): void {
    this.current = request;
    this.hasFinal = false;
    const { sharedPreviews } = this.parts;
    sharedPreviews.cancel(this);
    const shared = this.isFirst ? null : shareableRequest(request);
    if (!shared) return this.requestAlone();
    const { effects, requestId } = this.conversation.share(shared);
    this.perform(effects);
    sharedPreviews.request(this, shared, requestId);
  }

  // Receives a message of a stream that several surfaces share.
  receive(message: ServerKind): void {
    this.perform(this.conversation.received(message));
  }

  requestAlone(): void {
    this.perform(this.conversation.request(this.current!));
    this.connection.ensure();
  }

  // Shows a final step that is already cached.
  private showCached(requested: RequestAtTime, cached: CachedStep): void {
    this.stop();
    this.requested = requested;
    this.current = requested.request;
    this.hasFinal = true;
    clearTimeout(this.dragTimer);
    this.dragTimer = 0;
    this.isActive = true;
    this.steps.offerCached(requested, cached, () => {
      this.isActive = false;
      this.parts.connectionPool.distribute();
      this.events.settled();
    });
  }

  // Called when the surface that a drag waited for has arrived or is late.
  private requestNext(): void {
    clearTimeout(this.dragTimer);
    this.dragTimer = 0;
    if (this.next) this.open(this.next);
  }

  private settle(): void {
    this.isActive = this.isFinishing = false;
    this.requestNext();
    if (this.isActive) return;
    this.parts.connectionPool.distribute();
    this.events.settled();
  }

  private perform(effects: Effect[]): void {
    for (const effect of effects) this.performOne(effect);
    if (effects.some(({ kind }) => kind === "opened")) this.repeatSizeRequest();
  }

  private performOne(effect: Effect): void {
    switch (effect.kind) {
      case "send":
        this.connection.send(effect.message);
        break;
      case "phase": {
        const wait = effect.retryInMilliseconds;
        if (effect.phase === "lost") this.noteLostConnection();
        if (effect.phase === "lost" && wait !== undefined) this.connection.reconnectIn(wait);
        this.progress.set({
          phase: effect.phase,
          retryAt: wait === undefined ? 0 : performance.now() + wait,
          ...(effect.phase === "ready" ? { failure: null } : {}),
        });
        break;
      }
      case "datasets":
        this.datasets.set({ list: effect.datasets, permitsSamples: effect.permitsSamples });
        break;
      case "opened":
        clearTimeout(this.postponed);
        this.steps.begin(effect.stream, this.isFinishing);
        break;
      case "size":
        this.receiveSize(effect);
        break;
      case "scalars":
        if (this.steps.isCurrent(effect.stream)) this.steps.color(effect);
        break;
      case "postponed":
        clearTimeout(this.postponed);
        this.postponed = window.setTimeout(() => this.perform(this.conversation.retryPostponed()), effect.inMilliseconds);
        this.progress.set({
          isStreaming: false,
          postponed: { text: effect.text, until: performance.now() + effect.inMilliseconds },
        });
        this.events.settled();
        break;
      case "failure":
        this.progress.set({
          failure: {
            text: effect.text,
            isFatal: effect.isFatal,
            needsToken: effect.code === ErrorCode.UNAUTHENTICATED,
          },
        });
        break;
      case "stream":
        if (this.steps.isCurrent(effect.stream)) this.performOfStream(effect);
        break;
    }
  }

  // Called when the running stream is lost; the conversation repeats it after reconnecting.
  private noteLostConnection(): void {
    this.sizes.forget();
    clearTimeout(this.postponed);
    this.progress.set({ isStreaming: false, postponed: null });
  }

  private performOfStream({ effect, request, isNew }: Effect & { kind: "stream" }): void {
    const { steps, progress } = this;
    switch (effect.kind) {
      case "begun":
        this.hasFinal ||= effect.begin.isFinal;
        steps.beginStep(request, effect);
        break;
      case "decode":
        void steps.decode(request, effect);
        break;
      case "check":
        void steps.check(request, effect.step);
        break;
      case "committed":
        steps.offerStep(request, this.requested, effect, isNew);
        if (!this.parts.isPrefetch) this.requestNext();
        break;
      case "ended":
        progress.set({ isStreaming: false });
        this.parts.surface.dropUnused();
        this.settle();
        break;
      case "refused":
      case "failed":
        progress.set({ isStreaming: false, failure: { ...noFailure, text: effect.text } });
        this.hasFinal = true; // Nothing is left to request.
        if (this.requested) steps.offerNothing(this.requested);
        this.settle();
        break;
    }
  }
}

function isPreviews(request: StreamRequest | null): boolean {
  return request?.steps === "previews" || request?.steps === "coarse";
}
