// A whole conversation with a server, without its socket: reconnects, returns the list of datasets, keeps one stream
// running, and repeats it after a lost connection, naming the received tiles. Pure; the page performs the effects and
// reports back.
//
//   opened() -> Hello -> Welcome -> ListDatasets -> DatasetList -> OpenStream ... -> closed()
import { create } from "@bufbuild/protobuf";

import { packed } from "../mesh/content_digest";
import {
  type ClientKind,
  type DatasetInfo,
  ErrorCode,
  type ErrorReply,
  EstimateSchema,
  type EstimateReply,
  HelloSchema,
  type IsosurfaceRequest,
  ListDatasetsSchema,
  MeshUse,
  OpenStreamSchema,
  type Preview,
  PreviewSchema,
  Priority,
  type ScalarRange,
  ScalarRequestSchema,
  type TileScalars,
  CancelSchema,
  PayloadCodec,
  type ServerKind,
  type StepBegin,
  StepPolicy,
} from "../protocol/messages";
import { coarsePreview } from "./coarse_preview";
import { isSameRequest } from "./request";
import { promiseOf } from "./step_checks";
import { Assembler, type AssemblerEffect, type StepOfTiles } from "./assembler";
import type { MeshTopology } from "../mesh/boundary_matcher";

export type Phase = "connecting" | "greeting" | "ready" | "lost";

export type Effect =
  | { kind: "send"; message: ClientKind }
  | { kind: "phase"; phase: Phase; retryInMilliseconds?: number }
  | { kind: "datasets"; datasets: DatasetInfo[] }
  | { kind: "opened"; order: StreamRequest; stream: number }
  // How large the surface of an order would be; answers a query of askSize().
  | { kind: "size"; order: StreamRequest; triangles: number; bytes: number; errorWorld: number }
  | { kind: "scalars"; stream: number; order: StreamRequest; values: TileValues }
  // The server wants the stream asked for later; again() does that.
  | { kind: "postponed"; text: string; inMilliseconds: number }
  // For a stream; `stream` identifies it, as results from elsewhere may come late.
  | { kind: "stream"; stream: number; order: StreamRequest; effect: AssemblerEffect; isNews: boolean }
  | { kind: "failure"; text: string; isFatal: boolean; code: ErrorCode };

// "coarse": one preview of a label, of a spacing chosen here (coarse_preview.ts); else the same as "previews".
export type StepsWanted = "all" | "previews" | "coarse" | "final";

export interface StreamRequest {
  info: DatasetInfo;
  request: IsosurfaceRequest;
  steps?: StepsWanted; // All by default.
  scalars?: ScalarOptions;
}

// A dataset whose values are requested at the vertices, and their range.
export interface ScalarOptions {
  dataset: string;
  low?: number; // Both or none: what the dataset has.
  high?: number;
}

// Whether they are answered by the same surface in the same colors; how it comes does not matter.
export function isSameOrder(a: StreamRequest, b: StreamRequest): boolean {
  const [x, y] = [a.scalars, b.scalars];
  const isSameColoring = x?.dataset === y?.dataset && x?.low === y?.low && x?.high === y?.high;
  return a.info === b.info && isSameColoring && isSameRequest(a.request, b.request);
}

// The scalars of a tile; a step's come before its end.
export interface TileValues {
  key: string; // The key of the tile.
  codes: Uint8Array;
  range: ScalarRange;
  deviation: number; // Found between the field and what is interpolated from vertices.
}

export interface ConversationOptions {
  agent: string;
  token: () => string;
  // Keys of the tiles that are kept and fit this request; the most useful first.
  held: (order: StreamRequest) => string[];
  priority?: Priority; // The priority of all requests; normal by default.
  trianglesPerSecond?: () => number; // The triangles a second that this page decodes, checks and shows; optional.
  isListing?: () => boolean; // Whether a new connection lists the datasets; yes by default.
}

