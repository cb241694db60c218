// One mesh of a surface's tiles: a vertex for each lattice point, in world axes, with coordinates from a place nearby,
// since 32-bit numbers far from the origin would move vertices.
import { PointNumbers } from "./point_numbers";

interface Tile {
  positions: Float32Array; // Lattice coordinates.
  triangles: Uint16Array | Uint32Array;
  normals: Int16Array; // Four numbers per vertex, in lattice coordinates: see pack().
}
export interface WeldedMesh {
  origin: number[]; // The world coordinates that positions count from.
  positions: Float32Array;
  normals: Float32Array; // Three numbers per vertex, of length 1.
  triangles: Uint32Array;
}

// `toWorld`: lattice -> world, the columns of x, y, z and the translation, three numbers each.
export function weldedInWorld(tiles: readonly Tile[], toWorld: readonly number[]): WeldedMesh {
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
  const [x = 0, y = 0, z = 0] = lattice;
  const positions = new Float32Array(lattice.length);
  const m = toWorld;
  for (let i = 0; i < lattice.length; i += 3) {
    const [u, v, w] = [lattice[i] - x, lattice[i + 1] - y, lattice[i + 2] - z];
    for (let axis = 0; axis < 3; ++axis) positions[i + axis] = m[axis] * u + m[3 + axis] * v + m[6 + axis] * w;
  }
  if (isMirror(m)) {
    for (let t = 0; t < triangles.length; t += 3) {
      [triangles[t + 1], triangles[t + 2]] = [triangles[t + 2], triangles[t + 1]];
    }
  }
  const origin = [0, 1, 2].map((axis) => m[axis] * x + m[3 + axis] * y + m[6 + axis] * z + m[9 + axis]);
  return { origin, positions, normals: worldNormals(directions, m), triangles };
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
    const n = [0, 1, 2].map((row) => columns[0][row] * lattice[i] + columns[1][row] * lattice[i + 1] + columns[2][row] * lattice[i + 2]);
    const length = Math.hypot(...n);
    normals.set(length > 0 ? n.map((value) => value / length) : [0, 0, 1], i);
  }
  return normals;
}

// A mirroring map turns triangles inside out.
function isMirror([a, b, c, d, e, f, g, h, i]: readonly number[]): boolean {
  return a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g) < 0;
}
