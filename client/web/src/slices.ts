// The slice in the scene: converts settings to a plane, queries the server and shows the reply.
import type { DatasetInfo } from "./protocol/messages";
import type { ColorScale } from "./shared/color_maps";
import { airBelow } from "./shared/sample_window";
import { axisNormal, cutNormal } from "./scene/cut_plane";
import { LatestSlice, type SliceSources } from "./latest_slice";
import { sliceGrid } from "./scene/slice_grid";
import { SlicePlane } from "./scene/slice_plane";
import type { Stage } from "./scene/stage";
import type { ServedDatasets } from "./state/progress";
import type { Settings } from "./state/settings";
import { surfacesOf } from "./state/surfaces";
import { type Vec3, voxelLength, worldBox } from "./stream/dataset";
import { suggestedIsovalue } from "./stream/request";

export class Slices {
  readonly plane: SlicePlane;
  private readonly latest: LatestSlice;

  constructor(
    stage: Stage,
    sources: SliceSources,
    private readonly current: () => ShownSamples,
  ) {
    this.plane = new SlicePlane(stage.scene, () => stage.invalidate());
    this.latest = new LatestSlice(sources, {
      slice: (slice) => this.plane.show(slice),
      lines: (lines) => this.plane.showLines(lines),
    });
  }

  // Call when the settings, the dataset or the surfaces may have changed.
  update(): void {
    const { info, settings, rangeOfSamples } = this.current();
    const where = slicePosition(settings);
    if (!info || !where) return this.latest.request(null);
    const range = rangeOfSamples();
    const scale = scaleOf(settings.level, settings.windowWidth, settings.samplesLog, range ?? info);
    const air = settings.transparentAir ? airBelow(info, scale.low) : -Infinity;
    this.plane.setLook({ map: settings.sliceColors, ...scale, above: where.isFilling ? leastIsovalue(settings, info) : air });
    const { low, high } = worldBox(info);
    this.latest.request({
      key: `${info.name} ${info.contentId} ${where.normal} ${where.at}`,
      dataset: info.name,
      grid: () => sliceGrid(low, high, where.normal, where.at, voxelLength(info)),
    });
  }
}

export interface ShownSamples {
  info: DatasetInfo | null;
  settings: Settings;
  rangeOfSamples: () => ValueRange | null; // Of all times of a series, which takes a look at each.
}

// `usual`: the default window; absent: all values.
export type ValueRange = Pick<DatasetInfo, "min" | "max"> & { usual?: { level: number; width: number } };

// Returns the settings without slices and filled cuts where the server permits surfaces only.
export function permittedSettings(settings: Settings, { permitsSamples }: ServedDatasets): Settings {
  return permitsSamples ? settings : { ...settings, slice: "off", layout: "surface", filled: false };
}

interface Place {
  normal: Vec3; // A unit vector.
  at: number; // 0 to 1 along it.
  isFilling: boolean; // Shows only the inside of the surfaces.
}

// Returns the requested slice, or else the one that fills the cut.
export function slicePosition(settings: Settings): Place | null {
  const { slice, sliceAt, clipAt, filled } = settings;
  if (slice !== "off") return { normal: axisNormal(slice), at: sliceAt, isFilling: false };
  const normal = cutNormal(settings);
  return normal && filled ? { normal, at: clipAt, isFilling: true } : null;
}

// Returns the values of the first and last color: as set, else the default window, else the data's range.
export function windowOf(
  level: number | null, windowWidth: number | null, { min, max, usual }: ValueRange,
): { low: number; high: number } {
  const width = windowWidth ?? usual?.width ?? max - min;
  const middle = level ?? usual?.level ?? (min + max) / 2;
  return { low: middle - width / 2, high: middle + width / 2 };
}

// Returns the same for a scale that may be logarithmic. If values are not positive, it begins at a thousandth of the
// last color's value; if that is not positive either, it is linear.
export function scaleOf(
  level: number | null, windowWidth: number | null, wantsLog: boolean, range: ValueRange,
): Omit<ColorScale, "map"> {
  const { low, high } = windowOf(level, windowWidth, range);
  if (!wantsLog || high <= 0) return { low, high, isLog: false };
  const least = range.min > 0 && range.min < high ? range.min : high / 1000;
  return { low: low > 0 && low < high ? low : least, high, isLog: true };
}

function leastIsovalue(settings: Settings, info: DatasetInfo): number {
  const shown = surfacesOf(settings).filter(({ visible }) => visible);
  return Math.min(...shown.map(({ isovalue }) => isovalue ?? suggestedIsovalue(info)));
}
