// Empties a group and frees the GPU memory of its parts.
import * as THREE from "three";

export function disposeTree(group: THREE.Group): void {
  group.traverse((part) => {
    if (!(part instanceof THREE.Mesh || part instanceof THREE.LineSegments)) return;
    part.geometry.dispose();
    for (const material of [part.material].flat()) material.dispose();
  });
  group.clear();
}
