// The samples of a level on the GPU: 8 bits for data of 8 bits, else half floats over the data's range.
import * as THREE from "three";

import { type DatasetInfo, SampleType } from "../../protocol/messages";
import type { Vec3 } from "../../stream/dataset";
import type { SampleBox } from "../../stream/dataset_queries";
import { BlockRanges, type Level } from "./levels";

const noValue = 0xfbff; // The half float -65504, which linear interpolation keeps below all values.

// The values of texels 0 and 1.
export function texelRange({ type, min, max }: Pick<DatasetInfo, "type" | "min" | "max">): [number, number] {
  if (type === SampleType.U8) return [0, 255];
  if (type === SampleType.I8) return [-128, 127];
  return [min, max > min ? max : min + 1];
}

export class VolumeTexture {
  readonly texture: THREE.Data3DTexture;
  readonly range: [number, number];
  readonly ranges: BlockRanges;
  private readonly isOfBytes: boolean;
  private readonly halves: Uint16Array | null; // By value, from the least one on, of integers.

  constructor(
    private readonly renderer: THREE.WebGLRenderer,
    info: DatasetInfo,
    readonly level: Level,
  ) {
    this.isOfBytes = info.type === SampleType.U8 || info.type === SampleType.I8;
    this.range = texelRange(info);
    this.ranges = new BlockRanges(level.counts);
    this.texture = this.data(null, level.counts);
    this.texture.source.dataReady = false; // Only allocates; put() fills it.
    this.texture.needsUpdate = true;
    const isOfIntegers = info.type === SampleType.U16 || info.type === SampleType.I16;
    this.halves = isOfIntegers ? Uint16Array.from({ length: info.max - info.min + 1 }, (_, i) => this.half(info.min + i)) : null;
  }

  // Sets samples of a slab.
  put({ first, step, counts }: SampleBox, values: Float32Array): void {
    const [, y, z] = first.map((index) => index / step);
    this.ranges.add(z * this.level.counts[1] + y, values);
    const part = this.data(this.texels(values), counts);
    this.renderer.copyTextureToTexture(part, this.texture, null, new THREE.Vector3(0, y, z) as unknown as THREE.Vector2);
  }

  dispose(): void {
    this.texture.dispose();
  }

  private texels(values: Float32Array): Uint8Array<ArrayBuffer> | Uint16Array<ArrayBuffer> {
    const [low] = this.range;
    const { halves } = this;
    const texels = this.isOfBytes ? new Uint8Array(values.length) : new Uint16Array(values.length);
    if (this.isOfBytes) for (let i = 0; i < values.length; ++i) texels[i] = values[i] - low;
    else for (let i = 0; i < values.length; ++i) texels[i] = halves?.[values[i] - low] ?? this.half(values[i]);
    return texels;
  }

  private half(value: number): number {
    const [low, high] = this.range;
    return Number.isNaN(value) ? noValue : THREE.DataUtils.toHalfFloat((value - low) / (high - low));
  }

  private data(texels: Uint8Array<ArrayBuffer> | Uint16Array<ArrayBuffer> | null, counts: Vec3): THREE.Data3DTexture {
    const texture = new THREE.Data3DTexture(texels, ...counts);
    texture.format = THREE.RedFormat;
    texture.type = this.isOfBytes ? THREE.UnsignedByteType : THREE.HalfFloatType;
    texture.minFilter = texture.magFilter = THREE.LinearFilter;
    texture.unpackAlignment = 1;
    return texture;
  }
}

// Returns a texture of a level's blocks: whether they are visible, and their largest values, rounded up.
export function blockTexture({ ranges, range }: VolumeTexture, isVisible: (low: number, high: number) => boolean): THREE.Data3DTexture {
  const texels = new Uint8Array(2 * ranges.low.length);
  for (let i = 0; i < ranges.low.length; ++i) {
    const [low, high] = [ranges.low[i], ranges.high[i]];
    if (!isVisible(low, high)) continue;
    texels[2 * i] = 255;
    texels[2 * i + 1] = Math.ceil(255 * Math.min(1, Math.max(0, (high - range[0]) / (range[1] - range[0]))) + 1e-3);
  }
  const texture = new THREE.Data3DTexture(texels, ...ranges.blocks);
  texture.format = THREE.RGFormat;
  texture.unpackAlignment = 1;
  texture.needsUpdate = true;
  return texture;
}
