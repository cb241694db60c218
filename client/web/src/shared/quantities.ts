// Formats numbers for display.
import { resolutionWithin, rounded } from "./numbers";

// 1234567 -> "1 234 567", with thin no-break spaces.
export function grouped(count: number): string {
  return String(Math.round(count)).replace(/\B(?=(\d{3})+$)/g, "\u202f");
}

// 1234567 -> "1.2 million triangles".
export function inTriangles(count: number): string {
  if (count >= 999_500) return `${inDigits(count / 1e6, count < 9.95e6 ? 2 : 3)} million triangles`;
  return `${grouped(Number(count.toPrecision(2)))} triangles`;
}

// The range of an estimate, as in common/request/estimate_range.hpp.
export const minEstimateFactor = 0.75;
export const maxEstimateFactor = 1.5;

// 15000 -> "11 000 to 23 000 triangles". `budget`: the largest allowed number of triangles; 0: unlimited.
export function inTriangleRange(estimate: number, budget = 0): string {
  const maxTriangles = maxEstimateFactor * estimate;
  const isLimited = budget > 0 && budget < maxTriangles;
  const to = isLimited ? budget : inTwoDigits(maxTriangles, Math.ceil);
  const from = Math.min(to, inTwoDigits(minEstimateFactor * estimate, Math.floor));
  if (from === to) return inTriangles(to);
  if (from >= 999_500) return `${inDigits(from / 1e6, 2)} to ${inTriangles(to)}`;
  return `${grouped(from)} to ${inTriangles(to)}`;
}

function inTwoDigits(count: number, rounded: (value: number) => number): number {
  const unit = 10 ** Math.max(0, Math.floor(Math.log10(Math.max(1, count))) - 1);
  return rounded(count / unit) * unit;
}

export function inBytes(bytes: number): string {
  if (bytes < 1000) return `${Math.round(bytes)} B`;
  const units = ["KiB", "MiB", "GiB"];
  let value = bytes / 1024;
  let unit = 0;
  while (value >= 1000 && unit < units.length - 1) {
    value /= 1024;
    ++unit;
  }
  return `${value < 10 ? value.toFixed(1) : Math.round(value)} ${units[unit]}`;
}

export function inSeconds(milliseconds: number): string {
  return milliseconds < 995 ? `${Math.max(1, Math.round(milliseconds))} ms` : `${(milliseconds / 1000).toFixed(milliseconds < 9950 ? 2 : 1)} s`;
}

// Formats a value with at most `digits` significant digits.
export function inDigits(value: number, digits = 4): string {
  return String(Number(value.toPrecision(digits)));
}

// Rounds a value among others that span `span`.
export function roundedWithin(value: number, span: number): number {
  return rounded(value, resolutionWithin(value, span));
}

// "1 voxel", "2 voxels".
export function counted(value: number, noun: string, digits = 3): string {
  return `${inDigits(value, digits)} ${noun}${value === 1 ? "" : "s"}`;
}

// "12.34 ± 0.05": the significant digits of a value with an error of at most `bound`; at most `maxDigits` digits if exact.
export function withBound(value: number, bound: number, maxDigits = 5): string {
  if (!(bound > 0)) return inDigits(value, maxDigits);
  const decade = Math.floor(Math.log10(bound));
  const step = 10 ** (bound / 10 ** decade < 3 ? decade - 1 : decade); // One or two digits of the bound.
  const decimals = Math.max(0, -Math.round(Math.log10(step)));
  const rounded = Math.round(value / step) * step;
  return `${rounded.toFixed(decimals)} ± ${(Math.ceil((bound + Math.abs(rounded - value)) / step - 1e-9) * step).toFixed(decimals)}`;
}
