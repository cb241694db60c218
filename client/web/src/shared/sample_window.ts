// The default range of a dataset's sample colors, and which samples are air.
//
// Values of computed tomography are known: Hounsfield units, where air is -1000 and water 0. Elsewhere the histogram decides:
// a peak at its low end that holds a large share of all samples is the background, and the colors span what most of the other
// samples have.
import type { DatasetInfo } from "../protocol/messages";

export interface SampleWindow {
  name: string;
  level: number; // In the middle of the colors;
  width: number; // so many values they span.
}

export type WindowedDataset = Pick<DatasetInfo, "min" | "max" | "valueUnit" | "histogram">;

// As radiologists use them, in Hounsfield units.
const ctWindows: readonly SampleWindow[] = [
  { name: "Soft tissue", level: 40, width: 400 },
  { name: "Bone", level: 500, width: 2000 },
  { name: "Lung", level: -600, width: 1500 },
  { name: "Brain", level: 40, width: 80 },
];
const ctAir = -500;
const tissues = [
  { from: 2000, name: "enamel, metal" }, { from: 130, name: "bone" }, { from: -150, name: "soft tissue" },
  { from: -500, name: "skin" }, { from: -Infinity, name: "" },
];
export const mainTissues: readonly string[] = ["skin", "bone"]; // Surfaces of these are looked at most.
const spread = { low: 0.01, high: 0.995 }; // Shares of the samples that are not background.
const backgroundShare = 0.15; // The share of all samples, and of the range from its low end, of a background's peak.

// Also where the file does not name the unit: samples from air to bone are hardly anything else.
export function isCt({ min, max, valueUnit }: WindowedDataset): boolean {
  return valueUnit === "HU" || (valueUnit === "" && min >= -3100 && min <= -900 && max >= 700 && max <= 40000);
}

export function sampleWindows(info: WindowedDataset): readonly SampleWindow[] {
  const all = { name: "All values", level: (info.min + info.max) / 2, width: info.max - info.min };
  return isCt(info) ? [...ctWindows, all] : [{ name: "Most values", ...defaultWindow(info) }, all];
}

// What a surface at such a value shows of a body; empty: not known.
export function tissueAtValue(isovalue: number, info: WindowedDataset): string {
  return isCt(info) ? tissues.find(({ from }) => isovalue >= from)!.name : "";
}

// The default window.
export function defaultWindow(info: WindowedDataset): { level: number; width: number } {
  if (isCt(info)) return ctWindows[0];
  const [low, high] = [percentile(info, spread.low), percentile(info, spread.high)];
  if (!(high > low)) return { level: (info.min + info.max) / 2, width: info.max - info.min };
  return { level: Number(((low + high) / 2).toPrecision(6)), width: Number((high - low).toPrecision(6)) };
}

// Samples below this value are air, or the background; -Infinity: none are. A window of computed tomography that begins lower,
// as that of lungs does, is about what is there: nothing within it is air.
export function airBelow(info: WindowedDataset, windowLow: number): number {
  if (isCt(info)) return Math.min(ctAir, windowLow);
  const bins = backgroundBins(info);
  return bins === 0 ? -Infinity : endOf(info, bins);
}

// The value below which a share of the samples lies, without the background.
function percentile(info: WindowedDataset, share: number): number {
  const counts = info.histogram?.counts.map(Number) ?? [];
  const first = backgroundBins(info);
  const total = counts.slice(first).reduce((sum, count) => sum + count, 0);
  let below = 0;
  for (let bin = first; bin < counts.length; ++bin) {
    const part = share * total - below;
    if (part <= counts[bin] && counts[bin] > 0) return endOf(info, bin) + (part / counts[bin]) * (endOf(info, bin + 1) - endOf(info, bin));
    below += counts[bin];
  }
  return share < 0.5 ? info.min : info.max;
}

// How many of the first bins are the background: those up to the least one after the peak, where there is such a peak.
function backgroundBins({ histogram, min, max }: WindowedDataset): number {
  const counts = histogram?.counts.map(Number) ?? [];
  const total = counts.reduce((sum, count) => sum + count, 0);
  const reach = Math.ceil(backgroundShare * counts.length);
  if (!(max > min) || counts.length < 8) return 0;
  const peak = counts.slice(0, reach).reduce((best, count, bin) => (count > counts[best] ? bin : best), 0);
  if (counts[peak] < Math.max(...counts)) return 0;
  let end = peak + 1;
  while (end < reach && counts[end] < counts[end - 1]) ++end;
  const held = counts.slice(0, end).reduce((sum, count) => sum + count, 0);
  return held >= backgroundShare * total && held < total ? end : 0;
}

// Where a bin begins.
function endOf({ histogram, min, max }: WindowedDataset, bin: number): number {
  const { low, high, counts } = histogram ?? { low: min, high: max, counts: [0] };
  return low + (bin / counts.length) * (high - low);
}
