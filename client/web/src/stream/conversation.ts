// The client side of a conversation, without its socket: reconnects, lists the datasets, keeps one stream running, and
// repeats it after a lost connection, naming the received tiles. Pure: the page performs the effects and reports back.
//
//   opened() -> Hello -> Welcome -> ListDatasets -> DatasetList -> OpenStream ... -> closed()
import { create } from "@bufbuild/protobuf";
import type { MeshTopology } from "../mesh/boundary_matcher";
import { packed } from "../mesh/content_digest";
import {
  CancelSchema,
  type ClientKind,
  type DatasetInfo,
  type DatasetList as DatasetPage,
  ErrorCode,
  type ErrorReply,
  type EstimateReply,
  EstimateSchema,
  ListDatasetsSchema,
  MeshUse,
  OpenStreamSchema,
  PayloadCodec,
  PingSchema,
  type Preview,
  PreviewSchema,
  Priority,
  type ScalarRange,
  ScalarRequestSchema,
  type ServerKind,
  type StepBegin,
  StepPolicy,
  type TileScalars,
} from "../protocol/messages";
import { Assembler, type AssemblerEffect, type StepOfTiles } from "./assembler";
import { coarsePreview } from "./coarse_preview";
import { helloFrom } from "./hello";
import { manifestTile } from "./step_checks";
import type { StreamRequest } from "./stream_request";

export type Phase = "connecting" | "greeting" | "ready" | "lost";

export type Effect =
  | { kind: "send"; message: ClientKind }
  | { kind: "phase"; phase: Phase; retryInMilliseconds?: number }
  // `permitsSamples`: not only surfaces.
  | { kind: "datasets"; datasets: DatasetInfo[]; permitsSamples: boolean }
  | { kind: "opened"; request: StreamRequest; stream: number }
  // The estimated surface size of a request; the result of requestSize().
  | { kind: "size"; request: StreamRequest; triangles: number; bytes: number; errorWorld: number }
  | { kind: "scalars"; stream: number; request: StreamRequest; values: TileValues }
  // The server postponed the request; retryPostponed() repeats it.
  | { kind: "postponed"; text: string; inMilliseconds: number }
  // An effect of stream `stream`, which identifies late results.
  | { kind: "stream"; stream: number; request: StreamRequest; effect: AssemblerEffect; isNew: boolean }
  | { kind: "failure"; text: string; isFatal: boolean; code: ErrorCode };

// The scalars of a tile, received before the step ends.
export interface TileValues {
  key: string; // The key of the tile.
  codes: Uint8Array;
  range: ScalarRange;
  deviation: number; // The measured difference between the field and the values interpolated from vertices.
}

export interface ConversationOptions {
  part: string; // The part of the viewer: see helloFrom().
  token: () => string;
  // Keys of cached tiles that fit this request, the most useful first.
  cachedTiles: (request: StreamRequest) => string[];
  priority?: Priority; // The priority of all requests; default: normal.
  trianglesPerSecond?: () => number; // The page's measured speed of decoding, checking and showing.
  isListing?: () => boolean; // Whether a new connection lists the datasets; default: yes.
}

const policies = {
  all: StepPolicy.PROGRESSIVE,
  previews: StepPolicy.PREVIEWS_ONLY,
  coarse: StepPolicy.PREVIEWS_ONLY,
  final: StepPolicy.FINAL_ONLY,
};
const maxCachedTiles = 8192;
const maxDatasets = 1 << 20;
export const firstRetry = 500;
export const maxRetry = 15_000;
const maxWait = 600_000; // The longest accepted delay of a server.

export class Conversation {
  private phase: Phase = "connecting";
  private retry = firstRetry;
  private lastRequestId = 0n; // The last id of a stream or query.
  private streamId = 0n; // The request id of the last stream.
  private query: { id: bigint; request: StreamRequest } | null = null; // The running query.
  private nextQuery: StreamRequest | null = null;
  private datasets: DatasetInfo[] | null = null; // Null: not listed yet.
  private listed: DatasetInfo[] = []; // The pages of an unfinished list.
  private permitsSamples = true;
  private requested: StreamRequest | null = null;
  private assembler: Assembler | null = null;
  private streamed: StreamRequest | null = null; // The request of the assembler.
  private stream = 0;
  private hasGivenUp = false;
  private wait = 0; // Milliseconds until the next connection, as required by the server.
  // Steps of `requested` already committed, on this connection or an earlier one.
  private committedSteps = 0;
  // The steps begun so far; after a lost connection exactly these are repeated.
  private begunPreviews: Preview[] = [];
  private hasFinalBegun = false;
  private lastStep: StepBegin | null = null; // The last step of the running stream.

