// Lengths, angles, areas and volumes, as numbers and text.

import { inDigits, withBound } from "../shared/quantities";
import { cross, dot, minus } from "../shared/vectors";
import type { MeasuredPlace } from "../state/settings";
import type { Vec3 } from "../stream/dataset";

export function distanceOf(a: Vec3, b: Vec3): number {
  return Math.hypot(...minus(a, b));
}

// Returns degrees, 0 to 180; null if a side has no length.
export function angleAt(corner: Vec3, a: Vec3, b: Vec3): number | null {
  const [u, v] = [minus(a, corner), minus(b, corner)];
  const [sine, cosine] = [Math.hypot(...cross(u, v)), dot(u, v)];
  return sine === 0 && cosine === 0 ? null : (Math.atan2(sine, cosine) * 180) / Math.PI;
}

// A distance bound gives no bound of the area's error.
export function areaText(area: number, { lengthUnit }: { lengthUnit: string }, isExact: boolean): string {
  return `${isExact ? "" : "about "}${inDigits(area, isExact ? 5 : 2)} ${lengthUnit || "unit"}²`;
}

// `bound`: the largest error of the volume; null: unknown. Above 1000 cubic millimeters also gives milliliters.
export function volumeText(volume: number, { lengthUnit }: { lengthUnit: string }, bound: number | null): string {
  const text = (factor: number) => (bound === null ? `about ${inDigits(volume * factor, 2)}` : withBound(volume * factor, bound * factor));
  const millilitres = lengthUnit === "mm" && volume >= 1000 ? ` = ${text(1e-3)} ml` : "";
  return `${text(1)} ${lengthUnit || "unit"}³${millilitres}`;
}

// `bound`: as for volumes.
export function lengthWithBound(length: number, { lengthUnit }: { lengthUnit: string }, bound: number | null): string {
  const text = bound === null ? `about ${inDigits(length, 2)}` : withBound(length, bound, 4);
  return `${text} ${lengthUnit || (text === "1" ? "unit" : "units")}`;
}

// The distance of two places, whose errors add up.
export function lengthBetween(from: MeasuredPlace, to: MeasuredPlace, info: { lengthUnit: string }): string {
  const bound = from.bound === null || to.bound === null ? null : from.bound + to.bound;
  return lengthWithBound(distanceOf(from.world, to.world), info, bound);
}
