// Empties a group and gives the graphics card back what its parts had there.
import * as THREE from "three";

export function disposeTree(group: THREE.Group): void {
  group.traverse((part) => {
    if (!(part instanceof THREE.Mesh || part instanceof THREE.LineSegments)) return;
    part.geometry.dispose();
    for (const material of [part.material].flat()) material.dispose();
  });
  group.clear();
}
