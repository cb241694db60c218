import * as THREE from "three";

// A depth texture with the precision of fragments, for exact comparison.
export function exactDepths(): THREE.DepthTexture {
  return new THREE.DepthTexture(1, 1, THREE.FloatType);
}