const policies = {
  all: StepPolicy.PROGRESSIVE, previews: StepPolicy.PREVIEWS_ONLY, coarse: StepPolicy.PREVIEWS_ONLY, final: StepPolicy.FINAL_ONLY,
};
const maxHeld = 8192;
const firstRetry = 500;
const longestRetry = 15_000;
const longestWait = 600_000; // The longest delay that a server may require.

export class Conversation {
  private phase: Phase = "connecting";
  private retry = firstRetry;
  private lastRequestId = 0n; // The last request id of streams and queries.
  private streamId = 0n; // The request id of the last stream.
  private query: { id: bigint; order: StreamRequest } | null = null; // Under way.
  private nextQuery: StreamRequest | null = null;
  private datasets: DatasetInfo[] = [];
  private wanted: StreamRequest | null = null;
  private assembler: Assembler | null = null;
  private order: StreamRequest | null = null; // The request of the assembler.
  private stream = 0;
  private isGivenUp = false;
  private wait = 0; // Milliseconds until the next connection, from the server's reply.
  // Steps of `wanted` that were committed already, on this connection or one before.
  private given = 0;
  // What its stream began with: exactly these steps come again after a lost connection.
  private begun: Preview[] = [];
  private hasFinalBegun = false;
  private lastStep: StepBegin | null = null; // The last step of the running stream.

  constructor(private readonly options: ConversationOptions) {}

  // ---- what the user wants

  // Another surface; it replaces the one before. Waits for a connection if there is none.
  want(order: StreamRequest): Effect[] {
    this.wanted = order;
    this.given = 0;
    this.begun = [];
    this.hasFinalBegun = false;
    if (this.phase === "ready") return this.openStream();
    this.assembler = null; // The stream before is replaced, whose connection was handed over.
    return [];
  }

  // How large a surface would be. One query is under way at a time; of those that come meanwhile
  // the last one follows. Without a connection nothing is requested.
  askSize(order: StreamRequest): Effect[] {
    if (this.phase !== "ready") return [];
    if (this.query) {
      this.nextQuery = order;
      return [];
    }
    const { info, request } = order;
    const id = ++this.lastRequestId;
    this.query = { id, order };
    const value = create(EstimateSchema, { requestId: id, dataset: info.name, request });
    return [{ kind: "send", message: { case: "estimate", value } }];
  }

  // The user requests a connection; earlier refusals and connections no longer count.
  connecting(): Effect[] {
    this.isGivenUp = false;
    this.assembler = null;
    return this.turn("connecting");
  }

  // Whether the server has sent all of the stream, which may still be decoded and checked.
  get isReceived(): boolean {
    return this.assembler?.isReceived === true;
  }

  // The last request id, where another conversation may go on with the connection: it is greeted, and nothing more comes
  // of a stream. What came is still checked; this conversation then has no connection. Null: it may not.
  handOver(): bigint | null {
    if (this.phase !== "ready" || this.assembler?.isReceived === false) return null;
    this.phase = "connecting";
    return this.lastRequestId;
  }

  // Goes on with a connection that another conversation has handed over.
  adopted(lastRequestId: bigint): Effect[] {
    this.connecting();
    this.retry = firstRetry;
    this.lastRequestId = lastRequestId;
    this.query = this.nextQuery = null;
    const ready = this.turn("ready");
    return this.wanted ? [...ready, ...this.openStream()] : ready;
  }

  // Repeats what was postponed, unless it was superseded.
  again(): Effect[] {
    const isRunning = this.assembler !== null && !this.assembler.hasEnded;
    return this.phase === "ready" && this.wanted && !isRunning ? this.openStream() : [];
  }

  cancel(): Effect[] {
    this.wanted = null;
    if (!this.assembler || this.assembler.hasEnded || this.phase !== "ready") return [];
    this.assembler = null;
    const value = create(CancelSchema, { requestId: this.streamId });
    return [{ kind: "send", message: { case: "cancel", value } }];
  }

  // ---- what the connection reports

  opened(): Effect[] {
    this.lastRequestId = 0n;
    this.query = this.nextQuery = null;
    const value = create(HelloSchema, {
      minVersion: 1,
      maxVersion: 1,
      codecs: [PayloadCodec.SAMPLE_SHELL, PayloadCodec.DRACO_LATTICE],
      token: this.options.token(),
      agent: this.options.agent,
    });
    return [...this.turn("greeting"), { kind: "send", message: { case: "hello", value } }];
  }

