// The datasets of a page without a server: one prepared file, or the files of an index that `export --page` wrote.
import type { DatasetInfo } from "../protocol/messages";
import { BlockStore } from "./block_store";
import { datasetInfo } from "./dataset_metadata";
import { openPrepared, type PreparedVolume } from "./prepared_file";

const indexVersion = 1;
const defaultSurface = 1 << 29;
const megabyte = 1e6;

interface Index {
  version: number;
  datasets: IndexEntry[];
  max_surface_megabytes?: number; // Written by hand.
}

interface IndexEntry {
  file: string; // Relative to the index.
  metadata: unknown; // That of the file.
}

export class PageDatasets {
  private readonly store = new BlockStore();
  private readonly opened = new Map<string, Promise<PreparedVolume>>(); // By address.
  maxSurfaceBytes = defaultSurface; // Samples around one surface, unpacked; as the index says.
  private listed: Promise<Map<string, { address: string; info: DatasetInfo }>> | null = null;

  constructor(private readonly address: string) {}

  // Rejects with one sentence.
  async list(): Promise<DatasetInfo[]> {
    return [...(await this.entries()).values()].map(({ info }) => info);
  }

  // Rejects with one sentence.
  async volume(name: string): Promise<PreparedVolume> {
    const entry = (await this.entries()).get(name);
    if (!entry) throw new Error(`This page has no dataset named "${name}".`);
    const volume = await this.open(entry.address);
    const { dims, type, name: found } = volume.info;
    if (found === name && type === entry.info.type && String(dims) === String(entry.info.dims)) return volume;
    throw new Error(`${volume.file.name} is not the file of the index: export the page again.`);
  }

  // Begins to read what will be requested.
  openEarly(name: string): void {
    const first = name ? Promise.resolve(name) : this.list().then(([info]) => info.name);
    first.then((one) => this.volume(one)).catch(() => {}); // Requests tell.
  }

  private entries() {
    this.listed ??= this.readEntries();
    this.listed.catch(() => (this.listed = null)); // The next attempt reads them again.
    return this.listed;
  }

  private async readEntries() {
    if (!/\.json$/i.test(new URL(this.address).pathname)) {
      const { info } = await this.open(this.address);
      return new Map([[info.name, { address: this.address, info }]]);
    }
    const reply = await fetch(this.address, { cache: "no-cache" }).catch(() => null);
    if (!reply?.ok) throw new Error(`The index ${this.address} cannot be read${reply ? `: status ${reply.status}` : ""}.`);
    try {
      const { version, datasets, max_surface_megabytes: most } = (await reply.json()) as Index;
      if (most !== undefined && !(most > 0)) throw new Error("its max_surface_megabytes is not a positive number");
      if (most) this.maxSurfaceBytes = most * megabyte;
      if (version !== indexVersion) throw new Error(`it has version ${version}, not ${indexVersion}`);
      const entries = datasets.map(({ file, metadata }) => ({ address: new URL(file, this.address).href, info: datasetInfo(metadata) }));
      return new Map(entries.map((entry) => [entry.info.name, entry]));
    } catch (error) {
      throw new Error(`${this.address} is not the index of a page: ${(error as Error).message}.`);
    }
  }

  private open(address: string): Promise<PreparedVolume> {
    const volume = this.opened.get(address) ?? openPrepared(address, this.store);
    this.opened.set(address, volume);
    volume.catch(() => this.opened.delete(address));
    return volume;
  }
}
