// The shape of draggable handles in the scene: for the region and the clip plane.
import type { DatasetInfo } from "../protocol/messages";
import type { Settings } from "../state/settings";
import { CutHandles } from "./cut_handles";
import { RegionHandles } from "./region_handles";
import type { Stage } from "./stage";

export class Handles {
  private readonly region: RegionHandles;
  private readonly cut: CutHandles;

  constructor(stage: Stage, canvas: HTMLCanvasElement, changed: (changes: Partial<Settings>, isDragging: boolean) => void) {
    this.region = new RegionHandles(stage, canvas, (region, isDragging) => changed({ region }, isDragging));
    this.cut = new CutHandles(stage, canvas, changed);
  }

  get isGrabbed(): boolean {
    return this.region.isGrabbed || this.cut.isGrabbed;
  }

  show(settings: Settings, info: DatasetInfo | null): void {
    this.region.show(settings.region);
    this.cut.show(settings, info);
  }
}
