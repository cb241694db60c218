// Directions of the camera beside those of the world.
import * as THREE from "three";

// The axis of the world where the direction is within half a degree of one.
export function nearAxis(direction: THREE.Vector3): THREE.Vector3 {
  const axis = [0, 1, 2].find((one) => Math.abs(direction.getComponent(one)) > Math.cos(THREE.MathUtils.degToRad(0.5)));
  return axis === undefined ? direction : new THREE.Vector3().setComponent(axis, Math.sign(direction.getComponent(axis)));
}

// Straight along what is up there is no up in the picture: a hair beside it there is.
export function besideUp(direction: THREE.Vector3, up: THREE.Vector3): THREE.Vector3 {
  if (direction.clone().normalize().cross(up).length() >= 1e-6) return direction;
  const hair = Math.abs(up.y) < 0.9 ? new THREE.Vector3(0, -1e-4, 0) : new THREE.Vector3(0, 0, -1e-4);
  return direction.clone().add(hair);
}
