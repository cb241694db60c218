// Queries about datasets: their list, the size of a surface, a slice, or the field at places. They use a connection of their
// own, so that tiles do not delay replies. Queries without a reply are repeated after a lost connection, also if the
// server closed it because the page was too busy to send its first message in time.
import {
  type ClientKind,
  CoordinateSystem,
  create,
  type DatasetInfo,
  type DatasetList,
  type EstimateReply,
  EstimateSchema,
  Interpolation,
  type IsosurfaceRequest,
  ListDatasetsSchema,
  PingSchema,
  type ProbedPlace,
  ProbeSchema,
  type ServerKind,
  SliceDetail,
  SliceSchema,
} from "../protocol/messages";
import { noDatasets, noFailure, type ServedDatasets } from "../state/progress";
import { Store } from "../state/store";
import type { Vec3 } from "./dataset";
import type { PackedSamples } from "./packed_samples";
import { type ConnectionUser, ServerConnection } from "./server_connection";

// Pixels of a plane, in world coordinates.
export interface SliceGrid {
  origin: Vec3; // The center of the first pixel.
  right: Vec3; // From a pixel to the next in its row.
  down: Vec3; // From a row to the next.
  width: number;
  height: number;
}

// Samples in a box of the grid.
export interface SampleBox {
  first: Vec3; // The indices of the first one.
  step: number; // Every step-th sample along each axis.
  counts: Vec3; // Samples along each axis.
}

export interface SliceValues {
  grid: SliceGrid;
  values: Float32Array; // Row by row; NaN where the field has no value.
  sampleSpacing: number; // 1; or 8: from every eighth sample.
}

type ReplyKind = "sliceReply" | "probeReply" | "estimateReply";
type ReplyOf<Kind extends ReplyKind> = Extract<ServerKind, { case: Kind }>["value"];

interface PendingQuery {
  message: ClientKind;
  reply: ReplyKind; // The expected one.
  resolve: (reply: ReplyOf<ReplyKind>) => void;
  reject: (error: Error) => void;
  attempts: number; // How often it was sent.
}

const listInterval = 3000; // Milliseconds between checks for a changed list of datasets.
const maxDatasets = 1 << 20;
const maxAttempts = 5; // A reply that ends the connection each time would end it for ever.
const coarseStep = 8; // The distance of the samples that datasets store as an overview.
const maxConcurrent = 4; // The server's limit per connection.
const otherReply = "The server sent a reply to another query.";

export class DatasetQueries implements ConnectionUser {
  readonly connection: ServerConnection;
  readonly datasets = new Store<ServedDatasets>(noDatasets);
  private readonly running = new Map<bigint, PendingQuery>();
  private waiting: [bigint, PendingQuery][] = [];
  private lastId = 0n;
  private listId = 0n; // The request id of the latest list; pages of others are ignored.
  private listed: DatasetInfo[] = []; // Its pages.
  private isListRefused = false;
  private listTimer = 0;

  constructor(address: string, token: () => string) {
    this.connection = new ServerConnection(address, token, "queries");
  }

  // Connects and follows the list of datasets; connects again if it has done so.
  connect(): void {
    this.listTimer ||= window.setInterval(() => document.hidden || this.checkList(), listInterval);
    if (this.connection.isFree) this.connection.use(this);
    else this.connection.connect();
  }

  // Requests the list of datasets if it has changed or was refused.
  checkList(): void {
    if (!this.connection.isReady) return;
    if (this.isListRefused) this.requestList();
    else if (this.datasets.get().list) this.connection.send({ case: "ping", value: create(PingSchema) });
  }

  // Rejects with a one-sentence error.
  async slice(dataset: string, grid: SliceGrid): Promise<SliceValues> {
    const query = (requestId: bigint) => ({ case: "slice" as const, value: create(SliceSchema, { requestId, dataset, ...grid }) });
    const { width, height, sampleSpacing, values } = await this.query("sliceReply", query);
    if (width !== grid.width || height !== grid.height || values.length !== 4 * width * height) {
      throw new Error(`The server's slice has ${width} by ${height} pixels and ${values.length} bytes.`);
    }
    // Copies, because the bytes may be unaligned in their message. The wire format is little-endian.
    return { grid, values: new Float32Array(values.slice().buffer), sampleSpacing };
  }

