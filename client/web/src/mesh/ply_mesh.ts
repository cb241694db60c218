// Reads the PLY files of a server: binary, little-endian, vertices first, with positions of 32 or, where these are too coarse, 64 bits.
import { normalSums } from "./normals";
import type { WorldMesh } from "./mesh_files";

const header = /^ply\nformat binary_little_endian 1\.0\n(?:comment [^\n]*\n)*element vertex (\d+)\nproperty (float|double) x\nproperty \2 y\nproperty \2 z\nelement face (\d+)\nproperty list uchar uint vertex_indices\nend_header\n/;
const maxHeader = 4096; // Bytes.

// Returns the number of triangles. Throws if the bytes are not such a file.
export function plyTriangles(bytes: ArrayBuffer): number {
  return headerOf(bytes).triangles;
}

// Throws if the bytes are not such a file. `voxel`: the length of the shortest edges that count fully for normals.
export function plyMesh(bytes: ArrayBuffer, voxel: number): WorldMesh {
  const { begin, vertices, bytesOfNumber, triangles: count } = headerOf(bytes);
  const view = new DataView(bytes, begin);
  const trianglesAt = 3 * bytesOfNumber * vertices;
  if (view.byteLength !== trianglesAt + 13 * count) throw new Error("The mesh is incomplete.");
  const positions = new Float32Array(3 * vertices);
  for (let i = 0; i < positions.length; ++i) positions[i] = bytesOfNumber === 4 ? view.getFloat32(4 * i, true) : view.getFloat64(8 * i, true);
  const triangles = new Uint32Array(3 * count);
  for (let t = 0; t < count; ++t) {
    const at = trianglesAt + 13 * t;
    for (let corner = 0; corner < 3; ++corner) triangles[3 * t + corner] = view.getUint32(at + 1 + 4 * corner, true);
    if (view.getUint8(at) !== 3 || Math.max(...triangles.subarray(3 * t, 3 * t + 3)) >= vertices) throw new Error("The mesh is damaged.");
  }
  return { positions, normals: unit(normalSums({ positions, triangles }, voxel)), areOfField: false, triangles };
}

function headerOf(bytes: ArrayBuffer): { begin: number; vertices: number; bytesOfNumber: 4 | 8; triangles: number } {
  const found = header.exec(new TextDecoder("latin1").decode(bytes.slice(0, maxHeader)));
  if (!found) throw new Error("The server did not send a mesh.");
  return { begin: found[0].length, vertices: Number(found[1]), bytesOfNumber: found[2] === "float" ? 4 : 8, triangles: Number(found[3]) };
}

function unit(vectors: Float32Array): Float32Array {
  for (let i = 0; i < vectors.length; i += 3) {
    const length = Math.hypot(vectors[i], vectors[i + 1], vectors[i + 2]);
    vectors.set(length > 0 ? [vectors[i] / length, vectors[i + 1] / length, vectors[i + 2] / length] : [0, 0, 1], i);
  }
  return vectors;
}
