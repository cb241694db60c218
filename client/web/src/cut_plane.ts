// The plane that cuts surfaces open, as the settings have it.
import * as THREE from "three";

import type { DatasetInfo } from "./protocol/messages";
import type { Settings } from "./state/settings";
import { worldBox } from "./stream/dataset";

// The half-space that the cut leaves; null: nothing is cut.
export function clipPlane({ clip, clipAt, clipFlipped }: Settings, info: DatasetInfo | null): THREE.Plane | null {
  if (clip === "off" || !info) return null;
  const axis = "xyz".indexOf(clip);
  const { low, high } = worldBox(info);
  const at = low[axis] + clipAt * (high[axis] - low[axis]);
  const sign = clipFlipped ? -1 : 1;
  return new THREE.Plane(new THREE.Vector3().setComponent(axis, sign), -sign * at);
}

// Whether the eye lies farther along an axis than what it looks at: a cut then leaves what is behind it, and shows its face.
export function isSeenFromAbove({ eye, target }: { eye: readonly number[]; target: readonly number[] }, clip: Settings["clip"]): boolean {
  const axis = "xyz".indexOf(clip);
  return eye[axis] > target[axis];
}

// Whether a change begins a cut, and does not say which side stays.
export function isNewCut({ clip = "off", clipFlipped }: Partial<Settings>, before: Settings): boolean {
  return clip !== "off" && clip !== before.clip && clipFlipped === undefined;
}
