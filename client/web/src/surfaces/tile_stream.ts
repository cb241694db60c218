// Receives the steps of one surface: performs what its stream requires. Tiles are decoded and uploaded to the GPU while
// invisible; a step with all its tiles is checked. A connection is in use only while the server sends.
//
//   connection -> received() -> stream -> decode() -> worker -> stream -> check() -> worker -> stream -> committed()
import { missingValues } from "../mesh/scalars";
import { type DatasetInfo, ErrorCode, Priority, type ServerKind, type StepBegin } from "../protocol/messages";
import type { Surface } from "../scene/surface";
import { type Failure, noFailure, noProgress, type Progress } from "../state/progress";
import type { Store } from "../state/store";
import type { StepOfTiles } from "../stream/assembler";
import type { ConnectionPool } from "../stream/connection_pool";
import { dataBorder, latticeToWorld } from "../stream/dataset";
import { surfaceKey } from "../stream/request";
import { ResumableStream, type StreamEffect, type TileValues } from "../stream/resumable_stream";
import type { ConnectionUser, ServerConnection } from "../stream/server_connection";
import { type PreviewClient, type SharedPreviews, shareableRequest, sharedRequestId } from "../stream/shared_previews";
import { shellModeOf } from "../stream/step_checks";
import type { StepSpeed } from "../stream/step_speed";
import type { StreamRequest } from "../stream/stream_request";
import type { TilePool } from "../workers/tile_pool";
import type { CheckedStep } from "../workers/worker_messages";
import { factsOf, tileIdPrefix } from "./shown_surface";
import { allComponents, type CachedStep, type VisibleComponents } from "./step_cache";

export interface TileStreamParts {
  number: number; // The index of the surface in the view.
  pool: TilePool;
  surface: Surface;
  speed: StepSpeed; // The decoding speed of this page.
  connections: ConnectionPool;
  sharedPreviews: SharedPreviews; // For the coarse previews of all surfaces but the first.
  isFirst: () => boolean; // Whether it is the first surface of the view.
  isPrefetch?: boolean; // Steps are cached and never shown.
}

export interface TileStreamEvents {
  opened: (isFinishing: boolean) => void; // Anew, or again after a lost connection.
  begun: (begin: StepBegin) => void;
  // Returns the components to show of a step that is being checked.
  select: (ids: readonly string[], lattice: { info: DatasetInfo; resolution: number }) => Promise<VisibleComponents>;
  // `isNew`: it was not committed before the connection was lost. `elapsed`: milliseconds since the request.
  committed: (step: CachedStep, isNew: boolean, elapsed: number) => void;
  postponed: () => void;
  ended: (hasFailed: boolean) => void;
}

export class TileStream implements ConnectionUser, PreviewClient {
  private readonly stream: ResumableStream;
  private connection: ServerConnection | null = null; // While it is ready.
  private requested: StreamRequest | null = null;
  private streamed: StreamRequest | null = null; // The same, or without normals in a shared stream.
  private isFinishing = false; // Receives the rest of a stream after its previews.
  private postponed = 0; // The timer of a postponed request.
  private started = 0;
  private readonly arrived = new Map<number, { triangles: number; lastAt: number }>(); // Tiles, by step of the stream.
  private readonly scalars = new Map<string, NonNullable<Progress["scalars"]>>(); // By tile id.
  private coloring: Promise<void>[] = []; // Pending uploads of scalars of the running stream.
  private checked: { result: CheckedStep; visible: VisibleComponents } | null = null;

  constructor(
    private readonly parts: TileStreamParts,
    private readonly progress: Store<Progress>,
    private readonly events: TileStreamEvents,
  ) {
    const { number, surface, speed, isPrefetch } = parts;
    this.stream = new ResumableStream({
      cachedTiles: (request) => {
        const prefix = tileIdPrefix(number, request);
        return surface.ids(prefix).map((id) => id.slice(prefix.length));
      },
      priority: isPrefetch ? Priority.BACKGROUND : undefined,
      trianglesPerSecond: () => speed.trianglesPerSecond,
      drawableTriangles: () => surface.drawable,
    });
  }

  // Whether the server has sent everything that was requested.
  get isReceived(): boolean {
    return this.stream.isReceived;
  }

