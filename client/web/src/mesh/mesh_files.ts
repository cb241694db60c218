// Writes a surface as binary GLB, PLY or STL, in world coordinates (GLB: y up, as required), with the contents of
// common/wire/mesh_files.cpp: GLB always has normals and a material, PLY has the field's normals. For GLB and PLY tiles
// are welded: one vertex per lattice point.
import { PointNumbers } from "./point_numbers";

interface Tile {
  positions: Float32Array; // Lattice coordinates.
  triangles: Uint16Array | Uint32Array;
  normals: Int16Array; // Four numbers per vertex, in lattice coordinates: see pack().
  sums: Float32Array | null; // Present if normals are those of the triangles, not of the field.
}
export interface WorldMesh {
  positions: Float32Array;
  normals: Float32Array; // Three numbers per vertex, of length 1.
  areOfField: boolean;
  triangles: Uint32Array;
}

// How a surface of a GLB file looks.
export interface SavedLook {
  name: string;
  color: string; // "#rrggbb"
  opacity: number; // 0 to 1.
}
export interface SavedPart {
  mesh: WorldMesh;
  look: SavedLook;
}

// In GLB every part is a node with its own material; the other formats have the first part only.
export function meshFile(parts: readonly SavedPart[], format: "glb" | "ply" | "stl"): Uint8Array {
  if (format === "glb") return glb(parts.map(({ mesh, look }) => ({ ...mesh, look })));
  return format === "ply" ? ply(parts[0].mesh) : stl(parts[0].mesh);
}

// `toWorld`: lattice -> world, the columns of x, y, z and the translation, three numbers each.
export function weldedInWorld(tiles: readonly Tile[], toWorld: readonly number[]): WorldMesh {
  const count = tiles.reduce((n, tile) => n + tile.triangles.length, 0);
  const numbers = new PointNumbers(count / 5);
  const triangles = new Uint32Array(count);
  const directions: number[] = []; // By point, from its first tile.
  let used = 0;
  for (const { positions: p, triangles: corners, normals: n } of tiles) {
    const own = new Int32Array(p.length / 3).fill(-1); // Omits vertices without a triangle.
    for (const v of corners) {
      if (own[v] < 0) own[v] = numbers.numberOf(p[3 * v], p[3 * v + 1], p[3 * v + 2]);
      if (3 * own[v] === directions.length) directions.push(n[4 * v], n[4 * v + 1], n[4 * v + 2]);
      triangles[used++] = own[v];
    }
  }
  const lattice = numbers.coordinates();
  const positions = new Float32Array(lattice.length);
  const m = toWorld;
  for (let i = 0; i < lattice.length; i += 3) {
    for (let axis = 0; axis < 3; ++axis) {
      positions[i + axis] =
        m[axis] * lattice[i] + m[3 + axis] * lattice[i + 1] + m[6 + axis] * lattice[i + 2] +
        m[9 + axis];
    }
  }
  if (isMirror(m)) {
    for (let t = 0; t < triangles.length; t += 3) {
      [triangles[t + 1], triangles[t + 2]] = [triangles[t + 2], triangles[t + 1]];
    }
  }
  const areOfField = tiles.length > 0 && tiles.every((tile) => tile.sums === null);
  return { positions, normals: worldNormals(directions, m), areOfField, triangles };
}

// Transforms normals by the map's inverse transpose, whose columns are, up to a factor, cross products of the map's.
function worldNormals(lattice: readonly number[], m: readonly number[]): Float32Array {
  const sign = isMirror(m) ? -1 : 1;
  const cross = (u: number, v: number) =>
    [0, 1, 2].map((row) => {
      const [i, j] = [(row + 1) % 3, (row + 2) % 3];
      return sign * (m[u + i] * m[v + j] - m[u + j] * m[v + i]);
    });
  const columns = [cross(3, 6), cross(6, 0), cross(0, 3)];
  const normals = new Float32Array(lattice.length);
  for (let i = 0; i < lattice.length; i += 3) {
    const n = [0, 1, 2].map(
      (row) => columns[0][row] * lattice[i] + columns[1][row] * lattice[i + 1] + columns[2][row] * lattice[i + 2],
    );
    const length = Math.hypot(...n);
    normals.set(length > 0 ? n.map((value) => value / length) : [0, 0, 1], i);
  }
  return normals;
}

// A mirroring map turns triangles inside out.
function isMirror([a, b, c, d, e, f, g, h, i]: readonly number[]): boolean {
  return a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g) < 0;
}

function ply({ positions, normals, areOfField, triangles }: WorldMesh): Uint8Array {
  const vertices = positions.length / 3;
  const header =
    "ply\nformat binary_little_endian 1.0\ncomment Multi-Tetra isosurface\n" +
    `element vertex ${vertices}\n` +
    "property float x\nproperty float y\nproperty float z\n" +
    (areOfField ? "property float nx\nproperty float ny\nproperty float nz\n" : "") +
    `element face ${triangles.length / 3}\nproperty list uchar uint vertex_indices\nend_header\n`;
  const text = new TextEncoder().encode(header);
  const stride = areOfField ? 24 : 12;
  const bytes = new Uint8Array(text.length + stride * vertices + (13 * triangles.length) / 3);
  bytes.set(text);
  const view = new DataView(bytes.buffer);
  let at = text.length;
  for (let v = 0; v < positions.length; v += 3, at += stride) {
    for (let axis = 0; axis < 3; ++axis) {
      view.setFloat32(at + 4 * axis, positions[v + axis], true);
      if (areOfField) view.setFloat32(at + 12 + 4 * axis, normals[v + axis], true);
    }
  }
  for (let t = 0; t < triangles.length; t += 3, at += 13) {
    view.setUint8(at, 3);
    for (let corner = 0; corner < 3; ++corner) {
      view.setUint32(at + 1 + 4 * corner, triangles[t + corner], true);
    }
  }
  return bytes;
}

