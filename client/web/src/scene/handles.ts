// Draggable handles in the scene: for the region, the crop and the clip plane.
import type { DatasetInfo } from "../protocol/messages";
import type { Crop, Settings } from "../state/settings";
import { CutHandles } from "./cut_handles";
import { RegionHandles } from "./region_handles";
import type { Stage } from "./stage";

export class Handles {
  private readonly region: RegionHandles;
  private readonly cropBox: RegionHandles;
  private readonly cut: CutHandles;
  private crop: Crop | null = null; // The shown crop box.

  constructor(stage: Stage, canvas: HTMLCanvasElement, changed: (changes: Partial<Settings>, isDragging: boolean) => void) {
    this.region = new RegionHandles(stage, canvas, (region, isDragging) => changed({ region }, isDragging));
    this.cropBox = new RegionHandles(
      stage,
      canvas,
      (region, isDragging) => {
        if (region.kind === "box") changed({ crop: { low: region.low, high: region.high } }, isDragging);
      },
      false,
    );
    this.cut = new CutHandles(stage, canvas, changed);
  }

  get isGrabbed(): boolean {
    return this.region.isGrabbed || this.cropBox.isGrabbed || this.cut.isGrabbed;
  }

  show(settings: Settings, info: DatasetInfo | null): void {
    this.region.show(settings.region);
    if (settings.crop !== this.crop) this.cropBox.show(settings.crop && { kind: "box", ...settings.crop, error: 0 });
    this.crop = settings.crop;
    this.cut.show(settings, info);
  }
}
