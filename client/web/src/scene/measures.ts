// Lengths, angles, areas and volumes, as numbers and text.

import { inDigits, withBound } from "../shared/quantities";
import type { MeasuredPlace } from "../state/settings";
import type { Vec3 } from "../stream/dataset";

export function distanceOf(a: Vec3, b: Vec3): number {
  return Math.hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}

// Returns degrees, 0 to 180; null if a side has no length.
export function angleAt(corner: Vec3, a: Vec3, b: Vec3): number | null {
  const u = a.map((value, axis) => value - corner[axis]);
  const v = b.map((value, axis) => value - corner[axis]);
  const cross = Math.hypot(u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]);
  const dot = u[0] * v[0] + u[1] * v[1] + u[2] * v[2];
  return cross === 0 && dot === 0 ? null : (Math.atan2(cross, dot) * 180) / Math.PI;
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