function stl({ positions: p, triangles }: WorldMesh): Uint8Array {
  const bytes = new Uint8Array(84 + (50 * triangles.length) / 3);
  bytes.set(new TextEncoder().encode("Binary STL by Multi-Tetra streaming"));
  const view = new DataView(bytes.buffer);
  view.setUint32(80, triangles.length / 3, true);
  let at = 84;
  for (let t = 0; t < triangles.length; t += 3, at += 50) {
    const [a, b, c] = [0, 1, 2].map((corner) => {
      const vertex = 3 * triangles[t + corner];
      return [p[vertex], p[vertex + 1], p[vertex + 2]];
    });
    const u = b.map((value, axis) => value - a[axis]);
    const v = c.map((value, axis) => value - a[axis]);
    const n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    const length = Math.hypot(...n) || 1;
    [...n.map((value) => value / length), ...a, ...b, ...c].forEach((value, i) =>
      view.setFloat32(at + 4 * i, value, true),
    );
  }
  return bytes;
}

// The numbers are glTF's: 5125 unsigned int, 5126 float, 34962 and 34963 vertex and index buffers.
function glb(parts: readonly (WorldMesh & { look: SavedLook })[]): Uint8Array {
  const buffers: (Float32Array | Uint32Array)[] = [];
  const views: object[] = [];
  const accessors: object[] = [];
  let binaryBytes = 0;
  const add = (array: Float32Array | Uint32Array, type: "VEC3" | "SCALAR", bounds: object) => {
    views.push({ buffer: 0, byteOffset: binaryBytes, byteLength: array.byteLength, target: type === "VEC3" ? 34962 : 34963 });
    buffers.push(array);
    binaryBytes += array.byteLength;
    const isFloat = array instanceof Float32Array;
    accessors.push({ bufferView: views.length - 1, componentType: isFloat ? 5126 : 5125, count: array.length / (type === "VEC3" ? 3 : 1), type, ...bounds });
    return accessors.length - 1;
  };
  const meshes = parts.map(({ positions, normals, triangles }, material) => ({
    primitives: [{
      attributes: { POSITION: add(positions, "VEC3", boundsOf(positions)), NORMAL: add(normals, "VEC3", {}) },
      indices: add(triangles, "SCALAR", {}), material,
    }],
  }));
  const description = {
    asset: { version: "2.0", generator: "Multi-Tetra streaming" },
    scene: 0,
    scenes: [{ nodes: parts.map((_, node) => node) }],
    // Column-major: (x, y, z) -> (x, z, -y), z up to y up.
    nodes: parts.map(({ look }, mesh) => ({ name: look.name, mesh, matrix: [1, 0, 0, 0, 0, 0, -1, 0, 0, 1, 0, 0, 0, 0, 0, 1] })),
    meshes,
    materials: parts.map(({ look: { name, color, opacity } }) => ({
      name,
      doubleSided: true,
      ...(opacity < 1 ? { alphaMode: "BLEND" } : {}),
      pbrMetallicRoughness: { baseColorFactor: [...linearLight(color), opacity], metallicFactor: 0, roughnessFactor: 0.6 },
    })),
    accessors,
    bufferViews: views,
    buffers: [{ byteLength: binaryBytes }],
  };
  const plain = new TextEncoder().encode(JSON.stringify(description));
  const jsonBytes = Math.ceil(plain.length / 4) * 4;
  const total = 12 + 8 + jsonBytes + 8 + binaryBytes;
  const bytes = new Uint8Array(total).fill(0x20, 20, 20 + jsonBytes);
  const view = new DataView(bytes.buffer);
  view.setUint32(0, 0x46546c67, true); // "glTF"
  view.setUint32(4, 2, true);
  view.setUint32(8, total, true);
  view.setUint32(12, jsonBytes, true);
  view.setUint32(16, 0x4e4f534a, true); // "JSON"
  bytes.set(plain, 20);
  view.setUint32(20 + jsonBytes, binaryBytes, true);
  view.setUint32(24 + jsonBytes, 0x004e4942, true); // "BIN"
  let at = 28 + jsonBytes;
  for (const part of buffers) {
    bytes.set(new Uint8Array(part.buffer, part.byteOffset, part.byteLength), at);
    at += part.byteLength;
  }
  return bytes;
}

function boundsOf(positions: Float32Array): { min: number[]; max: number[] } {
  const min = [Infinity, Infinity, Infinity];
  const max = [-Infinity, -Infinity, -Infinity];
  for (let i = 0; i < positions.length; ++i) {
    min[i % 3] = Math.min(min[i % 3], positions[i]);
    max[i % 3] = Math.max(max[i % 3], positions[i]);
  }
  return { min, max };
}

// Converts "#rrggbb" from sRGB to linear light.
function linearLight(color: string): number[] {
  return [1, 3, 5].map((at) => {
    const srgb = parseInt(color.slice(at, at + 2), 16) / 255;
    return srgb <= 0.04045 ? srgb / 12.92 : ((srgb + 0.055) / 1.055) ** 2.4;
  });
}
