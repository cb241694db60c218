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
import { type Effect, Conversation, isSameOrder, type ScalarOptions, type StepsWanted, type StreamRequest } from "./stream/conversation";
import { Link } from "./stream/link";
import { isosurfaceRequest, isSameRequest, type View } from "./stream/request";
import type { ConnectionPool, IdleConnection, PoolClient } from "./stream/connection_pool";
import { type PreviewClient, type SharedPreviews, sharedOrderOf } from "./stream/shared_previews";
import type { Moment } from "./swap_group";
import { ExpectedSizes } from "./expected_sizes";
import type { Frame } from "./frames";
import { type DatasetInfo, ErrorCode, Priority, type ServerKind } from "./protocol/messages";
import { memoryOf, type ShownSurface } from "./shown_surface";
import { type HiddenParts, hiddenPartsOf } from "./state/hidden_parts";
import { noProgress, noErrors, type Progress } from "./state/progress";
import type { Settings } from "./state/settings";
import { Store } from "./state/store";
import { type Asked, SurfaceSteps, type SurfaceStepsEvents, type SurfaceStepsParts } from "./surface_steps";
import type { Drawn } from "./workers/worker_messages";

const maxDragWait = 400; // Milliseconds that a drag waits for a preview.

export interface SurfaceClientParts extends SurfaceStepsParts {
  address: string;
  token: () => string;
  connectionPool: ConnectionPool; // For the connections of all but the lead.
  sharedPreviews: SharedPreviews; // Likewise, for coarse previews.
}

export interface SurfaceClientEvents extends SurfaceStepsEvents {
  settled: () => void; // Nothing is in progress or scheduled.
}

// How a surface is requested.
export interface SurfaceRequest {
  moment: Moment;
  scalars?: ScalarOptions;
  isDragging?: boolean; // More requests follow soon.
  steps?: StepsWanted; // Default: all. After "previews" or "coarse", finish() requests the rest.
}

export class SurfaceClient implements PoolClient, PreviewClient {
  readonly progress = new Store<Progress>(noProgress);
  readonly datasets = new Store<{ list: DatasetInfo[] | null }>({ list: null });
  readonly sizes = new ExpectedSizes();
  private readonly conversation: Conversation;
  private readonly link: Link;
  private readonly steps: SurfaceSteps;
  private asked: Asked | null = null; // The request that is running or shown.
  private current: StreamRequest | null = null; // The same, with a budget if it is too large.
  private next: Asked | null = null; // Waits for the running request.
  private isDragging = false;
  private dragTimer = 0;
  private isLead = false; // Always connected; requests the list of datasets.
  private isLinked = false; // Connected or connecting.
  private isUnderWay = false; // Streaming, or preparing to.
  private isFinishing = false; // Receiving the rest of a stream after its previews.
  private hasFinal = false; // The final step of the stream has begun.
  private postponed = 0; // The timer of a postponed stream.

  constructor(private readonly parts: SurfaceClientParts, private readonly events: SurfaceClientEvents) {
    const { number, address, token, surface, speed, isPrefetch, connectionPool } = parts;
    this.conversation = new Conversation({
      agent: `multitetra-viewer/0.1${isPrefetch ? " ahead" : ""}`,
      token,
      held: (order) => {
        const prefix = memoryOf(number, order);
        return surface.ids(prefix).map((id) => id.slice(prefix.length));
      },
      priority: isPrefetch ? Priority.BACKGROUND : undefined,
      trianglesPerSecond: () => speed.trianglesPerSecond,
      isListing: () => this.isLead,
    });
    this.steps = new SurfaceSteps(parts, this.progress, {
      decoded: (stream, key) => this.perform(this.conversation.decoded(stream, key)),
      damaged: (stream, text) => this.perform(this.conversation.damaged(stream, text)),
      certified: (stream, step, topology) => this.perform(this.conversation.certified(stream, step, topology)),
    }, events);
    this.link = new Link(address, {
      opened: () => this.perform(this.conversation.opened()),
      closed: () => this.perform(this.conversation.closed()),
      received: (message: ServerKind) => {
        this.perform(this.conversation.received(message));
        if (this.conversation.isReceived) connectionPool.deal();
      },
      impossible: () => {
        const text = `This page cannot connect to "${address}", or is not allowed to.`;
        this.progress.set({ phase: "lost", retryAt: 0, failure: { ...noErrors, text, isFatal: true } });
      },
    });
  }

  // Reconnects on request. All but the lead wait until they have a request.
  connect(): void {
    if (this.isLinked) this.granted();
    else if (this.isLead || this.isUnderWay) this.needLink();
  }

  // Makes it the first of the view.
  lead(): void {
    this.isLead = true;
    this.parts.connectionPool.leave(this);
  }

