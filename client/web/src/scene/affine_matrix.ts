import * as THREE from "three";
import type { Affine } from "../stream/dataset";

export function affineMatrix(m: Affine): THREE.Matrix4 {
  return new THREE.Matrix4().set(m[0], m[3], m[6], m[9], m[1], m[4], m[7], m[10], m[2], m[5], m[8], m[11], 0, 0, 0, 1);
}