  // Replaces the stream; `isFinishing`: by the rest after its previews.
  start(request: StreamRequest, isFinishing: boolean): void {
    this.parts.sharedPreviews.cancel(this);
    this.requested = request;
    this.isFinishing = isFinishing;
    const shared = this.parts.isFirst() ? null : shareableRequest(request);
    if (!shared) return this.requestAlone();
    this.perform(this.stream.cancel());
    this.release();
    this.stream.request(shared);
    this.stream.share(sharedRequestId);
    this.begin(shared);
    this.parts.sharedPreviews.request(this, shared);
  }

  // Discards everything that is pending.
  stop(): void {
    this.parts.sharedPreviews.cancel(this);
    clearTimeout(this.postponed);
    this.perform(this.stream.cancel());
    this.release();
    this.parts.pool.cancelJobs(this);
    this.parts.surface.release(this);
  }

  // Returns the scalars of shown tiles and deletes those of removed ones.
  scalarsOf(ids: readonly string[]): Progress["scalars"] {
    for (const id of this.scalars.keys()) if (!this.parts.surface.hasAll([id])) this.scalars.delete(id);
    const all = ids.map((id) => this.scalars.get(id)).filter((one) => one !== undefined);
    if (all.length === 0) return null;
    const { low, high } = all[0];
    const sum = (of: "vertices" | "missing") => all.reduce((before, one) => before + one[of], 0);
    return { low, high, deviation: Math.max(...all.map(({ deviation }) => deviation)), vertices: sum("vertices"), missing: sum("missing") };
  }

  // ---- of the connection

  ready(connection: ServerConnection): void {
    this.connection = connection;
    if (this.stream.isWaiting) this.open(connection);
  }

  received(message: ServerKind): void {
    this.perform(this.stream.received(message));
    if (this.stream.isReceived) this.release();
  }

  read(share: number): void {
    this.progress.set({ shareRead: share });
  }

  // The stream is repeated when there is a connection again.
  lost(failure: Failure | null): void {
    this.connection = null;
    this.stream.lost();
    clearTimeout(this.postponed);
    this.progress.set({ isStreaming: false, postponed: null, failure });
  }

  requestAlone(): void {
    this.stream.request(this.requested!);
    if (this.connection) this.open(this.connection);
    else this.parts.connections.request(this);
  }

  // ----

  private release(): void {
    this.connection = null;
    this.parts.connections.release(this);
  }

  private open(connection: ServerConnection): void {
    const effects = this.stream.open(connection.nextRequestId());
    this.begin(this.requested!);
    this.perform(effects);
  }

  private begin(request: StreamRequest): void {
    clearTimeout(this.postponed);
    this.parts.pool.cancelJobs(this);
    this.streamed = request;
    this.coloring = [];
    this.arrived.clear();
    if (this.isFinishing) this.progress.set({ isStreaming: true, tilesToCome: 0, tilesReceived: 0, failure: null });
    else {
      this.started = performance.now();
      this.parts.surface.release(this);
      const { shown, components, sizeToConfirm, scalars } = this.progress.get();
      this.progress.set({ ...noProgress, shown, components, sizeToConfirm, scalars, isStreaming: true });
    }
    this.events.opened(this.isFinishing);
  }

  // Effects of a stream that was replaced meanwhile are ignored.
  private perform(effects: StreamEffect[]): void {
    const { number } = this.stream;
    for (const effect of effects) if (number === this.stream.number) this.performOne(effect, this.streamed!);
  }

  private performOne(effect: StreamEffect, request: StreamRequest): void {
    switch (effect.kind) {
      case "send":
        return this.connection?.send(effect.message);
      case "begun":
        return this.beginStep(request, effect);
      case "decode":
        return void this.decode(request, effect);
      case "scalars":
        return this.color(request, effect.values);
      case "check":
        return void this.check(request, effect.step);
      case "committed":
        return this.commit(request, effect);
      case "postponed":
        return this.postpone(effect);
      case "ended":
        this.progress.set({ isStreaming: false });
        this.parts.surface.dropUnused();
        return this.events.ended(false);
      case "refused":
      case "failed": {
        const isLimited = effect.kind === "refused" && effect.code === ErrorCode.LIMIT_EXCEEDED;
        const needsView = isLimited ? surfaceKey(request.info, request.isosurface.isovalue) : undefined;
        this.progress.set({ isStreaming: false, failure: { ...noFailure, text: effect.text, needsView } });
        return this.events.ended(true);
      }
    }
  }

