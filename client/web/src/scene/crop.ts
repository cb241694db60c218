// The crop: a box in the world outside of which surfaces and slices are hidden.
import * as THREE from "three";

import type { DatasetInfo } from "../protocol/messages";
import type { Crop, Settings } from "../state/settings";
import { type Vec3, worldBox } from "../stream/dataset";
import { clipPlane } from "./cut_plane";
import { axisNormal } from "./slice_grid";

// A face of the crop inside the data, as a slice.
export interface CropFace {
  number: number; // 0 to 5: low x, high x, low y and so on.
  normal: Vec3; // The world axis.
  at: number; // 0 to 1 along it, over the data's box.
}

// Returns the half-spaces that remain visible: of the cut, if any, and of the crop's faces in the order of their numbers.
export function clipPlanes(settings: Settings, info: DatasetInfo | null): THREE.Plane[] {
  const cut = clipPlane(settings, info);
  return [...(cut ? [cut] : []), ...cropPlanes(settings.crop)];
}

export function cropPlanes(crop: Crop | null): THREE.Plane[] {
  return crop ? facesOf(crop).map(({ axis, sign, at }) => new THREE.Plane(new THREE.Vector3().setComponent(axis, sign), -sign * at)) : [];
}

// Returns the faces inside the data, where the crop cuts it.
export function cropFaces(crop: Crop | null, info: DatasetInfo): CropFace[] {
  if (!crop) return [];
  const { low, high } = worldBox(info);
  return facesOf(crop)
    .map(({ axis, at }, number) => ({
      number,
      normal: axisNormal("xyz"[axis] as "x" | "y" | "z"),
      at: (at - low[axis]) / (high[axis] - low[axis]),
    }))
    .filter(({ at }) => at > 0 && at < 1);
}

// Returns the part of a box inside the crop; the whole box if none is inside.
export function croppedBox(box: THREE.Box3, crop: Crop | null): THREE.Box3 {
  if (!crop) return box;
  const inside = box.clone().intersect(boxBetween(crop));
  return inside.isEmpty() ? box : inside;
}

export function boxBetween({ low, high }: Crop): THREE.Box3 {
  return new THREE.Box3(new THREE.Vector3(...low), new THREE.Vector3(...high));
}

// The sign is that of the normal, which points to the inside.
function facesOf({ low, high }: Crop): { axis: number; sign: 1 | -1; at: number }[] {
  return [0, 1, 2].flatMap((axis) => [
    { axis, sign: 1 as const, at: low[axis] },
    { axis, sign: -1 as const, at: high[axis] },
  ]);
}
