// The page's interface to the worker that makes slabs, which runs while a volume is fetched. Small ones are made at once: a
// worker begins later.
import { samplesOf } from "./levels";
import { madeSlab, type Slab, type SlabJob } from "./slab";
import type { SlabReply } from "./slab_worker";

const small = 1 << 17; // Samples.

export class SlabMaker {
  private worker: Worker | null = null;
  private readonly waiting = new Map<number, { resolve: (slab: Slab) => void; reject: (error: Error) => void }>();
  private last = 0;

  // Rejects with one sentence.
  make(job: SlabJob): Promise<Slab> {
    if (samplesOf(job.counts) <= small) return madeSlab(job);
    this.worker ??= this.started();
    const id = ++this.last;
    return new Promise((resolve, reject) => {
      this.waiting.set(id, { resolve, reject });
      this.worker!.postMessage({ id, job });
    });
  }

  // Ends the worker; what is being made is rejected.
  close(reason = "Cancelled."): void {
    this.worker?.terminate();
    this.worker = null;
    for (const { reject } of this.waiting.values()) reject(new Error(reason));
    this.waiting.clear();
  }

  private started(): Worker {
    const worker = new Worker(new URL("./slab_worker.ts", import.meta.url), { type: "module" });
    worker.onmessage = ({ data }: MessageEvent<SlabReply>) => {
      const { resolve, reject } = this.waiting.get(data.id)!;
      this.waiting.delete(data.id);
      if ("slab" in data) resolve(data.slab);
      else reject(new Error(data.text));
    };
    worker.onerror = () => this.close("The worker that converts samples has failed.");
    return worker;
  }
}
