// Reads a prepared file (server/dataset/FORMAT.md) by ranges: what a surface needs, without the errors. Nothing in it is
// trusted: checksums, sizes and places are checked. Errors are sentences that name the file.
import { createXXHash3 } from "hash-wasm";
import { create, type DatasetInfo, DatasetInfoSchema } from "../protocol/messages";
import { type SampleArray, sampleBytes, samplesOf } from "../stream/sample_array";
import type { BlockStore } from "./block_store";
import { datasetInfo } from "./dataset_metadata";
import { type Bytes, FileBlocks } from "./file_blocks";
import { cellExtent, coarseExtent, sizeOf } from "./level_extents";
import { entryOf, unpacked } from "./packed_brick";
import { RangedFile } from "./ranged_file";
import { indexBytes, SampleBricks } from "./sample_bricks";

// What a surface is made from.
export interface PreparedVolume {
  info: DatasetInfo;
  coarse: SampleArray; // The samples of coarseExtent().
  ranges: SampleArray; // The least and the largest of every cell of cellExtent().
  bricks: SampleBricks;
  file: RangedFile;
}

interface Section {
  offset: number;
  size: number;
  checksum: bigint;
}

const magic = [0x89, 0x4d, 0x54, 0x44, 0x31, 0x0d, 0x0a, 0x1a];
const formatVersion = 1;
const firstBytes = 1 << 18; // A multiple of a block, and enough for a first preview of most datasets.
const headBytes = 4096;
const maxSections = 64;
const maxMetadataBytes = 1 << 20;
const pieceBytes = 1 << 18;
const maxSamples = 2 ** 31; // Of `coarse` or `ranges`.
const wrongSize = "it has another size than the metadata requires";
const known = ["metadata", "bins", "specidx", "coarse", "ranges", "spectrum", "samples", "smplidx"];

// Opens a dataset in two or three requests. Rejects with one sentence.
export async function openPrepared(address: string, store: BlockStore | null = null): Promise<PreparedVolume> {
  const file = new RangedFile(address);
  const blocks = new FileBlocks(file, store);
  const head = await file.read(0, firstBytes);
  blocks.add(0, head);
  return new Opening(file, blocks, head, await sectionChecksum()).open();
}

// Returns the function for the checksums of the format.
export async function sectionChecksum(): Promise<(bytes: Uint8Array) => bigint> {
  const hash = await createXXHash3();
  return (bytes) => BigInt(`0x${hash.init().update(bytes).digest("hex")}`);
}

class Opening {
  private sections = new Map<string, Section>();
  private info!: DatasetInfo;
  private bytes!: Bytes; // Of the sections required last.

  constructor(
    private readonly file: RangedFile,
    private readonly blocks: FileBlocks,
    private readonly head: Uint8Array,
    private readonly checksum: (bytes: Uint8Array) => bigint,
  ) {}

  async open(): Promise<PreparedVolume> {
    this.readTable();
    this.info = await this.readInfo();
    const { info, file } = this;
    const [coarseSamples, rangeSamples] = [sizeOf(coarseExtent(info)), 2 * sizeOf(cellExtent(info))];
    this.checkPieces("coarse", coarseSamples);
    this.checkPieces("ranges", rangeSamples);
    if (this.sections.get("smplidx")!.size !== indexBytes(info)) throw this.damaged("smplidx", wrongSize);
    await this.require("coarse", "ranges", "smplidx");
    const coarse = await this.readPieces("coarse", coarseSamples);
    const ranges = await this.readPieces("ranges", rangeSamples);
    const index = this.readSection("smplidx");
    const bricks = new SampleBricks(info, this.sections.get("samples")!, index, this.blocks, this.checksum, (what) => this.damaged("samples", what));
    return { info, coarse, ranges, bricks, file };
  }

  private readTable(): void {
    const { head, file } = this;
    const view = new DataView(head.buffer, head.byteOffset, head.length);
    if (head.length < headBytes || magic.some((byte, i) => head[i] !== byte)) throw new Error(`${file.name} is not a prepared dataset (.mtd) of release 1.`);
    const version = view.getUint32(8, true);
    if (version !== formatVersion) throw new Error(`${file.name} has format version ${version}; this page reads version ${formatVersion}.`);
    const count = view.getUint32(12, true);
    if (count < 1 || count > maxSections) throw this.damaged("table", `it counts ${count} sections`);
    const end = 24 + 40 * count;
    if (this.checksum(head.subarray(0, end)) !== view.getBigUint64(end, true)) throw this.damaged("table", "its checksum does not match");
    const fileBytes = number64(view, 16);
    for (let at = 24; at < end; at += 40) this.readEntry(view, at, fileBytes);
    for (const name of known) {
      const isOptional = name === "specidx" || name === "spectrum";
      if (!isOptional && !this.sections.has(name)) throw this.damaged(name, "it is missing");
    }
  }