  constructor(private readonly options: ConversationOptions) {}

  // ---- requests of the user

  // Requests another surface, which replaces the previous one. Waits for a connection if there is none.
  request(request: StreamRequest): Effect[] {
    this.requested = request;
    this.committedSteps = 0;
    this.begunPreviews = [];
    this.hasFinalBegun = false;
    if (this.phase === "ready") return this.openStream();
    this.assembler = null; // Replaces the previous stream, whose connection was handed over.
    return [];
  }

  // Requests a surface in a stream shared by several surfaces: its messages for this one are passed to received() with the
  // returned request id. After a lost connection the surface is requested alone.
  share(request: StreamRequest): { effects: Effect[]; requestId: bigint } {
    const cancelled = this.cancel();
    this.requested = request;
    this.committedSteps = 0;
    this.begunPreviews = [];
    this.hasFinalBegun = false;
    const opened = this.begin(request, [], true);
    return { effects: [...cancelled, opened], requestId: this.streamId };
  }

  // Requests the estimated size of a surface. Only one query runs at a time; of those made meanwhile only the last is
  // sent. Does nothing without a connection.
  requestSize(request: StreamRequest): Effect[] {
    if (this.phase !== "ready") return [];
    if (this.query) {
      this.nextQuery = request;
      return [];
    }
    const { info, isosurface } = request;
    const id = ++this.lastRequestId;
    this.query = { id, request };
    const value = create(EstimateSchema, { requestId: id, dataset: info.name, request: isosurface });
    return [{ kind: "send", message: { case: "estimate", value } }];
  }

  // Asks whether the list of datasets has changed; a changed one is requested. Does nothing without a connection.
  checkList(): Effect[] {
    const isListed = this.phase === "ready" && this.datasets !== null;
    return isListed ? [{ kind: "send", message: { case: "ping", value: create(PingSchema) } }] : [];
  }

  // Call when the user requests a connection; resets earlier refusals.
  connecting(): Effect[] {
    this.hasGivenUp = false;
    this.assembler = null;
    return this.setPhase("connecting");
  }

  // Whether the server has sent the whole stream; received tiles may still be decoded and checked.
  get isReceived(): boolean {
    return this.assembler?.isReceived === true;
  }

  // Gives up an idle connection to another conversation and returns the last request id. Received tiles are still
  // checked. Returns null if a stream is being received or there is no connection.
  handOver(): bigint | null {
    if (this.phase !== "ready" || this.assembler?.isReceived === false) return null;
    this.phase = "connecting";
    return this.lastRequestId;
  }

  // Continues on a connection handed over by another conversation.
  adopted(lastRequestId: bigint): Effect[] {
    this.connecting();
    this.retry = firstRetry;
    this.lastRequestId = lastRequestId;
    this.query = this.nextQuery = null;
    const ready = this.setPhase("ready");
    return this.requested ? [...ready, ...this.openStream()] : ready;
  }

  // Repeats a postponed request, unless it was superseded.
  retryPostponed(): Effect[] {
    const isRunning = this.assembler !== null && !this.assembler.hasEnded;
    return this.phase === "ready" && this.requested && !isRunning ? this.openStream() : [];
  }

  cancel(): Effect[] {
    this.requested = null;
    if (!this.assembler || this.assembler.hasEnded || this.phase !== "ready") return [];
    this.assembler = null;
    const value = create(CancelSchema, { requestId: this.streamId });
    return [{ kind: "send", message: { case: "cancel", value } }];
  }

  // ---- events of the connection

  opened(): Effect[] {
    this.lastRequestId = 0n;
    this.query = this.nextQuery = null;
    const value = helloFrom(this.options.part, this.options.token());
    return [...this.setPhase("greeting"), { kind: "send", message: { case: "hello", value } }];
  }