  // The delay before the next attempt grows from time to time; it is part of the phase.
  closed(): Effect[] {
    this.assembler = null;
    const wait = Math.max(this.retry, this.wait);
    this.wait = 0;
    this.retry = Math.min(longestRetry, this.retry * 2);
    this.phase = "lost";
    if (this.isGivenUp) return [{ kind: "phase", phase: "lost" }];
    return [{ kind: "phase", phase: "lost", retryInMilliseconds: wait }];
  }

  received(message: ServerKind): Effect[] {
    switch (message.case) {
      case "welcome":
        this.retry = firstRetry;
        return this.welcomed();
      case "datasetList":
        return this.listed(message.value.datasets);
      case "estimateReply":
        return this.sized(message.value);
      case "error":
        if (message.value.requestId === 0n) return this.refusedAltogether(message.value);
        // The stream is refused for the same reason, and reports it.
        if (message.value.requestId === this.query?.id) return this.askNext();
    }
    if (!this.assembler) return [];
    if (message.case === "stepBegin") this.noteBegun(message.value);
    if (message.case === "tileScalars") return this.valued(message.value);
    return this.track(this.assembler.receive(message));
  }

  // ---- what the page did

  decoded(stream: number, key: string): Effect[] {
    return this.current(stream, (assembler) => assembler.decoded(key));
  }
  damaged(stream: number, text: string): Effect[] {
    return this.current(stream, (assembler) => assembler.damaged(text));
  }
  certified(stream: number, step: StepOfTiles, topology: MeshTopology): Effect[] {
    return this.current(stream, (assembler) => assembler.certified(step.begin.step, topology));
  }

  // ----

  private welcomed(): Effect[] {
    const ready = this.turn("ready");
    const isListing = this.options.isListing?.() ?? true;
    if (!isListing) return this.wanted && !this.assembler ? [...ready, ...this.openStream()] : ready;
    const value = create(ListDatasetsSchema, { requestId: 1n });
    return [...ready, { kind: "send", message: { case: "listDatasets", value } }];
  }

  private sized({ requestId, triangles, bytes, thresholdWorld }: EstimateReply): Effect[] {
    const { query } = this;
    if (requestId !== query?.id) return [];
    const size = { triangles: Number(triangles), bytes: Number(bytes), errorWorld: thresholdWorld };
    return [{ kind: "size", order: query.order, ...size }, ...this.askNext()];
  }

  private askNext(): Effect[] {
    const next = this.nextQuery;
    this.query = this.nextQuery = null;
    return next ? this.askSize(next) : [];
  }

  private current(stream: number, act: (a: Assembler) => AssemblerEffect[]): Effect[] {
    return stream === this.stream && this.assembler ? this.track(act(this.assembler)) : [];
  }

  private turn(phase: Phase): Effect[] {
    this.phase = phase;
    return [{ kind: "phase", phase }];
  }

  private listed(datasets: DatasetInfo[]): Effect[] {
    this.datasets = datasets;
    const effects: Effect[] = [{ kind: "datasets", datasets }];
    const { wanted } = this;
    // The page opens its first stream when it has the list of datasets; an interrupted stream is repeated with the
    // server's current facts of its dataset.
    if (!wanted || this.assembler) return effects;
    const info = this.datasets.find(({ name }) => name === wanted.info.name);
    if (!info) {
      this.wanted = null;
      const text = `The server no longer has a dataset named "${wanted.info.name}".`;
      return [...effects, { kind: "failure", text, isFatal: false, code: ErrorCode.UNKNOWN_DATASET }];
    }
    this.wanted = { ...wanted, info };
    return [...effects, ...this.openStream()];
  }

