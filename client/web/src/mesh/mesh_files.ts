// A surface as a file for other programs: GLB, PLY or STL, all binary, in world coordinates (GLB: as
// its standard wants, y upwards). Tiles are welded for GLB and PLY: one lattice point is one vertex.
import { PointNumbers } from "./point_numbers";

interface Tile {
  positions: Float32Array; // Lattice coordinates.
  triangles: Uint16Array | Uint32Array;
}
export interface WorldMesh {
  positions: Float32Array;
  triangles: Uint32Array;
}

// `toWorld`: lattice -> world, the columns of x, y, z and the translation, three numbers each.
export function meshFile(
  tiles: readonly Tile[],
  format: "glb" | "ply" | "stl",
  toWorld: readonly number[],
): Uint8Array {
  const mesh = weldedInWorld(tiles, toWorld);
  if (format === "glb") return glb(mesh);
  return format === "ply" ? ply(mesh) : stl(mesh);
}

export function weldedInWorld(tiles: readonly Tile[], toWorld: readonly number[]): WorldMesh {
  const count = tiles.reduce((n, tile) => n + tile.triangles.length, 0);
  const numbers = new PointNumbers(count / 5);
  const triangles = new Uint32Array(count);
  let used = 0;
  for (const { positions: p, triangles: corners } of tiles) {
    const own = new Uint32Array(p.length / 3);
    for (let v = 0; v < own.length; ++v) {
      own[v] = numbers.numberOf(p[3 * v], p[3 * v + 1], p[3 * v + 2]);
    }
    for (const corner of corners) triangles[used++] = own[corner];
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
  return { positions, triangles };
}

// A map that mirrors turns triangles inside out.
function isMirror([a, b, c, d, e, f, g, h, i]: readonly number[]): boolean {
  return a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g) < 0;
}

function ply({ positions, triangles }: WorldMesh): Uint8Array {
  const header =
    "ply\nformat binary_little_endian 1.0\n" +
    `element vertex ${positions.length / 3}\n` +
    "property float x\nproperty float y\nproperty float z\n" +
    `element face ${triangles.length / 3}\nproperty list uchar uint vertex_indices\nend_header\n`;
  const text = new TextEncoder().encode(header);
  const bytes = new Uint8Array(text.length + 4 * positions.length + (13 * triangles.length) / 3);
  bytes.set(text);
  bytes.set(new Uint8Array(positions.buffer, 0, 4 * positions.length), text.length);
  const view = new DataView(bytes.buffer);
  let at = text.length + 4 * positions.length;
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

function glb({ positions, triangles }: WorldMesh): Uint8Array {
  const upright = new Float32Array(positions.length); // z upwards -> y upwards.
  const low = [Infinity, Infinity, Infinity];
  const high = [-Infinity, -Infinity, -Infinity];
  for (let i = 0; i < positions.length; i += 3) {
    upright[i] = positions[i];
    upright[i + 1] = positions[i + 2];
    upright[i + 2] = -positions[i + 1];
    for (let axis = 0; axis < 3; ++axis) {
      low[axis] = Math.min(low[axis], upright[i + axis]);
      high[axis] = Math.max(high[axis], upright[i + axis]);
    }
  }
  const vertexBytes = upright.byteLength;
  const indexBytes = triangles.byteLength;
  const description = {
    asset: { version: "2.0", generator: "Multi-Tetra streaming" },
    scene: 0,
    scenes: [{ nodes: [0] }],
    nodes: [{ mesh: 0 }],
    meshes: [{ primitives: [{ attributes: { POSITION: 0 }, indices: 1 }] }],
    accessors: [
      { bufferView: 0, componentType: 5126, count: upright.length / 3, type: "VEC3", min: low, max: high },
      { bufferView: 1, componentType: 5125, count: triangles.length, type: "SCALAR" },
    ],
    bufferViews: [
      { buffer: 0, byteLength: vertexBytes, target: 34962 },
      { buffer: 0, byteOffset: vertexBytes, byteLength: indexBytes, target: 34963 },
    ],
    buffers: [{ byteLength: vertexBytes + indexBytes }],
  };
  const plain = new TextEncoder().encode(JSON.stringify(description));
  const jsonBytes = Math.ceil(plain.length / 4) * 4;
  const total = 12 + 8 + jsonBytes + 8 + vertexBytes + indexBytes;
  const bytes = new Uint8Array(total).fill(0x20, 20, 20 + jsonBytes);
  const view = new DataView(bytes.buffer);
  view.setUint32(0, 0x46546c67, true); // "glTF"
  view.setUint32(4, 2, true);
  view.setUint32(8, total, true);
  view.setUint32(12, jsonBytes, true);
  view.setUint32(16, 0x4e4f534a, true); // "JSON"
  bytes.set(plain, 20);
  view.setUint32(20 + jsonBytes, vertexBytes + indexBytes, true);
  view.setUint32(24 + jsonBytes, 0x004e4942, true); // "BIN"
  bytes.set(new Uint8Array(upright.buffer), 28 + jsonBytes);
  bytes.set(new Uint8Array(triangles.buffer), 28 + jsonBytes + vertexBytes);
  return bytes;
}
