// Parts of a file in blocks, kept in memory and in the browser's storage, so that only what is new is fetched.
import type { BlockStore } from "./block_store";
import type { RangedFile } from "./ranged_file";

export type Range = readonly [offset: number, end: number];

const blockBytes = 1 << 14;
const maxGap = 4; // Blocks that are fetched in vain rather than in another request.
const maxRunBlocks = 256; // 4 MiB a request.
const maxRequests = 6; // At a time.
const maxKept = 1 << 28; // Bytes in memory; more only while they are needed at once.

export class FileBlocks {
  private readonly blocks = new Map<number, Uint8Array>(); // The least recently required ones first.

  constructor(
    private readonly file: RangedFile,
    private readonly store: BlockStore | null,
  ) {}

  // Resolves when bytes() has these ranges, until the next call. `progress` receives the share of what is fetched.
  async require(ranges: readonly Range[], progress: (share: number) => void = () => {}): Promise<void> {
    const needed = new Set<number>();
    for (const [offset, end] of ranges) {
      for (let block = Math.floor(offset / blockBytes); block * blockBytes < end; ++block) needed.add(block);
    }
    this.dropOthers(needed);
    const { identity } = this.file;
    const absent = [...needed].filter((block) => !this.blocks.has(block)).sort((a, b) => a - b);
    if (absent.length === 0) return;
    const stored = identity ? ((await this.store?.get(identity, absent)) ?? []) : [];
    stored.forEach((bytes, i) => bytes && this.blocks.set(absent[i], bytes));
    await this.fetch(
      absent.filter((block) => !this.blocks.has(block)),
      progress,
    );
  }

  // Keeps bytes that were read otherwise. Requires an offset at the beginning of a block.
  add(offset: number, bytes: Uint8Array): void {
    for (let at = 0; at < bytes.length; at += blockBytes) this.blocks.set((offset + at) / blockBytes, bytes.slice(at, at + blockBytes));
  }

  // Returns bytes of a required range. Throws if the file ends before.
  bytes(offset: number, end: number): Uint8Array {
    const first = Math.floor(offset / blockBytes);
    const within = offset - first * blockBytes;
    const part = this.blocks.get(first)?.subarray(within, within + end - offset);
    if (part?.length === end - offset) return part;
    const whole = new Uint8Array(end - offset);
    for (let block = first; block * blockBytes < end; ++block) {
      const from = block * blockBytes;
      const piece = this.blocks.get(block)?.subarray(Math.max(0, offset - from), Math.min(blockBytes, end - from));
      if (!piece || Math.max(offset, from) + piece.length < Math.min(from + blockBytes, end))
        throw new Error(`${this.file.name} ends too early: upload it again.`);
      whole.set(piece, Math.max(0, from - offset));
    }
    return whole;
  }

  private async fetch(absent: readonly number[], progress: (share: number) => void): Promise<void> {
    const runs: [number, number][] = []; // First block, and the one after the last.
    for (const block of absent) {
      const last = runs.at(-1);
      if (last && block - last[1] <= maxGap && block - last[0] < maxRunBlocks) last[1] = block + 1;
      else runs.push([block, block + 1]);
    }
    const total = runs.length;
    const fetchNext = async (): Promise<void> => {
      for (let run = runs.shift(); run; run = runs.shift()) {
        this.add(run[0] * blockBytes, await this.file.read(run[0] * blockBytes, run[1] * blockBytes));
        progress(1 - runs.length / total);
      }
    };
    await Promise.all(Array.from({ length: maxRequests }, fetchNext));
    const { identity } = this.file;
    if (identity) this.store?.put(identity, new Map(absent.filter((block) => this.blocks.has(block)).map((block) => [block, this.blocks.get(block)!])));
  }

  private dropOthers(needed: ReadonlySet<number>): void {
    let excess = this.blocks.size + needed.size - maxKept / blockBytes;
    for (const block of [...this.blocks.keys()]) {
      const bytes = this.blocks.get(block)!;
      if (needed.has(block)) {
        this.blocks.delete(block); // Becomes the most recent one.
        this.blocks.set(block, bytes);
      } else if (excess-- > 0) this.blocks.delete(block);
    }
  }
}
