// All views of sample values: a slice in the scene, three linked slices beside it, and the color legends of samples and
// of a field on the surfaces.
import type * as THREE from "three";
import { isWeak, thisDevice } from "../embed/weak_device";
import { Legend, type LegendValues } from "../panel/legend";
import type { DatasetInfo } from "../protocol/messages";
import type { Picked } from "../scene/picking";
import type { Stage } from "../scene/stage";
import { volumeWindow } from "../scene/volume/opacities";
import { Volume, type VolumeSources } from "../scene/volume/volume";
import type { ShownLabels } from "../scene/volume/volume_labels";
import type { LegendText } from "../shared/color_maps";
import { h } from "../shared/elements";
import { defaultWindow, isCt } from "../shared/sample_window";
import { findByName, rangeOf, timesOf } from "../state/series";
import type { Settings } from "../state/settings";
import { applied, hasSameGrid, inverse, type Vec3 } from "../stream/dataset";
import { sampledOf, sceneOf } from "../surfaces/scene_at";
import type { SliceSources } from "./latest_slice";
import { SliceViews } from "./slice_views";
import { Slices, scaleOf, slicePosition } from "./slices";

export interface SampledWorld {
  info: DatasetInfo | null; // The dataset of the first surface.
  list: readonly DatasetInfo[]; // All datasets of the server.
}

export class SampleViews {
  readonly legends: HTMLElement;
  private readonly slices: Slices;
  private readonly views: SliceViews;
  private readonly volume: Volume;
  private readonly ofSamples: Legend;
  private readonly ofField: Legend;

  constructor(
    stage: Stage,
    private readonly sources: SliceSources & VolumeSources,
    private readonly world: () => SampledWorld,
    turn: (changes: Partial<Settings>, isDragging: boolean) => void,
    measure: (place: Picked) => void,
  ) {
    const current = () => ({
      info: this.world().info,
      sampled: this.sampled,
      settings: this.sources.settings(),
      rangeOfSamples: () => this.sampleRange(),
    });
    this.volume = new Volume(stage, sources, isWeak(thisDevice(stage.renderer.getContext())));
    this.slices = new Slices(stage, sources, current);
    this.views = new SliceViews(
      stage,
      sources,
      current,
      (cross, isDragging) => turn({ cross }, isDragging),
      (world) => {
        const info = this.sampled;
        if (info) measure({ world, index: applied(inverse(info.indexToWorld), world), info, surface: null });
      },
    );
    this.ofSamples = new Legend({ label: "samples", colors: "sliceColors", level: "level", width: "windowWidth", isLog: "samplesLog" }, turn);
    this.ofField = new Legend(
      {
        label: "the surface's colors",
        colors: "colors",
        level: "fieldLevel",
        width: "fieldWindow",
        isLog: "fieldLog",
      },
      turn,
    );
    this.legends = h("div", { class: "legends" }, this.ofField.element, this.ofSamples.element);
  }

  // The slices beside the scene.
  get element(): HTMLElement {
    return this.views.element;
  }

  // Marks their intersection, over the scene.
  get mark(): HTMLElement {
    return this.views.mark;
  }

  // The slices beside the scene, for pictures; null: they are hidden.
  get drawn(): SliceViews | null {
    return this.views.element.hidden ? null : this.views;
  }

  // The visible legends.
  get legendWords(): LegendText[] {
    return [this.ofSamples.words, this.ofField.words].filter((words) => words !== null);
  }

  // Returns where a ray hits a slice in the scene.
  hit(ray: THREE.Ray): Vec3 | null {
    return this.slices.hit(ray);
  }

  // Call when the settings or the dataset may have changed.
  update(): void {
    this.updateSlices();
    this.updateVolume(this.sources.settings());
    this.showLegends(this.sources.settings());
  }

  // Call when the surfaces have changed: slices show their outlines.
  updateSlices(): void {
    this.slices.update();
    this.views.update();
  }

  // Resolves when the volume is complete.
  settled(): Promise<void> {
    return this.volume.settled();
  }

  private updateVolume(now: Settings): void {
    const { info } = this.world();
    const { sampled } = this;
    const range = now.volume === "off" ? null : this.sampleRange();
    const scale = range && { map: now.sliceColors, ...scaleOf(now.level, now.windowWidth, now.samplesLog, range) };
    this.volume.update(now, info, sampled && scale && { info: sampled, scale, labels: this.labels });
  }

  // The labels that color the volume; null: none.
  get labels(): ShownLabels | null {
    const { info, list } = this.world();
    const now = this.sources.settings();
    if (!info || now.volume !== "on" || now.volumeLabels === "off" || this.sampled?.member?.label) return null;
    const { infos } = sceneOf(list, now, info);
    const all = now.surfaces.flatMap(({ color, visible: isVisible }, at) => (infos[at]?.member?.label ? [{ at, info: infos[at], color, isVisible }] : []));
    const labels = all.filter((one) => hasSameGrid(one.info, all[0].info));
    return labels.length > 0 ? { labels, isOnly: now.volumeLabels === "only" } : null;
  }

  close(): void {
    this.volume.update(this.sources.settings(), null, null);
    this.views.close();
  }

  // The dataset whose samples are shown.
  get sampled(): DatasetInfo | null {
    const { info, list } = this.world();
    return info && sampledOf(list, this.sources.settings(), info);
  }

  private rangeOf(info: DatasetInfo | null): LegendValues | null {
    return info && { ...rangeOf(this.world().list, info), valueUnit: info.valueUnit };
  }

  // Returns the range of samples on slices, the same at all times of a series.
  private sampleRange(): LegendValues | null {
    const { sampled } = this;
    const range = this.rangeOf(sampled);
    const isOneOfTimes = sampled !== null && timesOf(this.world().list, sampled).length > 1;
    if (!sampled) return null;
    const usual = (this.sources.settings().volume !== "off" && volumeWindow(sampled)) || defaultWindow(sampled);
    return range && (isOneOfTimes && !isCt(sampled) && !sampled.displayWindow ? range : { ...range, usual });
  }

  private showLegends(now: Settings): void {
    const hasSlices = slicePosition(now) !== null || (now.crop !== null && now.filled) || now.layout === "four" || now.volume !== "off";
    this.ofSamples.show(now, hasSlices ? this.sampleRange() : null, now.colorBy ? "samples" : "");
    const field = now.colorBy ? findByName(this.world().list, now.colorBy) : null;
    const by = this.rangeOf(field);
    this.ofField.show(now, by, field?.member?.field || now.colorBy);
    if (!by) return;
    const scale = scaleOf(now.fieldLevel, now.fieldWindow, now.fieldLog, by);
    this.sources.surfaces.field.setLook({ map: now.colors, ...scale }, by, now.noValueColor);
  }
}
