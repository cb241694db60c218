// Makes slabs off the page's thread.
import { madeSlab, type Slab, type SlabJob } from "./slab";

export type SlabReply = { id: number } & ({ slab: Slab } | { text: string });

self.onmessage = async ({ data: { id, job } }: MessageEvent<{ id: number; job: SlabJob }>) => {
  try {
    const slab = await madeSlab(job);
    self.postMessage({ id, slab } satisfies SlabReply, { transfer: [slab.texels.buffer, slab.ranges.low.buffer, slab.ranges.high.buffer] });
  } catch (error) {
    self.postMessage({ id, text: (error as Error).message } satisfies SlabReply);
  }
};
