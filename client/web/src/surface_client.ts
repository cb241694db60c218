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
import { type Effect, Conversation, type Wanted } from "./stream/conversation";
import { type AssemblerEffect, type StepOfTiles } from "./stream/assembler";
import { dataBorder, latticeToWorld } from "./stream/dataset";
import { Link } from "./stream/link";
import { isosurfaceRequest, isSameRequest, type View } from "./stream/request";
import { affordable, ExpectedSizes } from "./expected_sizes";
import { type DatasetInfo, ErrorCode, type ServerKind } from "./protocol/messages";
import type { Surface } from "./scene/surface";
import {
  type Committed,
  factsOf,
  idsOf,
  isStepBack,
  memoriesOf,
  memoryOf,
  type ShownSurface,
} from "./shown_surface";
import { noProgress, noTrouble, type Progress } from "./state/progress";
import type { Settings } from "./state/settings";
import { Store } from "./state/store";
import type { TilePool } from "./workers/tile_pool";
import type { Certified } from "./workers/worker_messages";

const patience = 400; // Milliseconds that a drag waits for a preview.

export class SurfaceClient {
  readonly progress = new Store<Progress>(noProgress);
  readonly datasets = new Store<{ list: DatasetInfo[] | null }>({ list: null });
  readonly sizes = new ExpectedSizes();
  shown: ShownSurface | null = null;
  private readonly conversation: Conversation;
  private readonly link: Link;
  private started = 0;
  private stream = 0;
  private asked: Wanted | null = null; // Under way, or shown.
  private next: Wanted | null = null; // Waits for the request under way.
  private isDragging = false;
  private dragTimer = 0;
  private readonly inUse = new Set<string>();
  private isClosed = false;
  private postponed = 0; // The timer of a stream that is asked for later.

  // `number` tells the surfaces of a view apart; each has a client of its own.
  constructor(
    readonly number: number,
    private readonly address: string,
    token: () => string,
    private readonly pool: TilePool,
    private readonly surface: Surface,
    private readonly onShown: (shown: ShownSurface, isFirstOfDataset: boolean) => void,
  ) {
    this.conversation = new Conversation({
      agent: "multitetra-viewer/0.1",
      token,
      held: (order) => {
        const prefix = memoryOf(number, order);
        return this.surface.ids(prefix).map((id) => id.slice(prefix.length));
      },
    });
    this.link = new Link(address, {
      opened: () => this.perform(this.conversation.opened()),
      closed: () => this.perform(this.conversation.closed()),
      received: (message: ServerKind) => this.perform(this.conversation.received(message)),
      impossible: () => {
        const text = `This page cannot connect to "${this.address}", or may not.`;
        this.progress.set({ phase: "lost", retryAt: 0, trouble: { ...noTrouble, text, isFatal: true } });
      },
    });
  }

  connect(): void {
    this.perform(this.conversation.connecting());
    this.progress.set({ trouble: null, isStreaming: false });
    this.link.connect();
  }

  // For good: nothing is asked or shown any more.
  close(): void {
    this.isClosed = true;
    clearTimeout(this.postponed);
    ++this.stream; // What is under way elsewhere belongs to nobody.
    clearTimeout(this.dragTimer);
    this.pool.forget(memoriesOf(this.number));
    this.link.leave();
  }

  // Another surface. With `isDragging` more will follow soon.
  want(info: DatasetInfo, settings: Settings, view: View | null, isDragging = false): void {
    const scalars = settings.colourBy || undefined;
    const order: Wanted = { info, request: isosurfaceRequest(info, settings, view), scalars };
    this.isDragging = isDragging;
    this.askSize(order, isDragging);
    const isAsked =
      this.asked?.info === info && this.asked.scalars === scalars && isSameRequest(this.asked.request, order.request);
    if (isAsked && !this.progress.get().trouble) {
      this.next = null;
      return;
    }
    if (isDragging && this.dragTimer) {
      this.next = order;
      return;
    }
    this.open(order);
  }