  // Ends permanently.
  close(): void {
    clearTimeout(this.postponed);
    clearTimeout(this.dragTimer);
    this.steps.abandon();
    this.link.leave();
    this.parts.connectionPool.leave(this);
    this.parts.sharedPreviews.leave(this);
  }

  // Requests another surface.
  want(info: DatasetInfo, settings: Settings, view: View | null, wish: SurfaceRequest): void {
    const { moment, scalars, isDragging = false } = wish;
    const request = isosurfaceRequest(info, settings, view);
    const steps = this.parts.isPrefetch ? "final" : (wish.steps ?? "all");
    const order: StreamRequest = { info, request, scalars, steps };
    this.isDragging = isDragging;
    this.hide(hiddenPartsOf(settings));
    this.askSize(order, isDragging);
    if (this.asked && isSameOrder(this.asked.order, order) && !this.progress.get().failure) {
      this.next = null;
      return;
    }
    const frame = this.parts.frames.find(order);
    if (frame) this.take({ order, moment }, frame);
    else if (isDragging && this.dragTimer) this.next = { order, moment };
    else this.open({ order, moment });
  }

  get shown(): ShownSurface | null {
    return this.steps.shown;
  }

  get drawn(): Drawn {
    return this.steps.drawn;
  }

  // Hides components; needs no request.
  hide(parts: HiddenParts): void {
    this.steps.hide(parts);
  }

  // Whether previews have arrived and the final step was not requested.
  get isPreviewed(): boolean {
    return !this.isUnderWay && isPreviews(this.current) && !this.hasFinal;
  }

  // Whether previews are being received.
  get isPreviewing(): boolean {
    return this.isUnderWay && isPreviews(this.current) && !this.progress.get().postponed;
  }

  // Whether it needs its connection: not while received data is decoded and checked.
  get isBusy(): boolean {
    return this.isUnderWay && !this.conversation.isReceived;
  }

  // Whether nothing more is being received, and the shown surface is up to date.
  get isSettled(): boolean {
    return !this.isUnderWay && !this.isPreviewed && this.steps.isChosen;
  }

  // Cancels the current request.
  stop(): void {
    this.next = this.asked = this.current = null;
    this.parts.sharedPreviews.leave(this);
    clearTimeout(this.postponed);
    this.perform(this.conversation.cancel());
    this.steps.abandon();
    this.isUnderWay = false;
  }

  // Requests the final step after the previews.
  finish(): void {
    if (!this.isPreviewed) return;
    this.isFinishing = this.isUnderWay = true;
    this.wantNow({ ...this.current!, steps: "final" });
  }

  // Requests the surface that was held back as too large.
  insist(): void {
    const { heldBack } = this.progress.get();
    if (!heldBack || !this.asked) return;
    this.sizes.allow(heldBack);
    this.open(this.asked);
  }

  // ---- connections

  granted(connection: IdleConnection | null = null): void {
    this.isLinked = true;
    this.perform(this.conversation.connecting());
    this.progress.set({ failure: null, isStreaming: false });
    if (!connection) return this.link.connect();
    this.link.adopt(connection.socket);
    this.perform(this.conversation.adopted(connection.lastRequestId));
  }

  revoked(): IdleConnection | null {
    this.isLinked = false;
    const lastRequestId = this.conversation.handOver();
    const socket = lastRequestId === null ? null : this.link.handOver();
    this.link.leave();
    if (!socket) this.perform(this.conversation.connecting());
    this.progress.set({ phase: "connecting" });
    return socket && { socket, lastRequestId: lastRequestId! };
  }

  private needLink(): void {
    if (this.isLinked) return;
    if (this.isLead || this.parts.isPrefetch) this.granted();
    else this.parts.connectionPool.want(this);
  }

  // ----

  private askSize(order: StreamRequest, isDragging: boolean): void {
    if (!this.isLead && this.sizes.isSmall(order.info)) return; // Only the lead's size is shown.
    if (this.progress.get().phase !== "ready" || !this.sizes.isWanted(order, isDragging)) return;
    this.perform(this.conversation.askSize(order));
  }

  // A stream repeated on another connection must also not send an oversized surface without confirmation.
  private askSizeAgain(): void {
    const { asked } = this;
    if (asked && !this.progress.get().heldBack) this.askSize(asked.order, this.isDragging);
  }

  private learnSize(effect: Effect & { kind: "size" }): void {
    const expected = this.sizes.learn(effect);
    const isCurrent = this.asked && isSameRequest(this.asked.order.request, effect.order.request);
    if (!isCurrent || this.isDragging || this.sizes.isAllowed(expected)) return;
    this.progress.set({ heldBack: expected });
    this.isUnderWay = true;
    this.wantNow(this.sizes.affordable(effect.order));
  }

