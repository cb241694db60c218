// The slice in the scene and those that fill the crop's faces: converts settings to planes, queries the server and shows
// the replies.
import { type Box3, type Plane, type Ray, Vector3 } from "three";

import type { DatasetInfo } from "../protocol/messages";
import { clipPlanes, cropFaces, cropPlanes } from "../scene/crop";
import { cutNormal } from "../scene/cut_plane";
import { axisNormal, sliceGrid } from "../scene/slice_grid";
import { type SliceLook, SlicePlane } from "../scene/slice_plane";
import type { Stage } from "../scene/stage";
import type { ColorScale } from "../shared/color_maps";
import { airBelow } from "../shared/sample_window";
import type { ServedDatasets } from "../state/progress";
import type { Settings } from "../state/settings";
import { nearestSample, type Vec3, worldBox, worldSpacing } from "../stream/dataset";
import { suggestedIsovalue } from "../stream/request";
import { LatestSlice, type SliceSources } from "./latest_slice";

export class Slices {
  private readonly slice: ShownSlice;
  // The faces of the crop box, by number; created when they are first shown.
  private readonly faces = new Map<number, ShownSlice>();

  constructor(
    private readonly stage: Stage,
    private readonly sources: SliceSources,
    private readonly current: () => ShownSamples,
  ) {
    this.slice = new ShownSlice(stage, sources);
  }

  // Call when the settings, the dataset or the surfaces may have changed.
  update(): void {
    const { info, sampled, settings, rangeOfSamples } = this.current();
    const place = slicePosition(settings);
    const faces = info && settings.filled ? cropFaces(settings.crop, info) : [];
    for (const [number, face] of this.faces) if (!faces.some((one) => one.number === number)) face.hide();
    if (!info || !place) this.slice.hide();
    if (!info || !sampled || (!place && faces.length === 0)) return;
    const scale = { map: settings.sliceColors, ...scaleOf(settings.level, settings.windowWidth, settings.samplesLog, rangeOfSamples() ?? sampled) };
    const air = settings.transparentAir ? airBelow(sampled, scale.low) : -Infinity;
    // Only the first surface's own samples show what is inside of it.
    const filling = { ...scale, above: sampled.name === info.name ? leastIsovalue(settings, info) : air };
    const crop = cropPlanes(settings.crop);
    if (place?.isFilling) this.slice.show(info, sampled, place, filling, crop);
    else if (place) this.slice.show(info, sampled, throughSamples(place, info, sampled), { ...scale, above: air }, crop);
    const all = clipPlanes(settings, info);
    for (const face of faces) {
      const own = all.length - crop.length + face.number;
      const shown = this.faces.get(face.number) ?? new ShownSlice(this.stage, this.sources);
      this.faces.set(face.number, shown);
      shown.show(
        info,
        sampled,
        face,
        filling,
        all.filter((_, at) => at !== own),
      );
    }
  }

  // Returns the nearest place where a ray hits the slice or a face; null: nowhere.
  hit(ray: Ray): Vec3 | null {
    const hits = [this.slice, ...this.faces.values()].map(({ plane }) => plane.hit(ray)).filter((place) => place !== null);
    const distance = (place: Vec3) => ray.origin.distanceToSquared(new Vector3(...place));
    return hits.reduce<Vec3 | null>((nearest, place) => (nearest && distance(nearest) <= distance(place) ? nearest : place), null);
  }
}

// A plane with the samples and outlines that were requested last.
class ShownSlice {
  readonly plane: SlicePlane;
  private readonly latest: LatestSlice;

  constructor(stage: Stage, sources: SliceSources) {
    this.plane = new SlicePlane(stage.scene, () => stage.invalidate());
    this.latest = new LatestSlice(sources, {
      slice: (slice) => this.plane.show(slice),
      lines: (lines) => this.plane.showLines(lines),
    });
  }

  hide(): void {
    this.latest.request(null);
  }

