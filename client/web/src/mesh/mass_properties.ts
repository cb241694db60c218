// Computes the area of a part of a surface and the volume it encloses, by the divergence theorem. Exact up to rounding
// in double precision, for the surface as shown.
import { cross, dot, minus } from "../shared/vectors";
import { borderCaps } from "./border_caps";
import { Components } from "./components";
import { countEdges, type EdgeCounts } from "./edge_uses";
import { PointNumbers } from "./point_numbers";

interface Tile {
  id: string;
  positions: Float32Array; // Lattice coordinates.
  triangles: Uint16Array | Uint32Array;
}

export interface MassProperties {
  triangles: number;
  area: number; // World units squared.
  volume: number | null; // World units cubed; null: the part is not closed.
  isCapped: boolean; // The border of the data cuts it open, and caps close its volume. They do not count as area.
  bend: number; // The sum over edges of length times the angle by which the surface bends there, on the side with more of it.
  vertices: number;
}

// Returns a bound of the difference between this volume and that inside another surface, if a map between the two moves
// no point farther than `distance`: the tube formula of Steiner and Weyl (common/mesh/mesh_measures.hpp has the proof).
export function volumeBound({ area, bend, vertices }: MassProperties, distance: number): number {
  return distance * (area + distance * (bend / 2 + (distance * 2 * Math.PI * vertices) / 3));
}

// `at` selects a connected part by one of its triangles; null: all parts. `toWorld`: lattice -> world, the columns of
// x, y, z and the translation. Returns null if there is no such triangle.
export function massProperties(tiles: readonly Tile[], toWorld: readonly number[], at: { id: string; triangle: number } | null): MassProperties | null {
  const total = tiles.reduce((n, tile) => n + tile.triangles.length, 0);
  const numbers = new PointNumbers(Math.max(16, total / 5));
  const corners = new Uint32Array(total);
  let used = 0;
  let wanted = -1;
  for (const { id, positions: p, triangles } of tiles) {
    const own = new Uint32Array(p.length / 3);
    for (let v = 0; v < own.length; ++v) own[v] = numbers.numberOf(p[3 * v], p[3 * v + 1], p[3 * v + 2]);
    if (at && id === at.id && 3 * at.triangle < triangles.length) wanted = used + 3 * at.triangle;
    for (const corner of triangles) corners[used++] = own[corner];
  }
  if (!at && total > 0) return measured(corners, numbers.coordinates(), toWorld);
  if (wanted < 0) return null;
  const part = partAt(corners, wanted, numbers.size);
  return measured(part, numbers.coordinates(), toWorld);
}

// Returns the connected component of a triangle.
function partAt(corners: Uint32Array, wanted: number, points: number): Uint32Array {
  const parts = new Components(points);
  for (let t = 0; t < corners.length; t += 3) {
    parts.join(corners[t], corners[t + 1]);
    parts.join(corners[t + 1], corners[t + 2]);
  }
  const root = parts.root(corners[wanted]);
  const part = new Uint32Array(corners.length);
  let used = 0;
  for (let t = 0; t < corners.length; t += 3) {
    if (parts.root(corners[t]) !== root) continue;
    part.set(corners.subarray(t, t + 3), used);
    used += 3;
  }
  return part.slice(0, used);
}

function measured(part: Uint32Array, lattice: Int32Array, m: readonly number[]): MassProperties {
  let area = 0;
  const bends = new Bends(lattice.length / 3);
  let six = 0; // Six times the volume, in lattice units: integers stay exact.
  const origin = 3 * part[0];
  const at = (vertex: number) => [0, 1, 2].map((axis) => lattice[3 * vertex + axis] - lattice[origin + axis]);
  const inWorld = (v: number[]) => [0, 1, 2].map((row) => m[row] * v[0] + m[3 + row] * v[1] + m[6 + row] * v[2]);
  for (let t = 0; t < part.length; t += 3) {
    const [a, b, c] = [at(part[t]), at(part[t + 1]), at(part[t + 2])];
    const along = (to: number[]) => inWorld(minus(to, a));
    const normal = cross(along(b), along(c));
    area += Math.hypot(...normal) / 2;
    bends.add([part[t], part[t + 1], part[t + 2]], [a, b, c].map(inWorld), normal);
    six += dot(a, cross(b, c));
  }
  const { open, nonmanifold } = edgesOf(part, lattice.length / 3);
  const [low, high] = extentOf(part, at);
  const caps = nonmanifold === 0 ? borderCaps(open, at, low, high, lattice.length / 3) : null;
  for (const [a, b, c] of caps ?? []) six += dot(a, cross(b, c));
  const scale = Math.abs(dot([m[0], m[1], m[2]], cross([m[3], m[4], m[5]], [m[6], m[7], m[8]])));
  return {
    triangles: part.length / 3,
    area,
    volume: caps && (Math.abs(six) * scale) / 6,
    isCapped: caps !== null && caps.length > 0,
    bend: Math.max(bends.convex, bends.concave),
    vertices: new Set(part).size,
  };
}

// Adds up lengths of edges times the angles between the normals of their two triangles.
class Bends {
  convex = 0;
  concave = 0;
  private readonly waiting = new Map<number, number[]>(); // The normals of triangles by edge.

  constructor(private readonly points: number) {}

  add(corners: number[], places: number[][], normal: number[]): void {
    for (let i = 0; i < 3; ++i) {
      const [from, to, opposite] = [i, (i + 1) % 3, (i + 2) % 3];
      const edge = Math.min(corners[from], corners[to]) * this.points + Math.max(corners[from], corners[to]);
      const other = this.waiting.get(edge);
      if (!other) {
        this.waiting.set(edge, normal);
        continue;
      }
      this.waiting.delete(edge);
      const side = (at: number) => minus(places[at], places[from]);
      const angle = Math.atan2(Math.hypot(...cross(other, normal)), dot(other, normal));
      if (dot(other, side(opposite)) < 0) this.convex += angle * Math.hypot(...side(to));
      else this.concave += angle * Math.hypot(...side(to));
    }
  }
}

function extentOf(part: Uint32Array, at: (vertex: number) => number[]): [number[], number[]] {
  const [low, high] = [
    [Infinity, Infinity, Infinity],
    [-Infinity, -Infinity, -Infinity],
  ];
  for (const vertex of part) {
    at(vertex).forEach((value, axis) => {
      low[axis] = Math.min(low[axis], value);
      high[axis] = Math.max(high[axis], value);
    });
  }
  return [low, high];
}

function edgesOf(part: Uint32Array, points: number): EdgeCounts {
  const directed = new Uint32Array(2 * part.length);
  for (let t = 0; t < part.length; t += 3) {
    directed.set([part[t], part[t + 1], part[t + 1], part[t + 2], part[t + 2], part[t]], 2 * t);
  }
  return countEdges(directed, points);
}
