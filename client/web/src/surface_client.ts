// Joins the parts: settings become requests, messages become tiles, complete steps become what is
// shown.
//
// While the isovalue is dragged only one request is under way: the next one follows as soon as the
// surface of the one before was shown, or takes too long. When the dragging stops the last request
// simply goes on to its final step.
//
// How large a surface will be is asked beside its stream. One that is too large for most machines
// is not sent unasked: the best one of a size that every machine takes comes in its place, and the
// user is told and may insist.
//
// Where there are several surfaces the previews of all come before the final step of any: a client that
// is one of several asks for previews first, and for the rest when it is told to. A client that
// `isAhead` brings final steps that are wanted soon, and shows nothing.
import { type Effect, Conversation, isSameOrder, type ScalarWish, type Wanted } from "./stream/conversation";
import { type AssemblerEffect, type StepOfTiles } from "./stream/assembler";
import { dataBorder, latticeToWorld } from "./stream/dataset";
import { Link } from "./stream/link";
import { isosurfaceRequest, isSameRequest, type View } from "./stream/request";
import type { SlotHolder, Slots } from "./stream/slots";
import type { Moment } from "./curtain";
import { ExpectedSizes } from "./expected_sizes";
import type { Frame, Frames } from "./frames";
import { type DatasetInfo, ErrorCode, Priority, type ServerKind } from "./protocol/messages";
import type { Surface } from "./scene/surface";
import { type Committed, factsOf, idsOf, isStepBack, memoryOf, type ShownSurface } from "./shown_surface";
import { isOfOneFamily } from "./state/families";
import { noProgress, noTrouble, type Progress } from "./state/progress";
import type { Settings } from "./state/settings";
import { Store } from "./state/store";
import type { TilePool } from "./workers/tile_pool";
import type { Certified } from "./workers/worker_messages";

const patience = 400; // Milliseconds that a drag waits for a preview.

export interface SurfaceClientParts {
  number: number; // Tells the surfaces of a view apart.
  address: string;
  token: () => string;
  pool: TilePool;
  surface: Surface;
  frames: Frames;
  slots: Slots; // For the connections of all but the lead.
  isAhead?: boolean;
}

export interface SurfaceClientEvents {
  // There is a step of this moment; `show` shows it, once, unless something else is offered or it is withdrawn.
  offer: (moment: Moment, show: () => void) => void;
  withdraw: () => void;
  shown: (shown: ShownSurface, isFirstOfScene: boolean) => void;
  settled: () => void; // Nothing is under way, or will not be soon.
}

// What a surface is wanted for.
export interface Wish {
  moment: Moment;
  scalars?: ScalarWish;
  isDragging?: boolean; // More will follow soon.
  isOneOfSeveral?: boolean;
}

export class SurfaceClient implements SlotHolder {
  readonly progress = new Store<Progress>(noProgress);
  readonly datasets = new Store<{ list: DatasetInfo[] | null }>({ list: null });
  readonly sizes = new ExpectedSizes();
  shown: ShownSurface | null = null;
  private readonly conversation: Conversation;
  private readonly link: Link;
  private started = 0;
  private stream = 0;
  private asked: Wanted | null = null; // Under way, or shown;
  private current: Wanted | null = null; // the same, or as much of it as every machine takes.
  private moment: Moment = { scene: "", time: null }; // Of what was asked.
  private next: { order: Wanted; moment: Moment } | null = null; // Waits for the request under way.
  private isDragging = false;
  private dragTimer = 0;
  private isLead = false; // Always has a connection, and asks what is served.
  private isLinked = false; // Has a connection, or makes one.
  private isUnderWay = false; // A stream, or what leads to it.
  private isFinishing = false; // It is the rest of a stream whose previews came.
  private hasFinal = false; // The final step of the stream has begun.
  private postponed = 0; // The timer of a stream that is asked for later.

  constructor(private readonly parts: SurfaceClientParts, private readonly events: SurfaceClientEvents) {
    const { number, address, token, surface, isAhead } = parts;
    this.conversation = new Conversation({
      agent: `multitetra-viewer/0.1${isAhead ? " ahead" : ""}`,
      token,
      held: (order) => {
        const prefix = memoryOf(number, order);
        return surface.ids(prefix).map((id) => id.slice(prefix.length));
      },
      priority: isAhead ? Priority.BACKGROUND : undefined,
      isListing: () => this.isLead,
    });
    this.link = new Link(address, {
      opened: () => this.perform(this.conversation.opened()),
      closed: () => this.perform(this.conversation.closed()),
      received: (message: ServerKind) => this.perform(this.conversation.received(message)),
      impossible: () => {
        const text = `This page cannot connect to "${address}", or may not.`;
        this.progress.set({ phase: "lost", retryAt: 0, trouble: { ...noTrouble, text, isFatal: true } });
      },
    });
  }