  // Returns the values of a box, x fastest; NaN where the field has none.
  async box(dataset: string, { first, step, counts: [width, height, layers] }: SampleBox): Promise<PackedSamples> {
    const wanted = {
      dataset,
      coordinates: CoordinateSystem.INDEX,
      origin: first,
      ...{ right: [step, 0, 0], down: [0, step, 0], inward: [0, 0, step] },
      ...{ width, height, layers },
      interpolation: Interpolation.NEAREST,
      detail: step < coarseStep ? SliceDetail.FULL : SliceDetail.AUTO,
      acceptsPacked: true,
    };
    const query = (requestId: bigint) => ({ case: "slice" as const, value: create(SliceSchema, { requestId, ...wanted }) });
    const { packedType: type, values: bytes } = await this.query("sliceReply", query);
    return { type, bytes };
  }

  async probe(dataset: string, place: Vec3): Promise<ProbedPlace> {
    const query = (requestId: bigint) => ({ case: "probe" as const, value: create(ProbeSchema, { requestId, dataset, places: place }) });
    const { places } = await this.query("probeReply", query);
    if (places.length !== 1) throw new Error(otherReply);
    return places[0];
  }

  // Returns the estimated size of a surface.
  estimate(dataset: string, request: IsosurfaceRequest): Promise<EstimateReply> {
    return this.query("estimateReply", (requestId) => ({ case: "estimate", value: create(EstimateSchema, { requestId, dataset, request }) }));
  }

  close(): void {
    clearInterval(this.listTimer);
    this.connection.use(null);
    this.connection.close();
    this.failAll("Cancelled.");
  }

  // ----

  ready(): void {
    const { permitsSamples } = this.connection.state.get();
    this.datasets.set({ permitsSamples });
    this.requestList();
    this.sendNext();
  }

  received(message: ServerKind): void {
    switch (message.case) {
      case "datasetList":
        return this.receivePage(message.value);
      case "pong":
        return message.value.hasNewList ? this.requestList() : undefined;
      case "sliceReply":
      case "probeReply":
      case "estimateReply":
      case "error": {
        if (message.case === "error" && message.value.requestId === this.listId) return this.refuseList(message.value.text);
        const query = this.running.get(message.value.requestId);
        this.running.delete(message.value.requestId);
        if (message.case === query?.reply) query.resolve(message.value);
        else query?.reject(new Error(message.case === "error" ? message.value.text : otherReply));
        this.sendNext();
      }
    }
  }

  // Queries without a reply are repeated, except if the server refuses the connection.
  lost(): void {
    const { failure } = this.connection.state.get();
    if (failure?.isFatal) return this.failAll(failure.text);
    for (const [id, query] of [...this.running].reverse()) {
      if (query.attempts < maxAttempts) this.waiting.unshift([id, query]);
      else query.reject(new Error("The connection was lost each time the server answered."));
    }
    this.running.clear();
  }

  private requestList(): void {
    this.listed = [];
    this.listId = ++this.lastId;
    this.isListRefused = false;
    this.requestPage("");
  }

  private refuseList(text: string): void {
    this.isListRefused = true;
    this.connection.state.set({ failure: { ...noFailure, text } });
  }

  private requestPage(after: string): void {
    this.connection.send({ case: "listDatasets", value: create(ListDatasetsSchema, { requestId: this.listId, inPages: true, after }) });
  }

  // Each page must continue the list, so that it ends.
  private receivePage({ requestId, datasets, next }: DatasetList): void {
    if (requestId !== this.listId) return;
    this.listed = [...this.listed, ...datasets];
    if (next === "") {
      this.connection.state.set({ failure: null });
      this.datasets.set({ list: this.listed });
    } else if (next === datasets.at(-1)?.name && this.listed.length < maxDatasets) this.requestPage(next);
    else this.refuseList("The server's list of datasets does not end.");
  }

  // Rejects with one sentence.
  private query<Kind extends ReplyKind>(reply: Kind, message: (requestId: bigint) => ClientKind): Promise<ReplyOf<Kind>> {
    const id = ++this.lastId;
    return new Promise((resolve, reject) => {
      this.waiting.push([id, { reply, message: message(id), resolve: resolve as PendingQuery["resolve"], reject, attempts: 0 }]);
      this.sendNext();
    });
  }

  private sendNext(): void {
    while (this.connection.isReady && this.waiting.length > 0 && this.running.size < maxConcurrent) {
      const [id, query] = this.waiting.shift()!;
      this.running.set(id, query);
      query.attempts += 1;
      this.connection.send(query.message);
    }
  }

  private failAll(text: string): void {
    const queries = [...this.running.values(), ...this.waiting.map(([, query]) => query)];
    this.running.clear();
    this.waiting = [];
    for (const { reject } of queries) reject(new Error(text));
  }
}
