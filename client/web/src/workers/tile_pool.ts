// The page's interface to the workers: several decode tiles, one keeps whole steps. Browsers give all frames of a site
// only about a hundred memories for WebAssembly: all workers that decode but the first start when there are tiles, they end
// when there are none, and tiles wait while there is no memory.

import type { MeshCalls } from "./mesh_worker";
import type { DecodedTile, MeshMessage, MeshReply, TileJob, TileReply } from "./worker_messages";

const idleTime = 5000; // Milliseconds until an idle worker ends.
const memoryWait = 500; // Milliseconds until memory is requested again.

interface Waiting<T> {
  resolve: (value: T) => void;
  reject: (error: Error) => void;
}

interface QueuedTile {
  job: TileJob;
  owner: object;
  done: Waiting<DecodedTile>;
}

export class TilePool {
  private idle: Worker[] = [];
  private readonly queue: QueuedTile[] = [];
  private readonly jobs = new Map<Worker, QueuedTile>();
  private idleTimer = 0;
  private isWaitingForMemory = false;
  private readonly meshWorker: Worker;
  private readonly queries = new Map<number, Waiting<never>>();
  private lastQuery = 0;

  // `maxWorkers`: those that decode at a time.
  constructor(private readonly maxWorkers: number) {
    this.meshWorker = new Worker(new URL("./mesh_worker.ts", import.meta.url), { type: "module" });
    this.meshWorker.onmessage = ({ data }: MessageEvent<MeshReply>) => {
      const waiting = this.queries.get(data.request);
      this.queries.delete(data.request);
      if (data.error) waiting?.reject(new Error(data.error));
      else waiting?.resolve(data.result as never);
    };
    this.meshWorker.onerror = () => {
      for (const { reject } of this.queries.values()) reject(new Error("The worker that keeps the meshes has failed."));
      this.queries.clear();
    };
    this.idle.push(this.createTileWorker()); // The first tile follows soon.
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
    this.meshWorker.postMessage({ kind: "drop", ids } satisfies MeshMessage);
  }

  // Calls the worker that keeps whole steps.
  call<Name extends keyof MeshCalls>(name: Name, ...args: Parameters<MeshCalls[Name]>): ReturnType<MeshCalls[Name]> {
    const request = ++this.lastQuery;
    return new Promise((resolve, reject) => {
      this.queries.set(request, { resolve, reject });
      this.meshWorker.postMessage({ kind: "call", request, name, args } satisfies MeshMessage);
    }) as ReturnType<MeshCalls[Name]>;
  }

  // Ends all workers; pending promises never settle.
  dispose(): void {
    clearTimeout(this.idleTimer);
    for (const worker of [this.meshWorker, ...this.idle, ...this.jobs.keys()]) worker.terminate();
  }

  private createTileWorker(): Worker {
    const worker = new Worker(new URL("./tile_worker.ts", import.meta.url), { type: "module" });
    const channel = new MessageChannel();
    worker.postMessage({ kind: "meshWorker", port: channel.port1 }, [channel.port1]);
    this.meshWorker.postMessage({ kind: "port", port: channel.port2 } satisfies MeshMessage, [channel.port2]);
    worker.onmessage = ({ data }: MessageEvent<TileReply>) => {
      const queued = this.jobs.get(worker)!;
      this.jobs.delete(worker);
      if (data.kind === "noMemory") return this.waitForMemory(worker, queued);
      this.idle.push(worker);
      this.dispatch();
      if (data.kind === "decoded") queued.done.resolve(data);
      else queued.done.reject(new Error(data.text));
    };
    return worker;
  }

  // The tile is decoded when another worker is idle or there is memory again.
  private waitForMemory(worker: Worker, queued: QueuedTile): void {
    worker.terminate();
    this.queue.unshift(queued);
    this.isWaitingForMemory = true;
    setTimeout(() => {
      this.isWaitingForMemory = false;
      this.dispatch();
    }, memoryWait);
  }

  private dispatch(): void {
    const canStart = () => !this.isWaitingForMemory && this.jobs.size < this.maxWorkers;
    while (this.queue.length > 0 && (this.idle.length > 0 || canStart())) {
      const worker = this.idle.pop() ?? this.createTileWorker();
      const queued = this.queue.shift()!;
      this.jobs.set(worker, queued);
      worker.postMessage(queued.job);
    }
    clearTimeout(this.idleTimer);
    this.idleTimer = window.setTimeout(() => this.endIdle(), idleTime);
  }

  private endIdle(): void {
    for (const worker of this.idle) worker.terminate();
    this.idle = [];
  }
}