  private postpone({ text, inMilliseconds }: StreamEffect & { kind: "postponed" }): void {
    clearTimeout(this.postponed);
    this.postponed = window.setTimeout(() => this.parts.connections.request(this), inMilliseconds);
    this.release();
    this.progress.set({ isStreaming: false, postponed: { text, until: performance.now() + inMilliseconds } });
    this.events.postponed();
  }

  private beginStep(request: StreamRequest, { tiles, missing, begin }: StreamEffect & { kind: "begun" }): void {
    this.parts.surface.use(this.idsOf(request, tiles), this);
    this.progress.set({ step: begin.step, tilesToCome: missing, tilesReceived: 0, shareRead: 0 });
    this.arrived.set(begin.step, { triangles: 0, lastAt: 0 });
    this.events.begun(begin);
  }

  private async decode(request: StreamRequest, { tile: expected, payload, begin }: StreamEffect & { kind: "decode" }): Promise<void> {
    const { number } = this.stream;
    const { tilesReceived, bytesReceived, firstTile } = this.progress.get();
    this.progress.set({
      tilesReceived: tilesReceived + 1,
      bytesReceived: bytesReceived + payload.length,
      firstTile: firstTile ?? performance.now() - this.started,
    });
    const resolution = begin.request!.lattice; // May be smaller for previews.
    const toWorld = latticeToWorld(request.info, resolution);
    const { triangles } = this.arrived.get(begin.step)!;
    this.arrived.set(begin.step, { triangles: triangles + expected.triangles, lastAt: performance.now() });
    const [id] = this.idsOf(request, [expected]);
    const [shell, hasNormals] = [shellModeOf(begin), request.isosurface.normals > 0];
    try {
      const job = { kind: "decode" as const, id, payload, expected, resolution, shell, hasNormals, linear: toWorld.slice(0, 9) };
      this.parts.surface.add(await this.parts.pool.decode(job, this), toWorld, begin.step);
      this.perform(this.stream.decoded(number, expected.key));
    } catch (error) {
      this.perform(this.stream.damaged(number, (error as Error).message));
    }
  }

  // A step is shown only with the values of all its tiles.
  private color(request: StreamRequest, { key, codes, range, deviation }: TileValues): void {
    const { pool, surface } = this.parts;
    const [id] = this.idsOf(request, [{ key }]);
    const { low, high, bits } = range;
    this.scalars.set(id, { low, high, deviation, vertices: (8 * codes.length) / bits, missing: missingValues(codes, bits) });
    const done = pool.call("scalars", id, codes, bits).then(
      (attribute) => surface.setScalars(id, attribute),
      () => {},
    );
    this.coloring.push(done);
  }

  private async check(request: StreamRequest, step: StepOfTiles): Promise<void> {
    const { number } = this.stream;
    const { begin } = step;
    const ids = this.idsOf(request, step.tiles);
    const { triangles, lastAt } = this.arrived.get(begin.step)!;
    const { lattice: resolution, topologyTolerance } = begin.request!;
    const border = dataBorder(request.info, resolution, topologyTolerance, begin.finestSpacing || 1);
    const [result, visible] = await Promise.all([
      this.parts.pool.call("check", ids, border).catch(() => null),
      this.events.select(ids, { info: request.info, resolution }).catch(() => null),
      this.parts.surface.uploaded(ids),
      ...this.coloring,
    ]);
    // Tiles of a replaced stream may be gone.
    if (number !== this.stream.number || !result || !visible) return;
    this.parts.speed.record(triangles, performance.now() - lastAt);
    this.checked = { result, visible };
    this.perform(this.stream.checked(number, step, result.topology));
  }

  private commit(request: StreamRequest, committed: StreamEffect & { kind: "committed" }): void {
    const { begin, tiles } = committed.step;
    // Even for steps that are not shown: the mesh worker reports each change of normals once.
    for (const { id, normals } of this.checked?.result.normals ?? []) this.parts.surface.setNormals(id, normals);
    const step: CachedStep = {
      ids: this.idsOf(request, tiles),
      shown: { info: request.info, resolution: begin.request!.lattice, request: begin.request!, facts: factsOf(request, committed) },
      visible: this.checked?.visible ?? allComponents,
    };
    this.events.committed(step, committed.isNew, performance.now() - this.started);
  }

  private idsOf(request: StreamRequest, tiles: readonly { key: string }[]): string[] {
    const prefix = tileIdPrefix(this.parts.number, request);
    return tiles.map(({ key }) => prefix + key);
  }
}