  // The delay before the next attempt doubles; it is part of the phase.
  closed(): Effect[] {
    this.assembler = null;
    const wait = Math.max(this.retry, this.wait);
    this.wait = 0;
    this.retry = Math.min(maxRetry, this.retry * 2);
    this.phase = "lost";
    if (this.hasGivenUp) return [{ kind: "phase", phase: "lost" }];
    return [{ kind: "phase", phase: "lost", retryInMilliseconds: wait }];
  }

  received(message: ServerKind): Effect[] {
    switch (message.case) {
      case "welcome":
        this.retry = firstRetry;
        // The server omits sample shells from the codecs where it permits surfaces only.
        this.permitsSamples = message.value.codecs.includes(PayloadCodec.SAMPLE_SHELL);
        return this.receiveWelcome();
      case "datasetList":
        return this.receivePage(message.value);
      case "pong":
        return message.value.hasNewList ? [this.firstPageRequest()] : [];
      case "estimateReply":
        return this.receiveEstimate(message.value);
      case "error":
        if (message.value.requestId === 0n) return this.receiveConnectionError(message.value);
        // The stream gets the same error and reports it.
        if (message.value.requestId === this.query?.id) return this.sendNextQuery();
    }
    if (!this.assembler) return [];
    if (message.case === "stepBegin") this.recordStep(message.value);
    if (message.case === "tileScalars") return this.receiveScalars(message.value);
    return this.track(this.assembler.receive(message));
  }

  // ---- results of the page

  decoded(stream: number, key: string): Effect[] {
    return this.forStream(stream, (assembler) => assembler.decoded(key));
  }
  damaged(stream: number, text: string): Effect[] {
    return this.forStream(stream, (assembler) => assembler.damaged(text));
  }
  checked(stream: number, step: StepOfTiles, topology: MeshTopology): Effect[] {
    return this.forStream(stream, (assembler) => assembler.checked(step.begin.step, topology));
  }

  // ----

  private receiveWelcome(): Effect[] {
    const ready = this.setPhase("ready");
    const isListing = this.options.isListing?.() ?? true;
    if (!isListing) return this.requested && !this.assembler ? [...ready, ...this.openStream()] : ready;
    return [...ready, this.firstPageRequest()];
  }

  private firstPageRequest(): Effect {
    this.listed = [];
    return this.pageRequest("");
  }

  private pageRequest(after: string): Effect {
    const value = create(ListDatasetsSchema, { requestId: 1n, inPages: true, after });
    return { kind: "send", message: { case: "listDatasets", value } };
  }

  // Each page must continue the list, so that it ends.
  private receivePage({ datasets, next }: DatasetPage): Effect[] {
    this.listed = [...this.listed, ...datasets];
    if (next === "") return this.receiveDatasets(this.listed);
    if (next === datasets.at(-1)?.name && this.listed.length < maxDatasets) return [this.pageRequest(next)];
    const text = "The server's list of datasets does not end.";
    return [{ kind: "failure", text, isFatal: false, code: ErrorCode.DAMAGED_DATA }];
  }

  private receiveEstimate({ requestId, triangles, bytes, errorBoundWorld }: EstimateReply): Effect[] {
    const { query } = this;
    if (requestId !== query?.id) return [];
    const size = { triangles: Number(triangles), bytes: Number(bytes), errorWorld: errorBoundWorld };
    return [{ kind: "size", request: query.request, ...size }, ...this.sendNextQuery()];
  }

  private sendNextQuery(): Effect[] {
    const next = this.nextQuery;
    this.query = this.nextQuery = null;
    return next ? this.requestSize(next) : [];
  }

  private forStream(stream: number, act: (a: Assembler) => AssemblerEffect[]): Effect[] {
    return stream === this.stream && this.assembler ? this.track(act(this.assembler)) : [];
  }

  private setPhase(phase: Phase): Effect[] {
    this.phase = phase;
    return [{ kind: "phase", phase }];
  }

  private receiveDatasets(datasets: DatasetInfo[]): Effect[] {
    this.datasets = datasets;
    const effects: Effect[] = [{ kind: "datasets", datasets, permitsSamples: this.permitsSamples }];
    const { requested } = this;
    // The page opens its first stream when it has the list; an interrupted stream is repeated with the current
    // information about its dataset.
    if (!requested || this.assembler) return effects;
    const info = datasets.find(({ name }) => name === requested.info.name);
    if (!info) {
      this.requested = null;
      const text = `The server no longer has a dataset named "${requested.info.name}".`;
      return [...effects, { kind: "failure", text, isFatal: false, code: ErrorCode.UNKNOWN_DATASET }];
    }
    this.requested = { ...requested, info };
    return [...effects, ...this.openStream()];
  }