  // Values of an earlier stream's tiles may still be under way.
  private valued({ requestId, step, index, codes, largestDeviation }: TileScalars): Effect[] {
    if (requestId !== this.streamId || this.assembler?.hasEnded !== false) return [];
    const tile = this.lastStep?.tiles[index];
    const range = this.lastStep?.scalars;
    if (this.lastStep?.step !== step || !tile || !range) {
      return this.track(this.assembler.damaged(`Step ${step}: values were sent for tile ${index}, which is not in its manifest.`));
    }
    if (![8, 16].includes(range.bits) || codes.length !== (tile.vertices * range.bits) / 8) {
      const text = `Step ${step}: ${codes.length} bytes of values were sent for the ${tile.vertices} vertices of tile ${index}.`;
      return this.track(this.assembler.damaged(text));
    }
    const values = { key: promiseOf(tile).key, codes, range, deviation: largestDeviation };
    return [{ kind: "scalars", stream: this.stream, order: this.order!, values }];
  }

  private noteBegun(begin: StepBegin): void {
    const { requestId, step, isFinal, finestSpacing, isUnsimplified, shell } = begin;
    if (requestId === this.streamId) this.lastStep = begin;
    if (requestId !== this.streamId || step < this.begun.length) return;
    // A final step of shells is named like a preview: it comes instead of the request's own mesh.
    if (isFinal && !shell) this.hasFinalBegun = true;
    else this.begun.push(create(PreviewSchema, { finestSpacing, isUnsimplified, shell }));
  }

  private openStream(): Effect[] {
    const order = (this.order = this.wanted!);
    const held = this.options.held(order).slice(0, maxHeld);
    this.streamId = ++this.lastRequestId;
    this.lastStep = null;
    ++this.stream;
    const steps = this.hasFinalBegun ? "final" : (order.steps ?? "all");
    const isPreviewsOnly = policies[steps] === StepPolicy.PREVIEWS_ONLY;
    const coarse = steps === "coarse" ? coarsePreview(order.info) : null;
    this.assembler = new Assembler({ ...order, requestId: this.streamId, isPreviewsOnly }, held);
    const value = create(OpenStreamSchema, {
      requestId: this.streamId,
      dataset: order.info.name,
      request: order.request,
      steps: policies[steps],
      cachedTileDigests: packed(held),
      resumedPreviews: coarse && this.begun.length === 0 ? [coarse] : this.begun,
      priority: this.options.priority ?? Priority.UNSPECIFIED,
      scalars: order.scalars && create(ScalarRequestSchema, order.scalars),
      trianglesPerSecond: this.options.trianglesPerSecond?.() ?? 0,
      use: MeshUse.DISPLAY,
    });
    return [
      { kind: "opened", order, stream: this.stream },
      { kind: "send", message: { case: "openStream", value } },
    ];
  }

  private refusedAltogether({ code, text, retryAfter }: ErrorReply): Effect[] {
    this.wait = waitOf(retryAfter);
    // The connection ends; some reasons will not go away by themselves.
    const isFatal = code !== ErrorCode.UNAVAILABLE && code !== ErrorCode.LIMIT_EXCEEDED;
    this.isGivenUp = isFatal;
    return [{ kind: "failure", text, isFatal, code }];
  }

  private track(effects: AssemblerEffect[]): Effect[] {
    return effects.map((effect): Effect => {
      if (effect.kind === "refused" && waitOf(effect.retryAfter) > 0) {
        return { kind: "postponed", text: effect.text, inMilliseconds: waitOf(effect.retryAfter) };
      }
      let isNews = true;
      if (effect.kind === "committed") {
        // Steps that were given before the connection was lost come again.
        isNews = effect.step.begin.step >= this.given;
        this.given = Math.max(this.given, effect.step.begin.step + 1);
      }
      if (effect.kind === "ended" || effect.kind === "refused" || effect.kind === "failed") {
        this.wanted = null;
      }
      return { kind: "stream", stream: this.stream, order: this.order!, effect, isNews };
    });
  }
}

// A delay in seconds from the wire.
function waitOf(seconds: number): number {
  return seconds > 0 ? Math.min(longestWait, Math.max(firstRetry, 1000 * seconds)) : 0;
}
