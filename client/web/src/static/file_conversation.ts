// The other end of a conversation where there is no server: answers the messages of one link from files. Surfaces are of
// full resolution, after a preview; what needs the server's engine is refused with the reason.
import { emptyDigest, fromHex, sum } from "../mesh/content_digest";
import {
  type ClientKind,
  create,
  type DatasetInfo,
  DatasetListSchema,
  ErrorCode,
  ErrorReplySchema,
  EstimateReplySchema,
  type IsosurfaceRequest,
  IsosurfaceRequestSchema,
  type OpenStream,
  PayloadCodec,
  PongSchema,
  ProbeReplySchema,
  type ServerKind,
  ShellStepSchema,
  ShellValues,
  SliceReplySchema,
  StepBeginSchema,
  StepEndSchema,
  StepPolicy,
  StreamEndSchema,
  StreamOutcome,
  ThresholdMapSchema,
  TileSchema,
  WelcomeSchema,
} from "../protocol/messages";
import { sampleBytes } from "../stream/sample_array";
import { CrossedCells } from "./crossed_cells";
import { probedPlaces, sampledSlice } from "./field_samples";
import { coarseSpacing } from "./level_extents";
import type { PageDatasets } from "./page_datasets";
import type { PreparedVolume } from "./prepared_file";
import { brickSide } from "./sample_bricks";
import { type MadeTile, SurfaceLevel, type Tools, uniformCubes } from "./surface_level";
import { cubesByView } from "./view_levels";

const maxSurfaceBricks = 40_000; // They have about as many triangles as a page can show.
const megabyte = 1e6;
const defaultLattice = 5;

// A surface that a page cannot show as a whole.
class TooLarge extends Error {}

export class FileConversation {
  private running = 0n; // The request id of the stream.

  constructor(
    private readonly datasets: PageDatasets,
    private readonly tools: Promise<Tools>,
    private readonly send: (message: ServerKind) => void,
    private readonly progress: (share: number) => void = () => {}, // The part of a step's samples that is read.
  ) {}

  async receive(message: ClientKind): Promise<void> {
    if (message.case === undefined) return;
    const requestId = "requestId" in message.value ? message.value.requestId : 0n;
    try {
      await this.answer(message);
    } catch (error) {
      const isStale = message.case === "openStream" && this.running !== requestId;
      if (isStale) return;
      const code = error instanceof TooLarge ? ErrorCode.LIMIT_EXCEEDED : ErrorCode.INTERNAL;
      const value = create(ErrorReplySchema, { requestId: message.case === "listDatasets" ? 0n : requestId, code, text: (error as Error).message });
      this.send({ case: "error", value });
    }
  }

  // Nothing more is sent.
  close(): void {
    this.running = -1n;
  }

  private async answer(message: ClientKind): Promise<void> {
    switch (message.case) {
      case "hello":
        await this.datasets.list(); // Files that cannot be read end the connection.
        return this.send({ case: "welcome", value: create(WelcomeSchema, { version: 1, codecs: [PayloadCodec.DRACO_LATTICE, PayloadCodec.SAMPLE_SHELL] }) });
      case "listDatasets": {
        const datasets = await this.datasets.list();
        return this.send({ case: "datasetList", value: create(DatasetListSchema, { requestId: message.value.requestId, datasets }) });
      }
      case "ping":
        return this.send({ case: "pong", value: create(PongSchema, { value: message.value.value }) });
      case "cancel":
        if (message.value.requestId === this.running) this.running = 0n;
        return;
      case "openStream":
        return this.stream(message.value);
      case "estimate": {
        const { requestId, dataset, request } = message.value;
        const volume = await this.datasets.volume(dataset);
        const crossed = new CrossedCells(volume, request?.isovalue ?? 0);
        const level = new SurfaceLevel(crossed, request?.lattice || defaultLattice, uniformCubes(crossed, 1));
        const triangles = BigInt(await level.expectedTriangles(await this.tools));
        return this.send({
          case: "estimateReply",
          value: create(EstimateReplySchema, { requestId, triangles, bytes: BigInt(volume.bricks.packedBytes(level.bricks)) }),
        });
      }
      case "slice": {
        const { requestId, dataset, width, height, layers } = message.value;
        const { values, spacing: sampleSpacing } = await sampledSlice(await this.datasets.volume(dataset), message.value);
        const bytes = new Uint8Array(values.buffer);
        return this.send({ case: "sliceReply", value: create(SliceReplySchema, { requestId, width, height, layers, sampleSpacing, values: bytes }) });
      }
      case "probe": {
        const places = await probedPlaces(await this.datasets.volume(message.value.dataset), message.value);
        return this.send({ case: "probeReply", value: create(ProbeReplySchema, { requestId: message.value.requestId, places }) });
      }
      default:
        throw new Error("This needs a server: the page reads files alone.");
    }
  }