  // Anew, as somebody says. All but the lead wait until they have something to ask.
  connect(): void {
    if (this.isLinked) this.granted();
    else if (this.isLead || this.isUnderWay) this.needLink();
  }

  // The first of a view.
  lead(): void {
    this.isLead = true;
    this.parts.slots.leave(this);
  }

  // For good: nothing is asked or shown any more.
  close(): void {
    clearTimeout(this.postponed);
    ++this.stream; // What is under way elsewhere belongs to nobody.
    clearTimeout(this.dragTimer);
    this.parts.pool.forget(this);
    this.parts.surface.release(this);
    this.link.leave();
    this.parts.slots.leave(this);
  }

  // Another surface.
  want(info: DatasetInfo, settings: Settings, view: View | null, wish: Wish): void {
    const { moment, scalars, isDragging = false, isOneOfSeveral } = wish;
    const request = isosurfaceRequest(info, settings, view);
    const steps = this.parts.isAhead ? "final" : isOneOfSeveral && !isDragging ? "previews" : "all";
    const order: Wanted = { info, request, scalars, steps };
    this.isDragging = isDragging;
    this.askSize(order, isDragging);
    if (this.asked && isSameOrder(this.asked, order) && !this.progress.get().trouble) {
      this.next = null;
      return;
    }
    const frame = this.parts.frames.find(order);
    if (frame) this.take(order, moment, frame);
    else if (isDragging && this.dragTimer) this.next = { order, moment };
    else this.open(order, moment);
  }

  // Whether previews have come, and the final step was not asked for.
  get isPreviewed(): boolean {
    return !this.isUnderWay && this.current?.steps === "previews" && !this.hasFinal;
  }

  // Whether previews are coming.
  get isPreviewing(): boolean {
    return this.isUnderWay && this.current?.steps === "previews" && !this.progress.get().postponed;
  }

  get isBusy(): boolean {
    return this.isUnderWay;
  }

  // What was asked for ends here, and nothing follows.
  stop(): void {
    this.next = this.asked = this.current = null;
    clearTimeout(this.postponed);
    this.parts.pool.forget(this);
    this.perform(this.conversation.cancel());
    this.parts.surface.release(this);
    this.isUnderWay = false;
  }

  // The final step of what was previewed.
  finish(): void {
    if (!this.isPreviewed) return;
    this.isFinishing = this.isUnderWay = true;
    this.wantNow({ ...this.current!, steps: "final" });
  }

  // The user wants the surface whose size was too large.
  insist(): void {
    const { heldBack } = this.progress.get();
    if (!heldBack || !this.asked) return;
    this.sizes.allow(heldBack);
    this.open(this.asked, this.moment);
  }

  // ---- connections

  granted(): void {
    this.isLinked = true;
    this.perform(this.conversation.connecting());
    this.progress.set({ trouble: null, isStreaming: false });
    this.link.connect();
  }

  revoked(): void {
    this.isLinked = false;
    this.link.leave();
    this.perform(this.conversation.connecting());
  }

  private needLink(): void {
    if (this.isLinked) return;
    if (this.isLead || this.parts.isAhead) this.granted();
    else this.parts.slots.want(this);
  }

  // ----

  private askSize(order: Wanted, isDragging: boolean): void {
    if (this.progress.get().phase !== "ready" || !this.sizes.isWanted(order, isDragging)) return;
    this.perform(this.conversation.askSize(order));
  }

  // A stream that is repeated on another connection must not bring unasked what is too large.
  private askSizeAgain(): void {
    const { asked } = this;
    if (asked && !this.progress.get().heldBack) this.askSize(asked, this.isDragging);
  }

  private learnSize(effect: Effect & { kind: "size" }): void {
    const expected = this.sizes.learn(effect);
    const isCurrent = this.asked && isSameRequest(this.asked.request, effect.order.request);
    if (!isCurrent || this.isDragging || this.sizes.isAllowed(expected)) return;
    this.progress.set({ heldBack: expected });
    this.isUnderWay = true;
    this.wantNow(this.sizes.affordable(effect.order));
  }

