// The clip plane: perpendicular to a world axis, or oblique with any normal.
import * as THREE from "three";

import type { DatasetInfo } from "../protocol/messages";
import { dot } from "../shared/vectors";
import type { Cut, Settings } from "../state/settings";
import { type Vec3, worldBox } from "../stream/dataset";
import { axisNormal, extentAlong } from "./slice_grid";

type CutSettings = Pick<Settings, "clip" | "clipAt" | "clipFlipped" | "clipNormal">;

// Returns a unit vector in the direction in which `clipAt` grows; null: no clipping.
export function cutNormal({ clip, clipNormal }: Pick<Settings, "clip" | "clipNormal">): Vec3 | null {
  if (clip === "off") return null;
  if (clip === "oblique") return clipNormal ?? [0, 1, 0];
  return axisNormal(clip);
}

// Returns the half-space that remains; null: no clipping.
export function clipPlane(settings: CutSettings, info: DatasetInfo | null): THREE.Plane | null {
  const normal = cutNormal(settings);
  if (!normal || !info) return null;
  const sign = settings.clipFlipped ? -1 : 1;
  return new THREE.Plane(new THREE.Vector3(...normal).multiplyScalar(sign), -sign * distanceOf(normal, settings.clipAt, info));
}

export function areSamePlanes(some: readonly THREE.Plane[], others: readonly THREE.Plane[]): boolean {
  return some.length === others.length && some.every((plane, at) => plane.equals(others[at]));
}

// Moves the plane along its normal to a place in the world, within the data.
export function movedCut(normal: Vec3, place: Vec3, info: DatasetInfo): { clipAt: number } {
  const { low, high } = worldBox(info);
  const { from, to } = extentAlong(low, high, normal);
  const share = to > from ? (dot(place, normal) - from) / (to - from) : 0.5;
  return { clipAt: Math.min(1, Math.max(0, share)) };
}

// Rotates the plane around a place in the world; the remaining side turns with it.
export function rotatedCut(normal: Vec3, place: Vec3, isFlipped: boolean, info: DatasetInfo): Partial<Settings> {
  return { clip: "oblique", clipNormal: normal, clipFlipped: isFlipped, ...movedCut(normal, place, info) };
}

// Returns additional changes when clipping begins, unless specified: the part behind the plane remains, so that the cut
// is visible; an oblique plane without a normal faces the camera.
export function initialCut(
  change: Partial<Settings>,
  before: Settings,
  { eye, target }: { eye: readonly number[]; target: readonly number[] },
): Partial<Settings> {
  const clip: Cut = change.clip ?? "off";
  if (clip === "off") return {};
  const ahead = new THREE.Vector3(...target).sub(new THREE.Vector3(...eye)).normalize();
  const clipNormal = change.clipNormal === undefined ? before.clipNormal : change.clipNormal;
  if (clip === "oblique" && !clipNormal) return { clipNormal: ahead.toArray().map(inMillionths) as Vec3, clipFlipped: false };
  if (clip === before.clip || change.clipFlipped !== undefined) return {};
  return { clipFlipped: ahead.dot(new THREE.Vector3(...cutNormal({ clip, clipNormal })!)) < 0 };
}

// Snaps to axes where the difference is invisible.
function inMillionths(part: number): number {
  return Math.round(part * 1e6) / 1e6 + 0; // Converts -0 to 0.
}

function distanceOf(normal: Vec3, at: number, info: DatasetInfo): number {
  const { low, high } = worldBox(info);
  const { from, to } = extentAlong(low, high, normal);
  return from + at * (to - from);
}