  private async stream(open: OpenStream): Promise<void> {
    const { requestId, dataset, steps: policy } = open;
    this.running = requestId;
    const request = open.request ?? create(IsosurfaceRequestSchema);
    const lack = lackOf(open, request);
    if (lack) throw new Error(`${lack} a server: this page reads files alone.`);
    const [volume, tools] = await Promise.all([this.datasets.volume(dataset), this.tools]);
    const isWanted = () => this.running === requestId;
    if (!isWanted()) return;
    const crossed = new CrossedCells(volume, request.isovalue);
    const of = (cubes: ReturnType<typeof uniformCubes>) => new SurfaceLevel(crossed, request.lattice || defaultLattice, cubes);
    const level = (spacing: number) => of(uniformCubes(crossed, spacing));
    const steps = new StepSender(open, request, this.send, tools, isWanted);
    const fine = level(1);
    const largest = Math.min(maxSurfaceBricks, Math.floor(this.datasets.maxSurfaceBytes / brickBytes(volume)));
    const excess = fine.bricks.length > largest;
    const isPreviewed = excess ? open.cachedTileDigests.length === 0 : policy !== StepPolicy.FINAL_ONLY;
    if (isPreviewed && volume.info.gridExponent > Math.log2(coarseSpacing) && !(await steps.sendStep(level(coarseSpacing)))) return;
    const isLast = policy === StepPolicy.PREVIEWS_ONLY && steps.sent > 0;
    if (!isLast) {
      const view = request.threshold?.view;
      if (excess && !view) throw new TooLarge(excessOf(volume, fine, largest, "Every eighth sample is shown"));
      const budget = Number(request.maxTriangles);
      const spacing = budget > 0 ? spacingWithin(budget, await fine.expectedTriangles(tools), volume.info) : 1;
      const best = excess && view ? of(cubesByView(crossed, view, largest)) : spacing > 1 ? level(spacing) : fine;
      await volume.bricks.fetch(best.bricks, (share) => {
        if (isWanted()) this.progress(share);
        return isWanted();
      });
      const isKnown = best.bricks.length === 0 && steps.sent > 0;
      if (!isWanted() || !(isKnown || (await steps.sendStep(best)))) return;
      if (excess) throw new TooLarge(excessOf(volume, fine, largest, "All samples are shown near the eye, and every second to eighth farther away"));
    }
    // A level with fewer triangles does not meet a request: the stream ends before its final step.
    const outcome = steps.hasSentFinal || isLast ? StreamOutcome.COMPLETE : StreamOutcome.CANCELLED;
    this.send({ case: "streamEnd", value: create(StreamEndSchema, { requestId, outcome, steps: steps.sent }) });
  }
}

// Returns what needs a server, as the beginning of a sentence; null: nothing.
function lackOf({ scalars, furtherDatasets }: OpenStream, { normals, maxBytes, cell }: IsosurfaceRequest): string | null {
  if (scalars) return "Coloring by a field needs";
  if (normals > 0) return 'Shading by the field needs ("smooth" and "facets" do not)';
  return furtherDatasets.length > 0 || maxBytes > 0n || cell ? "This request needs" : null;
}

// Returns the finest spacing with about this many triangles at most; 2 to 8, because a final step keeps its budget exactly.
function spacingWithin(budget: number, triangles: number, { gridExponent }: DatasetInfo): number {
  const found = [2, 4].find((spacing) => triangles / spacing ** 2 <= budget) ?? coarseSpacing;
  return Math.min(found, 2 ** (gridExponent - 1));
}