  private open(order: Wanted, moment: Moment): void {
    this.next = null;
    this.asked = order;
    this.moment = moment;
    this.isUnderWay = true;
    this.isFinishing = false;
    this.progress.set({ heldBack: null });
    this.parts.frames.expect(order);
    this.parts.surface.dropUnused();
    clearTimeout(this.dragTimer);
    this.dragTimer = this.isDragging ? window.setTimeout(() => this.goOn(), patience) : 0;
    this.wantNow(order);
  }

  private wantNow(order: Wanted): void {
    this.current = order;
    this.hasFinal = false;
    this.perform(this.conversation.want(order));
    this.needLink();
  }

  // The final step is here already.
  private take(order: Wanted, moment: Moment, frame: Frame): void {
    const { pool, surface, slots } = this.parts;
    this.stop();
    this.asked = this.current = order;
    this.moment = moment;
    this.hasFinal = true;
    clearTimeout(this.dragTimer);
    this.dragTimer = 0;
    ++this.stream; // Of the one before, nothing that comes late is shown.
    pool.forget(this);
    surface.use(frame.ids, this);
    const { phase, shown } = this.progress.get();
    this.progress.set({ ...noProgress, phase, shown });
    this.events.offer(moment, () => this.show(frame, null));
    slots.deal();
    this.events.settled();
  }

  // The surface that a drag waited for is there, or late.
  private goOn(): void {
    clearTimeout(this.dragTimer);
    this.dragTimer = 0;
    if (this.next) this.open(this.next.order, this.next.moment);
  }

