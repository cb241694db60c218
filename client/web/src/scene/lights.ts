// Key, fill and rim light, which turn with the camera, so that a surface is lit equally from every side: the key from
// above the left shoulder, a weaker and cooler fill from the right, and a rim from behind that separates the surface
// from a dark background.
import * as THREE from "three";

export class Lights {
  readonly group = new THREE.Group();

  constructor() {
    this.group.add(light(0xfff4e6, 2.3, [-0.6, 0.85, 1]), light(0xdbe7ff, 0.75, [0.95, 0.05, 0.7]), light(0xffffff, 0.55, [0.3, 0.7, -1]));
    const sky = new THREE.HemisphereLight(0xdfe8f5, 0x2a2622, 0.8);
    sky.position.set(0, 0, 1); // World coordinates: z is up.
    this.group.add(sky);
    this.group.traverse((part) => part.layers.enableAll());
  }

  follow(camera: THREE.Camera): void {
    this.group.quaternion.copy(camera.quaternion);
    this.group.updateMatrixWorld();
  }
}

function light(color: number, intensity: number, from: [number, number, number]): THREE.DirectionalLight {
  const one = new THREE.DirectionalLight(color, intensity);
  one.position.set(...from);
  one.add(one.target); // The target lies at the origin of the group.
  one.target.position.set(...from).negate();
  return one;
}