function brickBytes({ info }: PreparedVolume): number {
  return brickSide ** 3 * sampleBytes(info.type);
}

// Says what is shown of a surface that is too large, and why.
function excessOf(volume: PreparedVolume, { bricks }: SurfaceLevel, largest: number, shown: string): string {
  const megabytes = (count: number) => `${Math.round((count * brickBytes(volume)) / megabyte)} MB`;
  return `${shown}: the samples around this surface take ${megabytes(bricks.length)}, and a page holds at most ${megabytes(largest)}. A server shows all.`;
}

// Sends complete steps of one stream.
class StepSender {
  sent = 0;
  hasSentFinal = false;
  private readonly held: Set<string>; // The tiles that the client has.

  constructor(
    private readonly open: OpenStream,
    private readonly request: IsosurfaceRequest,
    private readonly send: (message: ServerKind) => void,
    private readonly tools: Tools,
    private readonly isWanted: () => boolean,
  ) {
    this.held = heldTiles(open.cachedTileDigests);
  }

  // Returns false if the stream was stopped.
  async sendStep(level: SurfaceLevel): Promise<boolean> {
    const began = performance.now();
    const tiles = await level.tiles(this.tools, this.isWanted);
    if (!tiles) return false;
    if (tiles.length === 0 && level.spacing > 1) return true; // Coarse samples may miss what is there.
    this.sendBegin(tiles, level.spacing);
    const { requestId } = this.open;
    let payloadBytes = 0;
    let tilesSent = 0;
    for (const [index, { key, payload }] of tiles.entries()) {
      if (this.held.has(key)) continue;
      this.held.add(key);
      this.send({ case: "tile", value: create(TileSchema, { requestId, step: this.sent, index, payload }) });
      payloadBytes += payload.length;
      ++tilesSent;
    }
    const digest = tiles.reduce((all, { key }) => sum(all, fromHex(key)), emptyDigest);
    const value = create(StepEndSchema, {
      requestId,
      step: this.sent++,
      tilesSent,
      payloadBytes: BigInt(payloadBytes),
      digestHigh: digest.high,
      digestLow: digest.low,
      seconds: (performance.now() - began) / 1000,
    });
    this.send({ case: "stepEnd", value });
    this.hasSentFinal ||= level.spacing === 1;
    return true;
  }

  // A preview states a larger error and tolerance, as those of a server do.
  private sendBegin(tiles: readonly MadeTile[], spacing: number): void {
    const { request } = this;
    const { requestId } = this.open;
    const given = request.threshold ?? create(ThresholdMapSchema);
    const half = spacing > 1 ? spacing / 2 : 0;
    const threshold = create(ThresholdMapSchema, { ...given, atLeast: Math.max(given.atLeast, half) });
    const topologyTolerance = Math.max(request.topologyTolerance, half);
    const value = create(StepBeginSchema, {
      requestId,
      step: this.sent,
      isFinal: spacing === 1,
      request: create(IsosurfaceRequestSchema, { ...request, threshold, topologyTolerance }),
      finestSpacing: spacing,
      codec: PayloadCodec.SAMPLE_SHELL,
      shell: create(ShellStepSchema, { values: ShellValues.EXACT }),
      tiles: tiles.map(({ cube, key, triangles, vertices, bytes }) => {
        const { high, low } = fromHex(key);
        const place = { cubeExponent: cube.exponent, cubeX: cube.x, cubeY: cube.y, cubeZ: cube.z };
        return { ...place, digestHigh: high, digestLow: low, triangles, vertices, bytes };
      }),
    });
    this.send({ case: "stepBegin", value });
  }
}

// The keys that packed() encodes.
function heldTiles(digests: Uint8Array): Set<string> {
  const view = new DataView(digests.buffer, digests.byteOffset, digests.length);
  const half = (at: number) => view.getBigUint64(at, true).toString(16).padStart(16, "0");
  return new Set(Array.from({ length: Math.floor(digests.length / 16) }, (_, i) => half(16 * i) + half(16 * i + 8)));
}