  // Values of an earlier stream's tiles may still arrive.
  private receiveScalars({ requestId, step, index, codes, largestDeviation }: TileScalars): Effect[] {
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
    const values = { key: manifestTile(tile).key, codes, range, deviation: largestDeviation };
    return [{ kind: "scalars", stream: this.stream, request: this.streamed!, values }];
  }

  private recordStep(begin: StepBegin): void {
    const { requestId, step, isFinal, finestSpacing, isUnsimplified, shell } = begin;
    if (requestId === this.streamId) this.lastStep = begin;
    if (requestId !== this.streamId || step < this.begunPreviews.length) return;
    // A final step of shells is listed as a preview: it precedes the requested mesh.
    if (isFinal && !shell) this.hasFinalBegun = true;
    else this.begunPreviews.push(create(PreviewSchema, { finestSpacing, isUnsimplified, shell }));
  }

  private openStream(): Effect[] {
    const request = this.requested!;
    const cached = this.options.cachedTiles(request).slice(0, maxCachedTiles);
    const steps = this.hasFinalBegun ? "final" : (request.steps ?? "all");
    const coarse = steps === "coarse" ? coarsePreview(request.info) : null;
    const opened = this.begin(request, cached, policies[steps] === StepPolicy.PREVIEWS_ONLY);
    const value = create(OpenStreamSchema, {
      requestId: this.streamId,
      dataset: request.info.name,
      request: request.isosurface,
      steps: policies[steps],
      cachedTileDigests: packed(cached),
      resumedPreviews: coarse && this.begunPreviews.length === 0 ? [coarse] : this.begunPreviews,
      priority: this.options.priority ?? Priority.UNSPECIFIED,
      scalars: request.scalars && create(ScalarRequestSchema, request.scalars),
      trianglesPerSecond: this.options.trianglesPerSecond?.() ?? 0,
      use: MeshUse.DISPLAY,
    });
    return [opened, { kind: "send", message: { case: "openStream", value } }];
  }

  private begin(request: StreamRequest, cached: string[], isPreviewsOnly: boolean): Effect {
    this.streamed = request;
    this.streamId = ++this.lastRequestId;
    this.lastStep = null;
    ++this.stream;
    this.assembler = new Assembler({ ...request, requestId: this.streamId, isPreviewsOnly }, cached);
    return { kind: "opened", request, stream: this.stream };
  }

  private receiveConnectionError({ code, text, retryAfter }: ErrorReply): Effect[] {
    this.wait = delayOf(retryAfter);
    // The connection ends; only some reasons are temporary.
    const isFatal = !isTemporary(code);
    this.hasGivenUp = isFatal;
    return [{ kind: "failure", text, isFatal, code }];
  }

  private track(effects: AssemblerEffect[]): Effect[] {
    return effects.map((effect): Effect => {
      if (effect.kind === "refused" && delayOf(effect.retryAfter) > 0) {
        return { kind: "postponed", text: effect.text, inMilliseconds: delayOf(effect.retryAfter) };
      }
      let isNew = true;
      if (effect.kind === "committed") {
        // Steps received before the connection was lost are repeated.
        isNew = effect.step.begin.step >= this.committedSteps;
        this.committedSteps = Math.max(this.committedSteps, effect.step.begin.step + 1);
      }
      if (effect.kind === "ended" || effect.kind === "refused" || effect.kind === "failed") {
        this.requested = null;
      }
      return { kind: "stream", stream: this.stream, request: this.streamed!, effect, isNew };
    });
  }
}

// Returns whether another connection may succeed after this one was ended with the code.
export function isTemporary(code: ErrorCode): boolean {
  return code === ErrorCode.UNAVAILABLE || code === ErrorCode.LIMIT_EXCEEDED;
}

// Converts the server's delay in seconds to milliseconds.
function delayOf(seconds: number): number {
  return seconds > 0 ? Math.min(maxWait, Math.max(firstRetry, 1000 * seconds)) : 0;
}