  private settle(): void {
    this.isUnderWay = this.isFinishing = false;
    this.goOn();
    if (this.isUnderWay) return;
    this.parts.slots.deal();
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
          ...(effect.phase === "ready" ? { trouble: null } : {}),
        });
        break;
      }
      case "datasets":
        this.datasets.set({ list: effect.datasets });
        break;
      case "opened":
        this.begin(effect.stream);
        break;
      case "size":
        this.learnSize(effect);
        break;
      case "scalars":
        if (effect.stream === this.stream) this.colour(effect);
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
      case "trouble":
        this.progress.set({
          trouble: {
            text: effect.text,
            isFatal: effect.isFatal,
            needsToken: effect.code === ErrorCode.UNAUTHENTICATED,
          },
        });
        break;
      case "stream":
        if (effect.stream === this.stream) this.performOfStream(effect);
        break;
    }
  }

  // What was under way is gone; the conversation repeats it when there is a connection again.
  private loseStream(): void {
    this.sizes.forget();
    clearTimeout(this.postponed);
    this.progress.set({ isStreaming: false, postponed: null });
  }

  private begin(stream: number): void {
    clearTimeout(this.postponed);
    this.parts.pool.forget(this);
    this.stream = stream;
    this.colouring = [];
    if (this.isFinishing) return this.progress.set({ isStreaming: true, tilesToCome: 0, tilesReceived: 0 });
    this.started = performance.now();
    this.events.withdraw();
    this.parts.surface.release(this);
    const { phase, shown, heldBack } = this.progress.get();
    this.progress.set({ ...noProgress, phase, shown, heldBack, isStreaming: true });
  }

  private performOfStream({ effect, order, isNews }: Effect & { kind: "stream" }): void {
    const { progress } = this;
    switch (effect.kind) {
      case "begun": {
        const ids = effect.tiles.map(({ key }) => memoryOf(this.parts.number, order) + key);
        this.parts.surface.use(ids, this);
        this.hasFinal ||= effect.begin.isFinal;
        progress.set({
          step: effect.begin.step,
          tilesToCome: effect.missing,
          tilesReceived: 0,
        });
        break;
      }
      case "decode":
        progress.set({
          tilesReceived: progress.get().tilesReceived + 1,
          bytesReceived: progress.get().bytesReceived + effect.payload.length,
          firstTile: progress.get().firstTile ?? performance.now() - this.started,
        });
        void this.decode(order, effect);
        break;
      case "certify":
        void this.certify(order, effect.step);
        break;
      case "committed":
        this.present(order, effect, isNews);
        break;
      case "ended":
        progress.set({ isStreaming: false });
        this.parts.surface.dropUnused();
        this.settle();
        break;
      case "refused":
      case "failed":
        progress.set({ isStreaming: false, trouble: { ...noTrouble, text: effect.text } });
        this.hasFinal = true; // Nothing is left to ask for.
        this.offerNothing();
        this.settle();
        break;
    }
  }

  // A step is shown when the values of its tiles are there, too.
  private colour({ order, values: { key, codes, range, deviation } }: Effect & { kind: "scalars" }): void {
    const { scalars } = this.progress.get();
    const largest = Math.max(deviation, scalars?.deviation ?? 0);
    this.progress.set({ scalars: { low: range.low, high: range.high, deviation: largest } });
    const { pool, surface } = this.parts;
    const id = memoryOf(this.parts.number, order) + key;
    const done = pool.scalars(id, codes, range.bits).then((attribute) => surface.setScalars(id, attribute), () => {});
    this.colouring.push(done);
  }

  private async decode(
    order: Wanted,
    { tile: promised, payload, begin }: AssemblerEffect & { kind: "decode" },
  ): Promise<void> {
    const { stream } = this;
    const resolution = begin.request!.latticeResolution; // A preview's may be less.
    const toWorld = latticeToWorld(order.info, resolution);
    try {
      const tile = await this.parts.pool.decode({
        kind: "decode",
        id: memoryOf(this.parts.number, order) + promised.key,
        payload,
        promised,
        resolution,
        hasNormals: order.request.normalBits > 0,
        linear: toWorld.slice(0, 9),
      }, this);
      this.parts.surface.add(tile, toWorld, begin.step);
      this.perform(this.conversation.decoded(stream, promised.key));
    } catch (error) {
      this.perform(this.conversation.damaged(stream, (error as Error).message));
    }
  }

  private colouring: Promise<void>[] = []; // Of the stream that runs.
  private certified: { step: StepOfTiles; result: Certified } | null = null;

  private async certify(order: Wanted, step: StepOfTiles): Promise<void> {
    const { stream } = this;
    const { begin } = step;
    const ids = idsOf(this.parts.number, order, step);
    const { latticeResolution: resolution, topologyTolerance } = begin.request!;
    const border = dataBorder(order.info, resolution, topologyTolerance, begin.finestSpacing || 1);
    const [result] = await Promise.all([
      this.parts.pool.certify(ids, border).catch(() => null),
      this.parts.surface.uploaded(ids),
      ...this.colouring,
    ]);
    // Of a stream that was replaced, tiles may be gone.
    if (stream !== this.stream || !result) return;
    this.certified = { step, result };
    this.perform(this.conversation.certified(stream, step, result.topology));
  }

  private present(order: Wanted, committed: Committed, isNews: boolean): void {
    const { number, surface, frames, isAhead } = this.parts;
    const { begin } = committed.step;
    const facts = factsOf(order, committed);
    // Also of a step that is passed over: the keeper tells a change of normals once.
    for (const { id, normals } of this.certified?.result.normals ?? []) surface.setNormals(id, normals);
    const frame: Frame = {
      ids: idsOf(number, order, committed.step),
      shown: { info: order.info, resolution: begin.request!.latticeResolution, request: begin.request!, facts },
    };
    if (facts.isFinal && this.asked) frames.keep({ ...this.asked, info: order.info }, frame);
    if (isAhead) return;
    if (isNews && !isStepBack(this.shown, order, facts)) {
      const elapsed = performance.now() - this.started;
      this.events.offer(this.moment, () => this.show(frame, elapsed));
    }
    this.goOn();
  }

  // `elapsed`: milliseconds after the request; null: nothing was asked.
  private show({ ids, shown }: Frame, elapsed: number | null): void {
    const before = this.shown;
    this.parts.surface.show(ids);
    this.shown = shown;
    const { firstSurface } = this.progress.get();
    this.progress.set({
      shown: shown.facts,
      firstSurface: firstSurface ?? elapsed,
      complete: shown.facts.isFinal ? elapsed : null,
    });
    this.events.shown(shown, !before || !isOfOneFamily(before.info, shown.info));
  }

  // Of the time that is wanted there is no surface; others do not have to wait for it, and that of another
  // time does not stay beside them.
  private offerNothing(): void {
    const { asked, shown } = this;
    if (!asked || !shown || !isOfOneFamily(shown.info, asked.info)) return;
    this.events.offer(this.moment, () => shown.info !== asked.info && this.parts.surface.show([]));
  }
}
