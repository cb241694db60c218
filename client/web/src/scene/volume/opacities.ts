// The opacity of a volume by value: a polyline over the values, and the usual ones for kinds of data.
import { isCt, sampleWindows, type WindowedDataset } from "../../shared/sample_window";
import type { OpacityPoint, Settings } from "../../state/settings";

export const tableLength = 1024;
const mostOpaque = 0.9999; // Its logarithm is finite.

// Returns the opacity of a layer that is one voxel thick; constant before the first and after the last point. At a step,
// two points with one value, it is that of the second.
export function opacityAt(points: readonly OpacityPoint[], value: number): number {
  const next = points.findIndex((point) => point.value > value);
  if (next === 0) return points[0].opacity;
  if (next < 0) return points[points.length - 1].opacity;
  const [from, to] = [points[next - 1], points[next]];
  return from.opacity + ((value - from.value) / (to.value - from.value)) * (to.opacity - from.opacity);
}

// Returns pairs at equal distances from the first point's value to the last one's: the opacity as extinction per voxel, and
// the integral of that up to there, over all of the distance as 1. A step at the first value comes after it.
export function extinctionTable(points: readonly OpacityPoint[]): Float32Array<ArrayBuffer> {
  const [first, last] = [points[0].value, points[points.length - 1].value];
  const table = new Float32Array(2 * tableLength);
  let sum = 0;
  let before = 0;
  for (let i = 0; i < tableLength; ++i) {
    const opacity = i === 0 ? points[0].opacity : opacityAt(points, first + (i / (tableLength - 1)) * (last - first));
    const extinction = -Math.log(1 - Math.min(opacity, mostOpaque));
    if (i > 0) sum += (0.5 * (before + extinction)) / (tableLength - 1);
    table.set([extinction, sum], 2 * i);
    before = extinction;
  }
  return table;
}

// Whether a value from `low` to `high` is visible.
export function isVisible(points: readonly OpacityPoint[], low: number, high: number): boolean {
  const isInside = ({ value, opacity }: OpacityPoint) => value >= low && value <= high && opacity > 0;
  return high >= low && (opacityAt(points, low) > 0 || opacityAt(points, high) > 0 || points.some(isInside));
}

export interface VolumePreset {
  name: string;
  tip: string;
  changes: Pick<Settings, "volume" | "opacities" | "level" | "windowWidth">;
}

// The first is the default.
export function volumePresets(info: WindowedDataset): VolumePreset[] {
  const preset = (name: string, tip: string, opacities: OpacityPoint[], window: { level: number; width: number } | null): VolumePreset => ({
    name,
    tip,
    changes: { volume: "on", opacities, level: window?.level ?? null, windowWidth: window?.width ?? null },
  });
  const windows = sampleWindows(info);
  const maximum: VolumePreset = {
    name: "Maximum",
    tip: "The largest value behind each pixel: maximum intensity projection.",
    changes: { volume: "maximum", opacities: [], level: null, windowWidth: null },
  };
  if (isCt(info)) {
    const bone = polyline([150, 0], [350, 0.08], [1200, 0.5]);
    const soft = polyline([-150, 0], [-20, 0.015], [80, 0.04], [250, 0.06], [1000, 0.4]);
    return [
      preset("CT bone", "Bone and contrast medium, without what is around.", bone, null),
      preset("CT soft tissue", "Skin, fat and organs, with bone inside.", soft, { level: 150, width: 900 }),
      maximum,
    ];
  }
  const { level, width } = windows.find(({ name }) => name === "Most values") ?? windows[windows.length - 1];
  const at = (share: number) => level + (share - 0.5) * width;
  return [
    preset("MR", "Faint tissue that covers a range of values.", polyline([at(0.1), 0], [at(0.4), 0.01], [at(0.9), 0.12]), null),
    preset("Fluorescence", "Bright structures in the dark.", polyline([at(0.3), 0], [at(1), 0.5]), null),
    maximum,
  ];
}

// Returns the default window of a volume's colors: of computed tomography that of bone, since others have one color for all
// of it; null: that of slices.
export function volumeWindow(info: WindowedDataset): { level: number; width: number } | null {
  return isCt(info) ? sampleWindows(info).find(({ name }) => name === "Bone")! : null;
}

// Returns the points to show: as set, else the default's.
export function opacitiesOf({ opacities }: Pick<Settings, "opacities">, info: WindowedDataset): readonly OpacityPoint[] {
  return opacities.length > 0 ? opacities : volumePresets(info)[0].changes.opacities;
}

function polyline(...points: [number, number][]): OpacityPoint[] {
  return points.map(([value, opacity]) => ({ value, opacity }));
}