  private readEntry(view: DataView, at: number, fileBytes: number): void {
    const name = String.fromCharCode(...this.head.subarray(at, at + 8)).replace(/\0+$/, "");
    const section = { offset: number64(view, at + 16), size: number64(view, at + 24), checksum: view.getBigUint64(at + 32, true) };
    if (this.sections.has(name)) throw this.damaged("table", `it lists section "${name}" twice`);
    if (section.offset < headBytes || section.offset + section.size > fileBytes) throw this.damaged(name, "it lies outside the file");
    const isRequired = (view.getUint32(at + 8, true) & 1) !== 0;
    if (isRequired && !known.includes(name)) throw new Error(`${this.file.name} has a section "${name}" that this page does not know: use a newer one.`);
    this.sections.set(name, section);
  }

  private async readInfo(): Promise<DatasetInfo> {
    if (this.sections.get("metadata")!.size > maxMetadataBytes) throw this.damaged("metadata", "it is too large");
    await this.require("metadata");
    try {
      const info = datasetInfo(JSON.parse(new TextDecoder().decode(this.readSection("metadata"))));
      return create(DatasetInfoSchema, { ...info, contentId: this.contentId() });
    } catch (error) {
      throw this.damaged("metadata", (error as Error).message);
    }
  }

  // The same as content_id_of() in server/dataset/prepared_format.cpp.
  private contentId(): bigint {
    const sum = (name: string) => this.sections.get(name)!.checksum;
    const errors = this.sections.has("spectrum") ? sum("bins") : 0n;
    return this.checksum(new Uint8Array(BigUint64Array.of(BigInt(formatVersion), sum("metadata"), sum("samples"), sum("smplidx"), errors).buffer));
  }

  private async require(...names: string[]): Promise<void> {
    this.bytes = await this.blocks.require(
      names.map((name) => {
        const { offset, size } = this.sections.get(name)!;
        return [offset, offset + size] as const;
      }),
    );
  }

  // Requires a section that was required.
  private readSection(name: string): Uint8Array {
    const { offset, size, checksum } = this.sections.get(name)!;
    const bytes = this.bytes(offset, offset + size);
    if (this.checksum(bytes) !== checksum) throw this.damaged(name, "its checksum does not match");
    return bytes;
  }

  // Before it is fetched: the table may state any size.
  private checkPieces(name: string, samples: number): void {
    const total = samples * sampleBytes(this.info.type);
    const isLarge = this.sections.get(name)!.size > total + 4 * Math.ceil(total / pieceBytes);
    if (samples > maxSamples || isLarge) throw this.damaged(name, wrongSize);
  }

  private async readPieces(name: string, samples: number): Promise<SampleArray> {
    const { type } = this.info;
    const total = samples * sampleBytes(type);
    const packed = this.readSection(name);
    const all = new Uint8Array(total);
    let at = 0;
    for (let done = 0; done < total; done += pieceBytes) {
      if (at + 4 > packed.length) throw this.damaged(name, "it ends too early");
      const { size, codec } = entryOf(new DataView(packed.buffer, packed.byteOffset + at, 4).getUint32(0, true));
      const bytes = Math.min(pieceBytes, total - done);
      const piece = await unpacked(codec, packed.subarray(at + 4, at + 4 + size), bytes, sampleBytes(type));
      if (!piece) throw this.damaged(name, "it cannot be decompressed");
      all.set(piece, done);
      at += 4 + size;
    }
    if (at !== packed.length) throw this.damaged(name, "it has bytes after its last piece");
    return samplesOf(type, all);
  }

  private damaged(section: string, what: string): Error {
    return new Error(`${this.file.name} is damaged: section "${section}": ${what}. Upload it again.`);
  }
}

// Larger ones are no places in a file.
function number64(view: DataView, at: number): number {
  return Number(view.getBigUint64(at, true));
}
