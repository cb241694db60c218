// The stream of one surface, without its connection: opens it, passes its messages to the assembler, and repeats it after a
// lost connection, naming the received tiles. Pure: the page performs the effects and reports back.
//
//   request() -> open() -> OpenStream ... -> lost() -> open() -> OpenStream ... -> ended
import type { MeshTopology } from "../mesh/boundary_matcher";
import { packed } from "../mesh/content_digest";
import {
  CancelSchema,
  type ClientKind,
  create,
  MeshUse,
  OpenStreamSchema,
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
import { delayOf } from "./server_connection";
import { manifestTile } from "./step_checks";
import type { StreamRequest } from "./stream_request";

export type StreamEffect =
  | Exclude<AssemblerEffect, { kind: "committed" }>
  // `isNew`: it was not committed before the connection was lost.
  | (AssemblerEffect & { kind: "committed" } & { isNew: boolean })
  | { kind: "send"; message: ClientKind }
  | { kind: "scalars"; values: TileValues }
  // The server postponed the request; open() repeats it.
  | { kind: "postponed"; text: string; inMilliseconds: number };

// The scalars of a tile, received before the step ends.
export interface TileValues {
  key: string; // The key of the tile.
  codes: Uint8Array;
  range: ScalarRange;
  deviation: number; // The measured difference between the field and the values interpolated from vertices.
}

export interface StreamOptions {
  // Keys of cached tiles that fit this request, the most useful first.
  cachedTiles: (request: StreamRequest) => string[];
  priority?: Priority; // The priority of all requests; default: normal.
  trianglesPerSecond?: () => number; // The page's measured speed of decoding, checking and showing.
  drawableTriangles?: () => number; // That the page can hold of the surface; default: the server's limit.
}

const policies = {
  all: StepPolicy.PROGRESSIVE,
  previews: StepPolicy.PREVIEWS_ONLY,
  coarse: StepPolicy.PREVIEWS_ONLY,
  final: StepPolicy.FINAL_ONLY,
};
const maxCachedTiles = 8192;

export class ResumableStream {
  number = 0; // Changes with every stream, also when it is cancelled: identifies late results.
  private wanted: StreamRequest | null = null; // Null: none, or it has ended.
  private assembler: Assembler | null = null;
  private requestId = 0n;
  private committedSteps = 0; // Of `wanted`, on this connection or an earlier one.
  // The steps begun so far; after a lost connection exactly these are repeated.
  private begunPreviews: Preview[] = [];
  private hasFinalBegun = false;
  private lastStep: StepBegin | null = null; // The last step of the running stream.

  constructor(private readonly options: StreamOptions) {}

  // Replaces the request and its stream; open() or share() follows.
  request(request: StreamRequest): void {
    ++this.number;
    this.wanted = request;
    this.assembler = null;
    this.committedSteps = 0;
    this.begunPreviews = [];
    this.hasFinalBegun = false;
  }

  // Whether open() has something to do.
  get isWaiting(): boolean {
    return this.wanted !== null && (this.assembler === null || this.assembler.hasEnded);
  }

  get isRunning(): boolean {
    return this.assembler?.isReceived === false;
  }

  // Whether the server has sent the whole stream; received tiles may still be decoded and checked.
  get isReceived(): boolean {
    return this.assembler?.isReceived === true && !this.isWaiting;
  }

  // Opens the requested stream. Requires one, and a larger id than that of any other request on the connection.
  open(requestId: bigint): StreamEffect[] {
    const request = this.wanted!;
    const cached = this.options.cachedTiles(request).slice(0, maxCachedTiles);
    const steps = this.hasFinalBegun ? "final" : (request.steps ?? "all");
    const coarse = steps === "coarse" ? coarsePreview(request.info) : null;
    this.begin(requestId, cached, policies[steps] === StepPolicy.PREVIEWS_ONLY);
    const value = create(OpenStreamSchema, {
      requestId,
      dataset: request.info.name,
      contentId: request.info.missing === "" ? request.info.contentId : 0n, // Missing errors may be computed now, which changes it.
      request: request.isosurface,
      steps: policies[steps],
      cachedTileDigests: packed(cached),
      resumedPreviews: coarse && this.begunPreviews.length === 0 ? [coarse] : this.begunPreviews,
      priority: this.options.priority ?? Priority.UNSPECIFIED,
      scalars: request.scalars && create(ScalarRequestSchema, request.scalars),
      trianglesPerSecond: this.options.trianglesPerSecond?.() ?? 0,
      use: MeshUse.DISPLAY,
      drawableTriangles: BigInt(Math.floor(this.options.drawableTriangles?.() ?? 0)),
    });
    return [{ kind: "send", message: { case: "openStream", value } }];
  }

  // Receives the requested previews in a stream shared by several surfaces, whose messages have this id.
  share(requestId: bigint): void {
    this.begin(requestId, [], true);
  }

  lost(): void {
    this.assembler = null;
  }

  cancel(): StreamEffect[] {
    const { isRunning } = this;
    ++this.number;
    this.wanted = this.assembler = null;
    return isRunning ? [{ kind: "send", message: { case: "cancel", value: create(CancelSchema, { requestId: this.requestId }) } }] : [];
  }

  received(message: ServerKind): StreamEffect[] {
    if (!this.assembler) return [];
    if (message.case === "stepBegin") this.recordStep(message.value);
    if (message.case === "tileScalars") return this.receiveScalars(message.value);
    return this.track(this.assembler.receive(message));
  }

  // ---- results of the page, for the stream of this number

  decoded(stream: number, key: string): StreamEffect[] {
    return this.forStream(stream, (assembler) => assembler.decoded(key));
  }
  damaged(stream: number, text: string): StreamEffect[] {
    return this.forStream(stream, (assembler) => assembler.damaged(text));
  }
  checked(stream: number, step: StepOfTiles, topology: MeshTopology): StreamEffect[] {
    return this.forStream(stream, (assembler) => assembler.checked(step.begin.step, topology));
  }

  // ----

  private begin(requestId: bigint, cached: string[], isPreviewsOnly: boolean): void {
    this.requestId = requestId;
    this.lastStep = null;
    ++this.number;
    this.assembler = new Assembler({ ...this.wanted!, requestId, isPreviewsOnly }, cached);
  }

  private forStream(stream: number, act: (assembler: Assembler) => AssemblerEffect[]): StreamEffect[] {
    return stream === this.number && this.assembler ? this.track(act(this.assembler)) : [];
  }

  // Values of an earlier stream's tiles may still arrive.
  private receiveScalars({ requestId, step, index, codes, largestDeviation }: TileScalars): StreamEffect[] {
    if (requestId !== this.requestId || this.assembler?.hasEnded !== false) return [];
    const tile = this.lastStep?.tiles[index];
    const range = this.lastStep?.scalars;
    if (this.lastStep?.step !== step || !tile || !range) {
      return this.track(this.assembler.damaged(`Step ${step}: values were sent for tile ${index}, which is not in its manifest.`));
    }
    if (![8, 16].includes(range.bits) || codes.length !== (tile.vertices * range.bits) / 8) {
      const text = `Step ${step}: ${codes.length} bytes of values were sent for the ${tile.vertices} vertices of tile ${index}.`;
      return this.track(this.assembler.damaged(text));
    }
    return [{ kind: "scalars", values: { key: manifestTile(tile).key, codes, range, deviation: largestDeviation } }];
  }

  private recordStep(begin: StepBegin): void {
    const { requestId, step, isFinal, finestSpacing, isUnsimplified, shell } = begin;
    if (requestId === this.requestId) this.lastStep = begin;
    if (requestId !== this.requestId || step < this.begunPreviews.length) return;
    // A final step of shells is listed as a preview: it precedes the requested mesh.
    if (isFinal && !shell) this.hasFinalBegun = true;
    else this.begunPreviews.push(create(PreviewSchema, { finestSpacing, isUnsimplified, shell }));
  }

  private track(effects: AssemblerEffect[]): StreamEffect[] {
    return effects.map((effect): StreamEffect => {
      if (effect.kind === "refused" && delayOf(effect.retryAfter) > 0) {
        return { kind: "postponed", text: effect.text, inMilliseconds: delayOf(effect.retryAfter) };
      }
      if (effect.kind === "committed") {
        const { step } = effect.step.begin;
        const isNew = step >= this.committedSteps;
        this.committedSteps = Math.max(this.committedSteps, step + 1);
        return { ...effect, isNew };
      }
      if (effect.kind === "ended" || effect.kind === "refused" || effect.kind === "failed") this.wanted = null;
      return effect;
    });
  }
}
