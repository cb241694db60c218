import * as THREE from "three";

// Depths as the fragments compute them, for exact comparison.
export function exactDepths(): THREE.DepthTexture {
  return new THREE.DepthTexture(1, 1, THREE.FloatType);
}
