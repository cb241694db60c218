// Parts of a file in blocks, kept in memory and in the browser's storage, so that only what is new is fetched.
import type { BlockStore } from "./block_store";
import type { RangedFile } from "./ranged_file";

export type Range = readonly [offset: number, end: number];

// Receives the share of what is fetched; returns false if nobody needs the rest any more.
export type FetchProgress = (share: number) => boolean;

// Returns bytes of a required range. Throws if the file ends before.
export type Bytes = (offset: number, end: number) => Uint8Array;

const blockBytes = 1 << 13;
const maxGap = 2; // Blocks that are fetched in vain rather than in another request.
const maxRunBlocks = 128; // 1 MiB a request.
const maxRequests = 6; // At a time.
const maxKept = 1 << 28; // Bytes in memory; more only while they are needed at once.

export class FileBlocks {
  private readonly blocks = new Map<number, Uint8Array>(); // The least recently required ones first.
  private readonly coming = new Map<number, Promise<unknown>>(); // What is being fetched.

  constructor(
    private readonly file: RangedFile,
    private readonly store: BlockStore | null,
  ) {}

  async require(ranges: readonly Range[], progress: FetchProgress = () => true): Promise<Bytes> {
    const needed = new Set<number>();
    for (const [offset, end] of ranges) {
      for (let block = Math.floor(offset / blockBytes); block * blockBytes < end; ++block) needed.add(block);
    }
    for (let others = this.comingOf(needed); others.size > 0; others = this.comingOf(needed)) await Promise.allSettled(others);
    const held = new Map([...needed].filter((block) => this.blocks.has(block)).map((block) => [block, this.blocks.get(block)!]));
    const absent = [...needed].filter((block) => !held.has(block)).sort((a, b) => a - b);
    const loading = this.load(absent, progress);
    for (const block of absent) this.coming.set(block, loading);
    try {
      for (const [block, bytes] of await loading) held.set(block, bytes);
    } finally {
      for (const block of absent) this.coming.delete(block);
    }
    this.keep(held);
    return (offset, end) => this.bytesOf(held, offset, end);
  }

  // Keeps bytes that were read otherwise. Requires an offset at the beginning of a block.
  add(offset: number, bytes: Uint8Array): void {
    this.keep(blocksOf(offset, bytes));
  }

  private comingOf(needed: ReadonlySet<number>): Set<Promise<unknown>> {
    return new Set([...needed].flatMap((block) => this.coming.get(block) ?? []));
  }

  // Returns ascending blocks from the storage or the file.
  private async load(absent: readonly number[], progress: FetchProgress): Promise<Map<number, Uint8Array>> {
    if (absent.length === 0) return new Map();
    const { identity } = this.file;
    const stored = (identity && (await this.store?.get(identity, absent))) || [];
    const found = new Map(stored.flatMap((bytes, i) => (bytes ? [[absent[i], bytes] as const] : [])));
    const fetched = await this.fetch(
      absent.filter((block) => !found.has(block)),
      progress,
    );
    if (identity && fetched.size > 0) void this.store?.put(identity, fetched);
    return new Map([...found, ...fetched]);
  }

  private async fetch(absent: readonly number[], progress: FetchProgress): Promise<Map<number, Uint8Array>> {
    const runs: [number, number][] = []; // First block, and the one after the last.
    for (const block of absent) {
      const last = runs.at(-1);
      if (last && block - last[1] <= maxGap && block - last[0] < maxRunBlocks) last[1] = block + 1;
      else runs.push([block, block + 1]);
    }
    const total = runs.length;
    const fetched = new Map<number, Uint8Array>();
    const fetchNext = async (): Promise<void> => {
      for (let run = runs.shift(); run; run = runs.shift()) {
        const [first, end] = run.map((block) => block * blockBytes);
        for (const [block, bytes] of blocksOf(first, await this.file.read(first, end))) fetched.set(block, bytes);
        if (!progress(1 - runs.length / total)) runs.length = 0;
      }
    };
    await Promise.all(Array.from({ length: maxRequests }, fetchNext));
    return fetched;
  }

  // Makes them the most recent ones, and drops the oldest others.
  private keep(blocks: ReadonlyMap<number, Uint8Array>): void {
    for (const block of blocks.keys()) this.blocks.delete(block);
    for (const block of this.blocks.keys()) {
      if ((this.blocks.size + blocks.size) * blockBytes <= maxKept) break;
      this.blocks.delete(block);
    }
    for (const [block, bytes] of blocks) this.blocks.set(block, bytes);
  }

  private bytesOf(held: ReadonlyMap<number, Uint8Array>, offset: number, end: number): Uint8Array {
    const whole = new Uint8Array(end - offset);
    for (let block = Math.floor(offset / blockBytes); block * blockBytes < end; ++block) {
      const from = block * blockBytes;
      const piece = held.get(block)?.subarray(Math.max(0, offset - from), Math.min(blockBytes, end - from));
      const needed = Math.min(end, from + blockBytes) - Math.max(offset, from);
      if (piece?.length !== needed) throw new Error(`${this.file.name} ends too early: upload it again.`);
      whole.set(piece, Math.max(0, from - offset));
    }
    return whole;
  }
}

function blocksOf(offset: number, bytes: Uint8Array): Map<number, Uint8Array> {
  const count = Math.ceil(bytes.length / blockBytes);
  return new Map(Array.from({ length: count }, (_, i) => [offset / blockBytes + i, bytes.slice(i * blockBytes, (i + 1) * blockBytes)]));
}
