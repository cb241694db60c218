// The samples of a level on the GPU.
import * as THREE from "three";

import { type DatasetInfo, SampleType } from "../../protocol/messages";
import type { Vec3 } from "../../stream/dataset";
import type { SampleBox } from "../../stream/dataset_queries";
import type { PackedSamples } from "../../stream/packed_samples";
import { BlockRanges, type Level } from "./levels";
import type { Slab, SlabJob, TexelRules } from "./slab";

// The values of texels 0 and 1.
export function texelRange({ type, min, max }: Pick<DatasetInfo, "type" | "min" | "max">): [number, number] {
  if (type === SampleType.U8) return [0, 255];
  if (type === SampleType.I8) return [-128, 127];
  return [min, max > min ? max : min + 1];
}

export class VolumeTexture {
  readonly texture: THREE.Data3DTexture;
  readonly rules: TexelRules;
  readonly ranges: BlockRanges;

  constructor(
    private readonly renderer: THREE.WebGLRenderer,
    info: DatasetInfo,
    readonly level: Level,
  ) {
    const { type } = info;
    this.rules = { range: texelRange(info), isOfBytes: type === SampleType.U8 || type === SampleType.I8, isOfIntegers: type !== SampleType.F32 };
    this.ranges = new BlockRanges(level.counts);
    this.texture = this.data(null, level.counts);
    this.texture.source.dataReady = false; // Only allocates; put() fills it.
    this.texture.needsUpdate = true;
  }

  // Returns what to make of the samples of a slab, for put().
  job({ first, step, counts }: SampleBox, packed: PackedSamples): SlabJob {
    const [, y, z] = first.map((index) => index / step);
    return { packed, counts, row: z * this.level.counts[1] + y, layer: z, levelCounts: this.level.counts, texels: this.rules };
  }

  put({ counts, row, layer, levelCounts }: SlabJob, { texels, ranges }: Slab): void {
    this.ranges.merge(ranges);
    const place = new THREE.Vector3(0, row - layer * levelCounts[1], layer);
    this.renderer.copyTextureToTexture(this.data(texels, counts), this.texture, null, place as unknown as THREE.Vector2);
  }

  dispose(): void {
    this.texture.dispose();
  }

  private data(texels: Uint8Array<ArrayBuffer> | Uint16Array<ArrayBuffer> | null, counts: Vec3): THREE.Data3DTexture {
    const texture = new THREE.Data3DTexture(texels, ...counts);
    texture.format = THREE.RedFormat;
    texture.type = this.rules.isOfBytes ? THREE.UnsignedByteType : THREE.HalfFloatType;
    texture.minFilter = texture.magFilter = THREE.LinearFilter;
    texture.unpackAlignment = 1;
    return texture;
  }
}

// Returns a texture of a level's blocks: whether they are visible, and their largest values, rounded up.
export function blockTexture(
  { ranges, rules: { range } }: Pick<VolumeTexture, "ranges" | "rules">,
  isVisible: (low: number, high: number) => boolean,
): THREE.Data3DTexture {
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
