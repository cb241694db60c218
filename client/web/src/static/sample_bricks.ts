// The bricks of samples of a prepared file: fetched together, unpacked when they are read.
import type { DatasetInfo } from "../protocol/messages";
import type { Vec3 } from "../stream/dataset";
import { type SampleArray, sampleBytes, samplesOf } from "../stream/sample_array";
import type { Bytes, FetchProgress, FileBlocks } from "./file_blocks";
import { entryOf, unpacked } from "./packed_brick";

export const brickSide = 16;
const maxUnpackedBytes = 1 << 27; // Kept.

interface Place {
  offset: number; // In the file.
  size: number;
  codec: number;
  checksum: number;
}

function brickCounts({ dims }: DatasetInfo): Vec3 {
  return dims.map((n) => Math.ceil(n / brickSide)) as Vec3;
}

// Of the section that says where the bricks are.
export function indexBytes(info: DatasetInfo): number {
  const [x, y, z] = brickCounts(info);
  return 8 * x * y * z;
}

export class SampleBricks {
  readonly counts: Vec3;
  private readonly places: Place[];
  private readonly unpacked = new Map<number, SampleArray>(); // The least recently required ones first.

  // `index`: indexBytes() bytes. `damaged` makes an error.
  constructor(
    private readonly info: DatasetInfo,
    section: { offset: number; size: number },
    index: Uint8Array,
    private readonly blocks: FileBlocks,
    private readonly checksum: (bytes: Uint8Array) => bigint,
    private readonly damaged: (what: string) => Error,
  ) {
    this.counts = brickCounts(info);
    this.places = placesOf(this.counts, section, index);
    const last = this.places.reduce((end, { offset, size }) => Math.max(end, offset + size), section.offset);
    if (last !== section.offset + section.size) throw damaged("they do not fill it");
  }

  index(x: number, y: number, z: number): number {
    return x + this.counts[0] * (y + this.counts[1] * z);
  }

  // Samples along each axis.
  extent(x: number, y: number, z: number): Vec3 {
    return [x, y, z].map((at, axis) => Math.min(brickSide, this.info.dims[axis] - brickSide * at)) as Vec3;
  }

  packedBytes(bricks: readonly number[]): number {
    return bricks.reduce((sum, brick) => sum + this.places[brick].size, 0);
  }

  // Fetches them together, for unpack().
  fetch(bricks: readonly number[], progress?: FetchProgress): Promise<Bytes> {
    return this.blocks.require(
      bricks.map((brick) => [this.places[brick].offset, this.places[brick].offset + this.places[brick].size]),
      progress,
    );
  }

  // Returns the samples of each brick. Rejects if one is damaged.
  async unpack(bricks: readonly number[]): Promise<ReadonlyMap<number, SampleArray>> {
    const found = new Map(bricks.filter((brick) => this.unpacked.has(brick)).map((brick) => [brick, this.unpacked.get(brick)!]));
    const absent = bricks.filter((brick) => !found.has(brick));
    const bytes = await this.fetch(absent);
    for (const brick of absent) found.set(brick, await this.samplesOf(brick, bytes));
    for (const brick of bricks) this.unpacked.delete(brick);
    const most = maxUnpackedBytes / (brickSide ** 3 * sampleBytes(this.info.type)) - bricks.length;
    for (const brick of this.unpacked.keys()) {
      if (this.unpacked.size <= most) break;
      this.unpacked.delete(brick);
    }
    for (const [brick, samples] of found) this.unpacked.set(brick, samples);
    return found;
  }

  private async samplesOf(brick: number, bytesOf: Bytes): Promise<SampleArray> {
    const { offset, size, codec, checksum } = this.places[brick];
    const packed = bytesOf(offset, offset + size);
    if (Number(this.checksum(packed) & 0xffffffffn) !== checksum) throw this.damaged(`brick ${brick}: its checksum does not match`);
    const [x, y, z] = this.counts;
    const [nx, ny, nz] = this.extent(brick % x, Math.floor(brick / x) % y, Math.floor(brick / x / y) % z);
    const itemBytes = sampleBytes(this.info.type);
    const bytes = await unpacked(codec, packed, nx * ny * nz * itemBytes, itemBytes);
    if (!bytes) throw this.damaged(`brick ${brick}: it cannot be decompressed`);
    return samplesOf(this.info.type, bytes);
  }
}

// Bricks lie in Morton order, each at a multiple of 4.
function placesOf(counts: Vec3, { offset }: { offset: number }, index: Uint8Array): Place[] {
  const places: Place[] = new Array(counts[0] * counts[1] * counts[2]);
  const view = new DataView(index.buffer, index.byteOffset, index.length);
  let next = 0;
  let end = 0;
  const visit = (x: number, y: number, z: number, side: number): void => {
    if (x >= counts[0] || y >= counts[1] || z >= counts[2]) return;
    if (side > 1) {
      const half = side / 2;
      for (let octant = 0; octant < 8; ++octant) visit(x + (octant & 1) * half, y + ((octant >> 1) & 1) * half, z + (octant >> 2) * half, half);
      return;
    }
    const begin = 4 * Math.ceil(end / 4);
    const entry = entryOf(view.getUint32(next, true));
    places[x + counts[0] * (y + counts[1] * z)] = { ...entry, offset: offset + begin, checksum: view.getUint32(next + 4, true) };
    end = begin + entry.size;
    next += 8;
  };
  visit(0, 0, 0, 2 ** Math.ceil(Math.log2(Math.max(...counts))));
  return places;
}