  // Shows the samples of a dataset on a plane through the box of another one, inside the half-spaces.
  show(info: DatasetInfo, sampled: DatasetInfo, { normal, at }: { normal: Vec3; at: number }, look: SliceLook, clip: readonly Plane[]): void {
    this.plane.setLook(look, clip);
    const { low, high } = worldBox(info);
    this.latest.request({
      key: `${sampled.name} ${sampled.contentId} ${normal} ${at}`,
      dataset: sampled.name,
      grid: sliceGrid(low, high, normal, at, worldSpacing(sampled)),
    });
  }
}

export interface ShownSamples {
  info: DatasetInfo | null; // The dataset of the first surface.
  sampled: DatasetInfo | null; // The dataset of the samples; null exactly if `info` is.
  settings: Settings;
  rangeOfSamples: () => ValueRange | null; // Computes the range over all times of a series, which takes time.
}

// `usual`: the default window; absent: all values.
export type ValueRange = Pick<DatasetInfo, "min" | "max"> & { usual?: { level: number; width: number } };

// Returns the settings without slices and filled cuts where the server permits surfaces only.
export function permittedSettings(settings: Settings, { permitsSamples }: ServedDatasets): Settings {
  return permitsSamples ? settings : { ...settings, slice: "off", layout: "surface", filled: false, volume: "off" };
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

// Returns the plane moved to the nearest samples of a dataset, where it needs no interpolation.
function throughSamples({ normal, at }: Place, info: DatasetInfo, sampled: DatasetInfo): { normal: Vec3; at: number } {
  const { low, high } = worldBox(info);
  const axis = normal.indexOf(1);
  const extent = high[axis] - low[axis];
  return { normal, at: extent > 0 ? (nearestSample(sampled, axis, low[axis] + at * extent) - low[axis]) / extent : at };
}

// Returns the values of the first and last color: as set, else the default window, else the data's range.
export function windowOf(level: number | null, windowWidth: number | null, { min, max, usual }: ValueRange): { low: number; high: number } {
  const width = windowWidth ?? usual?.width ?? max - min;
  const middle = level ?? usual?.level ?? (min + max) / 2;
  return { low: middle - width / 2, high: middle + width / 2 };
}

// Returns the same for a scale that may be logarithmic. If values are not positive, it begins at a thousandth of the
// last color's value; if that is not positive either, it is linear.
export function scaleOf(level: number | null, windowWidth: number | null, wantsLog: boolean, range: ValueRange): Omit<ColorScale, "map"> {
  const { low, high } = windowOf(level, windowWidth, range);
  if (!wantsLog || high <= 0) return { low, high, isLog: false };
  const least = range.min > 0 && range.min < high ? range.min : high / 1000;
  return { low: low > 0 && low < high ? low : least, high, isLog: true };
}

// Returns the change that moves planes of samples which miss a box to its center.
export function planesThrough(box: Box3, { slice, sliceAt, layout, cross }: Settings, info: DatasetInfo): Partial<Settings> {
  const data = worldBox(info);
  const center = box.getCenter(new Vector3()).toArray();
  const isMissed = (at: number, axis: number) => at < box.min.getComponent(axis) || at > box.max.getComponent(axis);
  const changes: Partial<Settings> = {};
  if (layout === "four" && crossOf(cross, info).some(isMissed)) changes.cross = center.map((at, axis) => nearestSample(info, axis, at)) as Vec3;
  const axis = "xyz".indexOf(slice);
  const extent = data.high[axis] - data.low[axis];
  if (axis >= 0 && extent > 0 && isMissed(data.low[axis] + sliceAt * extent, axis)) changes.sliceAt = (center[axis] - data.low[axis]) / extent;
  return box.isEmpty() ? {} : changes;
}

// Returns the place clamped to the data; the sample at their center by default.
export function crossOf(cross: Settings["cross"], info: DatasetInfo): Vec3 {
  const { low, high } = worldBox(info);
  return low.map((from, axis) => {
    const at = cross?.[axis] ?? nearestSample(info, axis, (from + high[axis]) / 2);
    return Math.min(high[axis], Math.max(from, at));
  }) as Vec3;
}

function leastIsovalue(settings: Settings, info: DatasetInfo): number {
  const shown = settings.surfaces.filter(({ visible }) => visible);
  return Math.min(...shown.map(({ isovalue }) => isovalue ?? suggestedIsovalue(info)));
}
