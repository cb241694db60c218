// Lengths, angles, areas and volumes, as numbers and in words.
import type { Vec3 } from "../stream/dataset";
import { inDigits } from "../shared/quantities";

export function distanceOf(a: Vec3, b: Vec3): number {
  return Math.hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}

// In degrees, 0 to 180; null where a side has no length.
export function angleAt(corner: Vec3, a: Vec3, b: Vec3): number | null {
  const u = a.map((value, axis) => value - corner[axis]);
  const v = b.map((value, axis) => value - corner[axis]);
  const cross = Math.hypot(u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]);
  const dot = u[0] * v[0] + u[1] * v[1] + u[2] * v[2];
  return cross === 0 && dot === 0 ? null : (Math.atan2(cross, dot) * 180) / Math.PI;
}

export function areaText(area: number, { lengthUnit }: { lengthUnit: string }): string {
  return `${inDigits(area, 5)} ${lengthUnit || "unit"}²`;
}

// Cubic millimetres of bodies are many: above a thousand they are told as millilitres as well.
export function volumeText(volume: number, { lengthUnit }: { lengthUnit: string }): string {
  const millilitres = lengthUnit === "mm" && volume >= 1000 ? ` = ${inDigits(volume / 1000, 5)} ml` : "";
  return `${inDigits(volume, 5)} ${lengthUnit || "unit"}³${millilitres}`;
}
