// Writes a surface that only the page can write, because parts of it are hidden: as GLB (y up, as required), PLY or STL,
// in world coordinates.
import * as THREE from "three";
import { GLTFExporter } from "three/examples/jsm/exporters/GLTFExporter.js";
import { PLYExporter } from "three/examples/jsm/exporters/PLYExporter.js";
import { STLExporter } from "three/examples/jsm/exporters/STLExporter.js";

import type { WeldedMesh } from "./welded_mesh";

export type MeshFormat = "glb" | "ply" | "stl";

const maxMove = 1e-2; // Lattice steps that rounding to 32 bits may move a vertex.

// `step`: the length of a lattice step. Rejects with a reason if the format cannot hold the coordinates.
export async function meshFile(mesh: WeldedMesh, format: MeshFormat, step: number): Promise<Uint8Array> {
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.BufferAttribute(mesh.positions, 3));
  geometry.setAttribute("normal", new THREE.BufferAttribute(mesh.normals, 3));
  geometry.setIndex(new THREE.BufferAttribute(mesh.triangles, 1));
  const node = new THREE.Mesh(geometry, new THREE.MeshStandardMaterial({ side: THREE.DoubleSide, metalness: 0, roughness: 0.6 }));
  node.position.set(mesh.origin[0], mesh.origin[1], mesh.origin[2]);
  if (format === "glb") {
    const matrix = new THREE.Matrix4().set(1, 0, 0, 0, 0, 0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1); // z up to y up.
    node.applyMatrix4(matrix);
    node.updateMatrixWorld();
    return new Uint8Array((await new GLTFExporter().parseAsync(node, { binary: true })) as ArrayBuffer);
  }
  node.updateMatrixWorld();
  const largest = Math.max(...mesh.origin.map(Math.abs));
  if (largest * 2 ** -24 > maxMove * step) {
    throw new Error(
      `${format.toUpperCase()} files of the page have 32-bit coordinates, too few digits at ${largest.toPrecision(2)} units from the origin; GLB keeps them.`,
    );
  }
  if (format === "stl") {
    const { buffer } = new STLExporter().parse(node, { binary: true });
    return new Uint8Array(buffer as ArrayBuffer);
  }
  const inPly = new PLYExporter().parse as unknown as (node: THREE.Object3D, onDone: null, options: object) => ArrayBuffer; // A callback would need frames.
  return new Uint8Array(inPly(node, null, { binary: true, littleEndian: true, excludeAttributes: ["normal", "uv", "color"] }));
}
