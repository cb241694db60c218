// The samples of a dataset as a volume in the scene: fetches its levels, coarsest first, and shows each when it is complete.
import type { DatasetInfo } from "../../protocol/messages";
import type { ColorScale } from "../../shared/color_maps";
import { isSameData } from "../../state/series";
import type { Settings } from "../../state/settings";
import type { DatasetQueries } from "../../stream/dataset_queries";
import type { TilePool } from "../../workers/tile_pool";
import { clipPlanes } from "../crop";
import type { Stage } from "../stage";
import { type Level, levelsOf, nextLevel, slabsOf, type VolumeBudget } from "./levels";
import { opacitiesOf } from "./opacities";
import { type ShownLabels, VolumeLabels } from "./volume_labels";
import { VolumePass } from "./volume_pass";
import { VolumeTexture } from "./volume_texture";

export interface ShownVolume {
  info: DatasetInfo; // The dataset of the samples.
  scale: ColorScale;
  labels: ShownLabels | null; // Replace colors of the scale.
}

export interface ShownLevel {
  step: number; // Every step-th sample along each axis is shown.
  isLast: boolean; // No finer ones follow.
}

export interface VolumeSources {
  queries: Pick<DatasetQueries, "box">;
  pool: Pick<TilePool, "call">; // Its worker converts samples.
  failed: (text: string) => void; // Called with a sentence.
  volumeShown: (level: ShownLevel | null) => void; // Null: none.
}

const concurrent = 3; // Queries; another one is left for slices.

export class Volume {
  private readonly pass: VolumePass;
  private readonly budget: VolumeBudget;
  private readonly labels: VolumeLabels;
  private wanted: DatasetInfo | null = null;
  private shown: VolumeTexture | null = null;
  private loading: Promise<void> = Promise.resolve();
  private isLoading = false;

  constructor(
    private readonly stage: Stage,
    private readonly sources: VolumeSources,
    isWeak: boolean,
  ) {
    const gl = stage.renderer.getContext() as WebGL2RenderingContext;
    this.budget = { samples: isWeak ? 1 << 26 : 1 << 28, side: gl.getParameter(gl.MAX_3D_TEXTURE_SIZE) as number };
    this.pass = new VolumePass(stage.renderer);
    stage.volume = this.pass;
    this.labels = new VolumeLabels(this.pass, this.budget, sources, () => stage.invalidate());
    stage.waitFor(() => this.isLoading || this.labels.isLoading);
    stage.renderer.domElement.addEventListener("webglcontextrestored", () => this.restart());
  }

  // Call when the settings or the dataset may have changed. `info`: the dataset of the first surface; null: no volume.
  update(settings: Settings, info: DatasetInfo | null, shown: ShownVolume | null): void {
    this.labels.update(shown?.labels ?? null);
    if (!shown) {
      if (this.wanted) this.show((this.wanted = null));
      return;
    }
    const { info: sampled, scale } = shown;
    this.pass.setLook({
      points: opacitiesOf(settings, sampled),
      scale,
      isMaximum: settings.volume === "maximum",
      isShaded: settings.volumeShading,
      clip: clipPlanes(settings, info),
    });
    this.stage.invalidate();
    if (isSameData(this.wanted, sampled)) return;
    this.wanted = sampled;
    this.loading = this.fetch(sampled);
  }

  // Resolves when all levels are shown, or fetching them failed.
  async settled(): Promise<void> {
    await this.labels.settled();
    for (let loading = null; loading !== this.loading; ) await (loading = this.loading);
  }

  private restart(): void {
    const { wanted } = this;
    this.show(null);
    if (!wanted) return;
    this.wanted = { ...wanted };
    this.loading = this.fetch(this.wanted);
  }

  private async fetch(info: DatasetInfo): Promise<void> {
    this.isLoading = true;
    try {
      const levels = levelsOf(info, this.budget);
      for (let at = 0, began = performance.now(); at < levels.length; at = nextLevel(levels, at, performance.now() - began)) {
        began = performance.now();
        const texture = await this.level(info, levels[at]);
        if (this.wanted !== info) return texture.dispose();
        this.show(texture, at + 1 === levels.length);
      }
    } catch (error) {
      if (this.wanted === info) this.sources.failed(`Cannot show the volume: ${(error as Error).message}`);
    }
    if (this.wanted !== info && this.wanted) return;
    this.isLoading = false;
  }

  private async level(info: DatasetInfo, level: Level): Promise<VolumeTexture> {
    const texture = new VolumeTexture(this.stage.renderer, info, level);
    const waiting = slabsOf(level);
    const fetchNext = async (): Promise<void> => {
      const slab = waiting.shift();
      if (!slab || this.wanted !== info) return;
      const job = texture.job(slab, await this.sources.queries.box(info.name, slab));
      const made = await this.sources.pool.call("slab", job);
      if (this.wanted === info) texture.put(job, made);
      return fetchNext();
    };
    await Promise.all(Array.from({ length: concurrent }, fetchNext));
    return texture;
  }

  private show(texture: VolumeTexture | null, isLast = false): void {
    this.shown?.dispose();
    this.shown = texture;
    this.pass.setSamples(texture, this.wanted);
    this.sources.volumeShown(texture && { step: texture.level.step, isLast });
    this.stage.invalidate();
  }
}
