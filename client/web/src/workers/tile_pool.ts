// The page's interface to the workers: several decode tiles, one keeps whole steps.
import type { CutPlane } from "../mesh/cut";
import type { MassProperties } from "../mesh/mass_properties";
import type { DataBorder } from "../mesh/boundary_matcher";
import type {
  CheckedStep,
  DamagedTile,
  DecodedTile,
  DrawnTiles,
  Hit,
  MeshReply,
  MeshRequest,
  MeasuredPart,
  MeshFormat,
  PickRay,
  SavedSurface,
  Selection,
  TileJob,
} from "./worker_messages";

interface Waiting<T> {
  resolve: (value: T) => void;
  reject: (error: Error) => void;
}

export class TilePool {
  private readonly idle: Worker[] = [];
  private readonly queue: { job: TileJob; owner: object; done: Waiting<DecodedTile> }[] = [];
  private readonly jobs = new Map<Worker, Waiting<DecodedTile>>();
  private readonly meshWorker: Worker;
  private readonly queries = new Map<number, Waiting<never>>();
  private lastQuery = 0;

  constructor(workers: number) {
    this.meshWorker = new Worker(new URL("./mesh_worker.ts", import.meta.url), { type: "module" });
    this.meshWorker.onmessage = ({ data }: MessageEvent<MeshReply>) => {
      const waiting = this.queries.get(data.request);
      this.queries.delete(data.request);
      if (data.error) waiting?.reject(new Error(data.error));
      else waiting?.resolve(data.result as never);
    };
    for (let i = 0; i < workers; ++i) this.idle.push(this.createTileWorker());
  }

  // Rejects with one sentence if the tile is damaged or was cancelled by cancelJobs().
  decode(job: TileJob, owner: object): Promise<DecodedTile> {
    return new Promise((resolve, reject) => {
      this.queue.push({ job, owner, done: { resolve, reject } });
      this.dispatch();
    });
  }

  // Drops and rejects the owner's jobs that have not started.
  cancelJobs(owner: object): void {
    const gone = this.queue.filter((one) => one.owner === owner);
    this.queue.splice(0, Infinity, ...this.queue.filter((one) => one.owner !== owner));
    for (const { done } of gone) done.reject(new Error("Cancelled."));
  }

  drop(ids: string[]): void {
    this.meshWorker.postMessage({ kind: "drop", ids } satisfies MeshRequest);
  }

  check(ids: string[], border: DataBorder): Promise<CheckedStep> {
    return this.query((request) => ({ kind: "check", request, ids, border }));
  }

  // Selects the drawn components of the step.
  select(drawn: DrawnTiles): Promise<Selection> {
    return this.query((request) => ({ kind: "select", request, drawn }));
  }

  pick(drawn: DrawnTiles, ray: PickRay): Promise<Hit | null> {
    return this.query((request) => ({ kind: "pick", request, drawn, ray }));
  }

  // Measures a connected part, given by a triangle from a hit of the same drawn tiles or by a place; null: all parts.
  measure(drawn: DrawnTiles, toWorld: number[], at: MeasuredPart | null): Promise<MassProperties | null> {
    return this.query((request) => ({ kind: "measure", request, drawn, toWorld, at }));
  }

  // Converts the scalars of a second field at the tile's vertices for the GPU.
  scalars(id: string, codes: Uint8Array, bits: number): Promise<Float32Array> {
    return this.query((request) => ({ kind: "scalars", request, id, codes, bits }));
  }

  // Returns segments; plane and segments in lattice coordinates.
  cut(drawn: DrawnTiles, plane: CutPlane): Promise<Float32Array> {
    return this.query((request) => ({ kind: "cut", request, drawn, plane }));
  }

  file(surfaces: readonly SavedSurface[], format: MeshFormat): Promise<Uint8Array> {
    return this.query((request) => ({ kind: "file", request, surfaces, format }));
  }

  // Ends all workers; pending promises never settle.
  dispose(): void {
    for (const worker of [this.meshWorker, ...this.idle, ...this.jobs.keys()]) worker.terminate();
  }

  private query<T>(make: (request: number) => MeshRequest): Promise<T> {
    const request = ++this.lastQuery;
    return new Promise((resolve, reject) => {
      this.queries.set(request, { resolve, reject });
      this.meshWorker.postMessage(make(request));
    });
  }

  private createTileWorker(): Worker {
    const worker = new Worker(new URL("./tile_worker.ts", import.meta.url), { type: "module" });
    const channel = new MessageChannel();
    worker.postMessage({ kind: "meshWorker", port: channel.port1 }, [channel.port1]);
    this.meshWorker.postMessage({ kind: "port", port: channel.port2 } satisfies MeshRequest, [
      channel.port2,
    ]);
    worker.onmessage = ({ data }: MessageEvent<DecodedTile | DamagedTile>) => {
      const done = this.jobs.get(worker);
      this.jobs.delete(worker);
      this.idle.push(worker);
      this.dispatch();
      if (data.kind === "decoded") done?.resolve(data);
      else done?.reject(new Error(data.text));
    };
    return worker;
  }

  private dispatch(): void {
    while (this.idle.length > 0 && this.queue.length > 0) {
      const worker = this.idle.pop()!;
      const { job, done } = this.queue.shift()!;
      this.jobs.set(worker, done);
      worker.postMessage(job);
    }
  }
}
