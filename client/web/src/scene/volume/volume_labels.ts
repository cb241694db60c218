// The labels of a volume: which label each sample of their map has, and their colors.
import * as THREE from "three";
import type { DatasetInfo } from "../../protocol/messages";
import type { Vec3 } from "../../stream/dataset";
import type { SampleBox } from "../../stream/dataset_queries";
import { unpackedSamples } from "../../stream/packed_samples";
import type { SampleArray } from "../../stream/sample_array";
import { type Level, levelsOf, samplesOf, slabsOf, type VolumeBudget } from "./levels";
import type { VolumeSources } from "./volume";
import type { VolumePass } from "./volume_pass";

export interface ShownLabel {
  at: number; // The index of its surface, which is not drawn.
  info: DatasetInfo; // All labels have the same grid.
  color: string; // "#rrggbb"
  isVisible: boolean;
}

export interface ShownLabels {
  labels: readonly ShownLabel[]; // At least one.
  isOnly: boolean; // Samples without a label are transparent.
}

const concurrent = 2; // Queries.
const inside = 0.5; // Larger values of a label's field are inside of it.
const uploadInterval = 500; // Milliseconds.

export class VolumeLabels {
  private map: LabelMap | null = null;
  private running = 0;
  private loading: Promise<unknown> = Promise.resolve();

  constructor(
    private readonly pass: VolumePass,
    private readonly budget: VolumeBudget,
    private readonly sources: Pick<VolumeSources, "queries" | "failed">,
    private readonly changed: () => void,
  ) {}

  get isLoading(): boolean {
    return this.running > 0;
  }

  // Resolves when no label is missing, or fetching failed.
  async settled(): Promise<void> {
    for (let loading = null; loading !== this.loading; ) await (loading = this.loading);
  }

  // Null: none.
  update(shown: ShownLabels | null): void {
    if (!shown || this.map?.key !== keyOf(shown)) {
      this.map?.dispose();
      this.map = shown && new LabelMap(shown, this.budget);
    }
    if (shown) this.map?.setColors(shown);
    this.pass.setLabels(this.map);
    if (!this.map) return;
    this.loading = Promise.all([this.loading, this.fetch(this.map)]);
  }

  private async fetch(map: LabelMap): Promise<void> {
    const fetchNext = async (): Promise<void> => {
      const label = this.map === map ? map.next() : undefined;
      if (label === undefined) return;
      try {
        for (const box of map.boxes(label)) {
          if (this.map !== map) return;
          const packed = await this.sources.queries.box(map.nameOf(label), box);
          map.paint(label, box, await unpackedSamples(packed, samplesOf(box.counts)));
        }
      } catch (error) {
        map.retryLater(label);
        throw error;
      }
      if (map.upload(uploadInterval)) this.changed();
      return fetchNext();
    };
    this.running += 1;
    try {
      await Promise.all(Array.from({ length: concurrent }, fetchNext));
      if (map.upload()) this.changed();
    } catch (error) {
      if (this.map === map) this.sources.failed(`Cannot color the volume by labels: ${(error as Error).message}`);
    }
    this.running -= 1;
  }
}

// The number of its label at each sample of a level; 0: none, or not fetched. Labels are numbered from 1.
export class LabelMap {
  readonly key: string;
  readonly info: DatasetInfo;
  readonly level: Level;
  readonly texture: THREE.Data3DTexture; // Numbers as bytes, the low one first.
  readonly colors: THREE.DataTexture; // By number; transparent: hidden.
  isOnly = false;
  private readonly names: readonly DatasetInfo[];
  private readonly numbers: Uint8Array<ArrayBuffer> | Uint16Array<ArrayBuffer>;
  private readonly begun = new Set<number>();
  private wanted: number[] = [];
  private isChanged = false;
  private uploaded = 0; // When.

  constructor(shown: ShownLabels, { samples, side }: VolumeBudget) {
    this.key = keyOf(shown);
    this.names = shown.labels.map(({ info }) => info);
    [this.info] = this.names;
    const isWide = this.names.length > 255;
    this.level = levelsOf(this.info, { samples: isWide ? samples / 2 : samples, side }).at(-1)!;
    this.numbers = new (isWide ? Uint16Array : Uint8Array)(samplesOf(this.level.counts));
    this.texture = new THREE.Data3DTexture(new Uint8Array(this.numbers.buffer), ...this.level.counts);
    this.texture.format = isWide ? THREE.RGFormat : THREE.RedFormat;
    this.texture.unpackAlignment = 1;
    this.texture.needsUpdate = true;
    this.colors = new THREE.DataTexture(new Uint8Array(4 * (this.names.length + 1)), this.names.length + 1, 1);
    this.colors.colorSpace = THREE.SRGBColorSpace;
  }

  setColors({ labels, isOnly }: ShownLabels): void {
    this.isOnly = isOnly;
    const { data } = this.colors.image;
    labels.forEach(({ color, isVisible }, at) => {
      const rgb = Number.parseInt(color.slice(1), 16);
      data.set([rgb >> 16, (rgb >> 8) & 255, rgb & 255, isVisible ? 255 : 0], 4 * (at + 1));
    });
    this.colors.needsUpdate = true;
    this.wanted = [...labels.keys()].filter((at) => labels[at].isVisible || !isOnly); // Hidden labels hide samples, too.
  }

  // Returns a label to fetch, once.
  next(): number | undefined {
    const label = this.wanted.find((at) => !this.begun.has(at));
    if (label !== undefined) this.begun.add(label);
    return label;
  }

  // Its samples did not come: the next update asks for them again.
  retryLater(label: number): void {
    this.begun.delete(label);
  }

  nameOf(label: number): string {
    return this.names[label].name;
  }

  // Returns boxes of samples of the level that together have all of the label.
  boxes(label: number): SampleBox[] {
    const { step, counts } = this.level;
    const box = this.names[label].member!.label!.box;
    const [least, greatest] = box.length === 6 ? [box.slice(0, 3), box.slice(3)] : [[0, 0, 0], this.info.dims.map((n) => n - 1)];
    const first = least.map((at) => Math.ceil(at / step)) as Vec3;
    const count = greatest.map((at, axis) => Math.min(Math.floor(at / step) + 1, counts[axis]) - first[axis]) as Vec3;
    return Math.min(...count) < 1 ? [] : slabsOf({ step, counts: count }, first.map((at) => at * step) as Vec3);
  }

  paint(label: number, { first, step, counts: [width, height, layers] }: SampleBox, values: SampleArray): void {
    const [x, y, z] = first.map((at) => at / step);
    const [across, down] = this.level.counts;
    for (let row = 0; row < height * layers; ++row) {
      const to = x + across * (y + (row % height) + down * (z + Math.floor(row / height)));
      for (let i = 0, from = width * row; i < width; ++i) if (values[from + i] > inside) this.numbers[to + i] = label + 1;
    }
    this.isChanged = true;
  }

  // Returns whether something new will be shown; `interval`: milliseconds since the last time.
  upload(interval = 0): boolean {
    if (!this.isChanged || performance.now() - this.uploaded < interval) return false;
    this.isChanged = false;
    this.uploaded = performance.now();
    return (this.texture.needsUpdate = true);
  }

  dispose(): void {
    this.texture.dispose();
    this.colors.dispose();
  }
}

function keyOf({ labels }: ShownLabels): string {
  return labels.map(({ info: { name, contentId } }) => `${name} ${contentId}`).join();
}