  private open(asked: Asked): void {
    const { order } = asked;
    this.next = null;
    this.asked = asked;
    this.isUnderWay = true;
    this.isFinishing = false;
    this.progress.set({ heldBack: null });
    this.parts.frames.expect(order);
    this.parts.surface.dropUnused();
    clearTimeout(this.dragTimer);
    this.dragTimer = this.isDragging ? window.setTimeout(() => this.goOn(), maxDragWait) : 0;
    this.wantNow(order);
  }

  private wantNow(order: StreamRequest): void {
    this.current = order;
    this.hasFinal = false;
    const { sharedPreviews } = this.parts;
    sharedPreviews.leave(this);
    const shared = this.isLead ? null : sharedOrderOf(order);
    if (!shared) return this.requestAlone();
    const { effects, requestId } = this.conversation.share(shared);
    this.perform(effects);
    sharedPreviews.want(this, shared, requestId);
  }

  // A message of a stream that several surfaces share.
  receive(message: ServerKind): void {
    this.perform(this.conversation.received(message));
  }

  requestAlone(): void {
    this.perform(this.conversation.want(this.current!));
    this.needLink();
  }

  // The final step is already cached.
  private take(asked: Asked, frame: Frame): void {
    this.stop();
    this.asked = asked;
    this.current = asked.order;
    this.hasFinal = true;
    clearTimeout(this.dragTimer);
    this.dragTimer = 0;
    this.isUnderWay = true;
    this.steps.take(asked, frame, () => {
      this.isUnderWay = false;
      this.parts.connectionPool.deal();
      this.events.settled();
    });
  }

  // The surface that a drag waited for has arrived or is late.
  private goOn(): void {
    clearTimeout(this.dragTimer);
    this.dragTimer = 0;
    if (this.next) this.open(this.next);
  }

  private settle(): void {
    this.isUnderWay = this.isFinishing = false;
    this.goOn();
    if (this.isUnderWay) return;
    this.parts.connectionPool.deal();
    this.events.settled();
  }

  private perform(effects: Effect[]): void {
    for (const effect of effects) this.performOne(effect);
    if (effects.some(({ kind }) => kind === "opened")) this.askSizeAgain();
  }

  private performOne(effect: Effect): void {
    switch (effect.kind) {
      case "send":
        this.link.send(effect.message);
        break;
      case "phase": {
        const wait = effect.retryInMilliseconds;
        if (effect.phase === "lost") this.loseStream();
        if (effect.phase === "lost" && wait !== undefined) this.link.connectIn(wait);
        this.progress.set({
          phase: effect.phase,
          retryAt: wait === undefined ? 0 : performance.now() + wait,
          ...(effect.phase === "ready" ? { failure: null } : {}),
        });
        break;
      }
      case "datasets":
        this.datasets.set({ list: effect.datasets });
        break;
      case "opened":
        clearTimeout(this.postponed);
        this.steps.begin(effect.stream, this.isFinishing);
        break;
      case "size":
        this.learnSize(effect);
        break;
      case "scalars":
        if (this.steps.isOf(effect.stream)) this.steps.color(effect);
        break;
      case "postponed":
        clearTimeout(this.postponed);
        this.postponed = window.setTimeout(() => this.perform(this.conversation.again()), effect.inMilliseconds);
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
        if (this.steps.isOf(effect.stream)) this.performOfStream(effect);
        break;
    }
  }

  // The running stream is lost; the conversation repeats it after reconnecting.
  private loseStream(): void {
    this.sizes.forget();
    clearTimeout(this.postponed);
    this.progress.set({ isStreaming: false, postponed: null });
  }

  private performOfStream({ effect, order, isNews }: Effect & { kind: "stream" }): void {
    const { steps, progress } = this;
    switch (effect.kind) {
      case "begun":
        this.hasFinal ||= effect.begin.isFinal;
        steps.expect(order, effect);
        break;
      case "decode":
        void steps.decode(order, effect);
        break;
      case "certify":
        void steps.certify(order, effect.step);
        break;
      case "committed":
        steps.present(order, this.asked, effect, isNews);
        if (!this.parts.isPrefetch) this.goOn();
        break;
      case "ended":
        progress.set({ isStreaming: false });
        this.parts.surface.dropUnused();
        this.settle();
        break;
      case "refused":
      case "failed":
        progress.set({ isStreaming: false, failure: { ...noErrors, text: effect.text } });
        this.hasFinal = true; // Nothing is left to request.
        if (this.asked) steps.offerNothing(this.asked);
        this.settle();
        break;
    }
  }
}

function isPreviews(order: StreamRequest | null): boolean {
  return order?.steps === "previews" || order?.steps === "coarse";
}
