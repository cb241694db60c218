// Queries for samples: a slice, or the field at places. They use a connection of their own, opened with the first
// query, so that tiles do not delay replies. Queries without a reply are repeated after a lost connection, also if the
// server closed it because the page was too busy to send its first message in time.
import { CoordinateSystem, create, Interpolation, type ProbedPlace, ProbeSchema, type ServerKind, SliceDetail, SliceSchema } from "../protocol/messages";
import { firstRetry, isTemporary, maxRetry } from "./conversation";
import type { Vec3 } from "./dataset";
import { helloFrom } from "./hello";
import { Link } from "./link";
import { unpackedSamples } from "./packed_samples";

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

type Answer = Extract<ServerKind, { case: "sliceReply" | "probeReply" }>;

interface PendingQuery {
  send: () => void;
  resolve: (answer: Answer) => void;
  reject: (error: Error) => void;
  attempts: number; // How often it was sent.
}

const maxAttempts = 5; // A reply that ends the connection each time would end it for ever.
const coarseStep = 8; // The distance of the samples that datasets store as an overview.
const maxConcurrent = 4; // The server's limit per connection.

export class DatasetQueries {
  private readonly link: Link;
  private readonly running = new Map<bigint, PendingQuery>();
  private waiting: { id: bigint; query: PendingQuery }[] = [];
  private lastId = 0n;
  private phase: "none" | "greeting" | "ready" = "none";
  private failures = 0; // Connections lost since the last reply.

  // `retrying` is called when a repeated attempt has failed, too.
  constructor(
    address: string,
    private readonly token: () => string,
    private readonly retrying: (text: string) => void = () => {},
  ) {
    this.link = new Link(address, {
      opened: () => this.sendHello(),
      received: (message) => this.receive(message),
      closed: () => this.reconnect(),
      blocked: () => this.failAll("Cannot connect to the server."),
    });
  }

  // Rejects with a one-sentence error.
  async slice(dataset: string, grid: SliceGrid): Promise<SliceValues> {
    const answer = await this.query((requestId) => {
      const value = create(SliceSchema, { requestId, dataset, ...grid });
      this.link.send({ case: "slice", value });
    });
    if (answer.case !== "sliceReply") throw new Error("The server sent a reply to another query.");
    const { width, height, sampleSpacing, values } = answer.value;
    if (width !== grid.width || height !== grid.height || values.length !== 4 * width * height) {
      throw new Error(`The server's slice has ${width} by ${height} pixels and ${values.length} bytes.`);
    }
    // Copies, because the bytes may be unaligned in their message. The wire format is little-endian.
    return { grid, values: new Float32Array(values.slice().buffer), sampleSpacing };
  }

  // Returns the values of a box, x fastest; NaN where the field has none.
  async box(dataset: string, { first, step, counts: [width, height, layers] }: SampleBox): Promise<Float32Array> {
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
    const answer = await this.query((requestId) => this.link.send({ case: "slice", value: create(SliceSchema, { requestId, ...wanted }) }));
    if (answer.case !== "sliceReply") throw new Error("The server sent a reply to another query.");
    return unpackedSamples(answer.value.packedType, answer.value.values, width * height * layers);
  }

  async probe(dataset: string, place: Vec3): Promise<ProbedPlace> {
    const answer = await this.query((requestId) => {
      const value = create(ProbeSchema, { requestId, dataset, places: place });
      this.link.send({ case: "probe", value });
    });
    if (answer.case !== "probeReply" || answer.value.places.length !== 1) {
      throw new Error("The server sent a reply to another query.");
    }
    return answer.value.places[0];
  }

  close(): void {
    this.link.close();
    this.failAll("Cancelled.");
  }

  private query(send: (id: bigint) => void): Promise<Answer> {
    const id = ++this.lastId;
    return new Promise((resolve, reject) => {
      this.waiting.push({ id, query: { send: () => send(id), resolve, reject, attempts: 0 } });
      if (this.phase === "none") {
        this.phase = "greeting";
        this.link.connect();
      }
      this.sendNext();
    });
  }

  private sendNext(): void {
    while (this.phase === "ready" && this.waiting.length > 0 && this.running.size < maxConcurrent) {
      const { id, query } = this.waiting.shift()!;
      this.running.set(id, query);
      query.attempts += 1;
      query.send();
    }
  }

  private sendHello(): void {
    this.link.send({ case: "hello", value: helloFrom("queries", this.token(), false) });
  }

  private receive(message: ServerKind): void {
    switch (message.case) {
      case "welcome":
        this.phase = "ready";
        break;
      case "sliceReply":
      case "probeReply":
        this.failures = 0;
        this.running.get(message.value.requestId)?.resolve(message);
        this.running.delete(message.value.requestId);
        break;
      case "error": {
        const { requestId, code, text } = message.value;
        if (requestId === 0n) {
          this.link.close();
          return isTemporary(code) ? this.reconnect() : this.failAll(text);
        }
        this.failures = 0;
        this.running.get(requestId)?.reject(new Error(text));
        this.running.delete(requestId);
        break;
      }
    }
    this.sendNext();
  }

  // Repeats the queries without a reply; without any, the next query connects.
  private reconnect(): void {
    for (const [id, query] of [...this.running].reverse()) {
      if (query.attempts < maxAttempts) this.waiting.unshift({ id, query });
      else query.reject(new Error("The connection was lost each time the server answered."));
    }
    this.running.clear();
    this.phase = this.waiting.length > 0 ? "greeting" : "none";
    if (this.phase === "none") return;
    this.link.connectIn(Math.min(maxRetry, firstRetry * 2 ** this.failures));
    if (++this.failures > 1) this.retrying("The server did not answer; trying again.");
  }

  // Rejects all queries; the next one connects.
  private failAll(text: string): void {
    this.phase = "none";
    const queries = [...this.running.values(), ...this.waiting.map((one) => one.query)];
    this.running.clear();
    this.waiting = [];
    for (const { reject } of queries) reject(new Error(text));
  }
}
