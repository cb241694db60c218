// Directions of the camera relative to the world's axes.
import * as THREE from "three";

// Returns the world axis within half a degree of the direction, or else the direction.
export function snappedToAxis(direction: THREE.Vector3): THREE.Vector3 {
  const axis = [0, 1, 2].find((one) => Math.abs(direction.getComponent(one)) > Math.cos(THREE.MathUtils.degToRad(0.5)));
  return axis === undefined ? direction : new THREE.Vector3().setComponent(axis, Math.sign(direction.getComponent(axis)));
}

// Returns the direction, slightly rotated if it is parallel to `up`: a camera cannot look along its up vector.
export function nudgedFromUp(direction: THREE.Vector3, up: THREE.Vector3): THREE.Vector3 {
  if (direction.clone().normalize().cross(up).length() >= 1e-6) return direction;
  const offset = Math.abs(up.y) < 0.9 ? new THREE.Vector3(0, -1e-4, 0) : new THREE.Vector3(0, 0, -1e-4);
  return direction.clone().add(offset);
}
