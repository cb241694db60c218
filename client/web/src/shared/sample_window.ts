// The default range of a dataset's sample colors, and which samples are air.
//
// For computed tomography these are known: in Hounsfield units air is -1000 and water 0. For other data the source's own
// display window or else the histogram decides: a peak at the low end that holds a large share of all samples is background, and the colors span most of the
// other samples.
import type { DatasetInfo } from "../protocol/messages";
import { rounded } from "./numbers";

export interface SampleWindow {
  name: string;
  level: number; // The center of the range.
  width: number; // The length of the range.
}

export type WindowedDataset = Pick<DatasetInfo, "min" | "max" | "valueUnit" | "histogram"> & Partial<Pick<DatasetInfo, "displayWindow">>;

// The usual windows of radiology, in Hounsfield units.
const ctWindows: readonly SampleWindow[] = [
  { name: "Soft tissue", level: 40, width: 400 },
  { name: "Bone", level: 500, width: 2000 },
  { name: "Lung", level: -600, width: 1500 },
  { name: "Brain", level: 40, width: 80 },
];
const ctAir = -500;
const tissues = [
  { from: 2000, name: "enamel, metal" },
  { from: 130, name: "bone" },
  { from: -150, name: "soft tissue" },
  { from: -500, name: "skin" },
  { from: -Infinity, name: "" },
];
export const mainTissues: readonly string[] = ["skin", "bone"]; // The surfaces viewed most.
const spread = { low: 0.01, high: 0.995 }; // Shares of the samples that are not background.
// A background's peak holds at least this share of all samples, within this share of the range from its low end.
const backgroundShare = 0.15;
const mostOfAPlane = 0.9;

// Also recognizes CT files without a unit: few other data range from air to bone.
export function isCt({ min, max, valueUnit }: WindowedDataset): boolean {
  return valueUnit === "HU" || (valueUnit === "" && min >= -3100 && min <= -900 && max >= 700 && max <= 40000);
}

export function sampleWindows(info: WindowedDataset): readonly SampleWindow[] {
  const all = { name: "All values", level: (info.min + info.max) / 2, width: info.max - info.min };
  const own = sourceWindow(info);
  const usual = isCt(info) ? ctWindows : [{ name: "Most values", ...windowOfMost(info) }];
  return [...(own ? [{ name: "From the file", ...own }] : []), ...usual, all];
}

// Returns the tissue at whose boundary such an isovalue lies; empty: unknown.
export function tissueAtValue(isovalue: number, info: WindowedDataset): string {
  return isCt(info) ? tissues.find(({ from }) => isovalue >= from)!.name : "";
}

// Returns the default window.
export function defaultWindow(info: WindowedDataset): Range {
  return sourceWindow(info) ?? (isCt(info) ? ctWindows[0] : windowOfMost(info));
}

type Range = Pick<SampleWindow, "level" | "width">;

function sourceWindow({ displayWindow }: WindowedDataset): Range | null {
  return displayWindow ? { level: (displayWindow.low + displayWindow.high) / 2, width: displayWindow.high - displayWindow.low } : null;
}

function windowOfMost(info: WindowedDataset): Range {
  const [low, high] = [percentile(info, spread.low), percentile(info, spread.high)];
  if (!(high > low)) return { level: (info.min + info.max) / 2, width: info.max - info.min };
  const resolution = (high - low) / 1e5;
  return { level: rounded((low + high) / 2, resolution), width: rounded(high - low, resolution) };
}

// Samples below this value are air or background; -Infinity: none are, or so many (in fluorescence) that planes without
// them could hardly be seen. A CT window that begins lower, such as that of
// lungs, shows them: nothing within it is air.
export function airBelow(info: WindowedDataset, windowLow: number): number {
  if (isCt(info)) return Math.min(ctAir, windowLow);
  const bins = backgroundBins(info);
  const counts = info.histogram?.counts.map(Number) ?? [];
  return bins === 0 || sumOf(counts.slice(0, bins)) > mostOfAPlane * sumOf(counts) ? -Infinity : endOf(info, bins);
}

// Returns the value below which a share of the samples lies, without the background.
function percentile(info: WindowedDataset, share: number): number {
  const counts = info.histogram?.counts.map(Number) ?? [];
  const first = backgroundBins(info);
  const total = sumOf(counts.slice(first));
  let below = 0;
  for (let bin = first; bin < counts.length; ++bin) {
    const part = share * total - below;
    if (part <= counts[bin] && counts[bin] > 0) return endOf(info, bin) + (part / counts[bin]) * (endOf(info, bin + 1) - endOf(info, bin));
    below += counts[bin];
  }
  return share < 0.5 ? info.min : info.max;
}

// Returns the number of leading bins that are background: up to the minimum after the peak; 0 without such a peak.
function backgroundBins({ histogram, min, max }: WindowedDataset): number {
  const counts = histogram?.counts.map(Number) ?? [];
  const total = sumOf(counts);
  const reach = Math.ceil(backgroundShare * counts.length);
  if (!(max > min) || counts.length < 8) return 0;
  const peak = counts.slice(0, reach).reduce((best, count, bin) => (count > counts[best] ? bin : best), 0);
  if (counts[peak] < Math.max(...counts)) return 0;
  let end = peak + 1;
  while (end < reach && counts[end] < counts[end - 1]) ++end;
  const background = sumOf(counts.slice(0, end));
  return background >= backgroundShare * total && background < total ? end : 0;
}

function sumOf(counts: readonly number[]): number {
  return counts.reduce((sum, count) => sum + count, 0);
}

// Returns where a bin begins.
function endOf({ histogram, min, max }: WindowedDataset, bin: number): number {
  const { low, high, counts } = histogram ?? { low: min, high: max, counts: [0] };
  return low + (bin / counts.length) * (high - low);
}