  // The user wants the surface whose size was too large.
  insist(): void {
    const { heldBack } = this.progress.get();
    if (!heldBack || !this.asked) return;
    this.sizes.allow(heldBack);
    this.open(this.asked);
  }

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
    this.perform(this.conversation.want(affordable(effect.order)));
  }

  private open(order: Wanted): void {
    this.next = null;
    this.asked = order;
    this.progress.set({ heldBack: null });
    this.surface.dropUnused(new Set());
    clearTimeout(this.dragTimer);
    this.dragTimer = this.isDragging ? window.setTimeout(() => this.goOn(), patience) : 0;
    this.perform(this.conversation.want(order));
  }

  // The surface that a drag waited for is there, or late.
  private goOn(): void {
    clearTimeout(this.dragTimer);
    this.dragTimer = 0;
    if (this.next) this.open(this.next);
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
    this.pool.forget(memoriesOf(this.number));
    this.stream = stream;
    this.started = performance.now();
    this.inUse.clear();
    this.colouring = [];
    const { phase, shown, heldBack } = this.progress.get();
    this.progress.set({ ...noProgress, phase, shown, heldBack, isStreaming: true });
  }

  private performOfStream({ effect, order, isNews }: Effect & { kind: "stream" }): void {
    const { progress } = this;
    switch (effect.kind) {
      case "begun": {
        const ids = effect.tiles.map(({ key }) => memoryOf(this.number, order) + key);
        for (const id of ids) this.inUse.add(id);
        this.surface.use(ids);
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
        this.surface.dropUnused(this.inUse);
        this.goOn();
        break;
      case "refused":
      case "failed":
        progress.set({ isStreaming: false, trouble: { ...noTrouble, text: effect.text } });
        this.goOn();
        break;
    }
  }

  // A step is shown when the values of its tiles are there, too.
  private colour({ order, values: { key, codes, range, deviation } }: Effect & { kind: "scalars" }): void {
    const { scalars } = this.progress.get();
    const largest = Math.max(deviation, scalars?.deviation ?? 0);
    this.progress.set({ scalars: { low: range.low, high: range.high, deviation: largest } });
    const id = memoryOf(this.number, order) + key;
    const done = this.pool.scalars(id, codes, range.bits).then((attribute) => this.surface.setScalars(id, attribute), () => {});
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
      const tile = await this.pool.decode({
        kind: "decode",
        id: memoryOf(this.number, order) + promised.key,
        payload,
        promised,
        resolution,
        hasNormals: order.request.normalBits > 0,
        linear: toWorld.slice(0, 9),
      });
      if (this.isClosed) return this.pool.drop([tile.id]);
      this.surface.add(tile, toWorld, begin.step);
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
    const ids = idsOf(this.number, order, step);
    const { latticeResolution: resolution, topologyTolerance } = begin.request!;
    const border = dataBorder(order.info, resolution, topologyTolerance, begin.finestSpacing || 1);
    const [result] = await Promise.all([
      this.pool.certify(ids, border).catch(() => null),
      this.surface.uploaded(ids),
      ...this.colouring,
    ]);
    // Of a stream that was replaced, tiles may be gone.
    if (stream !== this.stream || !result) return;
    this.certified = { step, result };
    this.perform(this.conversation.certified(stream, step, result.topology));
  }

  private present(order: Wanted, committed: Committed, isNews: boolean): void {
    const { step } = committed;
    const facts = factsOf(order, committed);
    const before = this.shown;
    // Also of a step that is passed over: the keeper tells a change of normals once.
    for (const { id, normals } of this.certified?.result.normals ?? []) {
      this.surface.setNormals(id, normals);
    }
    if (isNews && !isStepBack(before, order, facts)) {
      this.surface.show(idsOf(this.number, order, step));
      this.shown = {
        info: order.info,
        resolution: step.begin.request!.latticeResolution,
        request: step.begin.request!,
        facts,
      };
      const isFirst = before?.info.name !== order.info.name;
      const elapsed = performance.now() - this.started;
      const { firstSurface } = this.progress.get();
      this.progress.set({
        shown: facts,
        firstSurface: firstSurface ?? elapsed,
        complete: facts.isFinal ? elapsed : null,
      });
      this.onShown(this.shown, isFirst);
    }
    this.goOn();
  }
}
