// Finds the first intersection of a ray with a surface of many tiles.
interface Tile {
  id: string;
  positions: Float32Array;
  triangles: Uint16Array | Uint32Array;
}

const boxes = new WeakMap<Float32Array, Float64Array>();

// The places x with normal . x + constant >= 0.
export interface HalfSpace {
  normal: readonly number[];
  constant: number;
}

// All in lattice coordinates; null without a hit. Ignores hits outside of one of `clip`: they are clipped.
export function nearestHit(
  tiles: readonly Tile[],
  origin: readonly number[],
  direction: readonly number[],
  clip: readonly HalfSpace[] = [],
): { id: string; triangle: number; point: [number, number, number] } | null {
  let nearest = Infinity;
  let id = "";
  let triangle = 0; // The number in that tile.
  const isKept = (at: number) =>
    clip.every(({ normal, constant }) => normal.reduce((sum, n, axis) => sum + n * (origin[axis] + at * direction[axis]), constant) >= 0);
  for (const tile of tiles) {
    if (!meetsBox(boxOf(tile.positions), origin, direction, nearest)) continue;
    const { positions: p, triangles } = tile;
    for (let t = 0; t < triangles.length; t += 3) {
      const a = 3 * triangles[t];
      const b = 3 * triangles[t + 1];
      const c = 3 * triangles[t + 2];
      const at = triangleHit(p, a, b, c, origin, direction);
      if (at > 0 && at < nearest && isKept(at)) {
        nearest = at;
        id = tile.id;
        triangle = t / 3;
      }
    }
  }
  if (nearest === Infinity) return null;
  const along = (axis: number) => origin[axis] + nearest * direction[axis];
  return { id, triangle, point: [along(0), along(1), along(2)] };
}

function boxOf(p: Float32Array): Float64Array {
  let box = boxes.get(p);
  if (box) return box;
  box = new Float64Array([Infinity, Infinity, Infinity, -Infinity, -Infinity, -Infinity]);
  for (let i = 0; i < p.length; ++i) {
    const axis = i % 3;
    if (p[i] < box[axis]) box[axis] = p[i];
    if (p[i] > box[axis + 3]) box[axis + 3] = p[i];
  }
  boxes.set(p, box);
  return box;
}

function meetsBox(box: Float64Array, origin: readonly number[], direction: readonly number[], before: number): boolean {
  let from = 0;
  let to = before;
  for (let axis = 0; axis < 3; ++axis) {
    const t1 = (box[axis] - origin[axis]) / direction[axis];
    const t2 = (box[axis + 3] - origin[axis]) / direction[axis];
    from = Math.max(from, Math.min(t1, t2));
    to = Math.min(to, Math.max(t1, t2));
  }
  return from <= to;
}

// Möller and Trumbore; Infinity without a hit.
function triangleHit(p: Float32Array, a: number, b: number, c: number, o: readonly number[], d: readonly number[]): number {
  const e1x = p[b] - p[a];
  const e1y = p[b + 1] - p[a + 1];
  const e1z = p[b + 2] - p[a + 2];
  const e2x = p[c] - p[a];
  const e2y = p[c + 1] - p[a + 1];
  const e2z = p[c + 2] - p[a + 2];
  const hx = d[1] * e2z - d[2] * e2y;
  const hy = d[2] * e2x - d[0] * e2z;
  const hz = d[0] * e2y - d[1] * e2x;
  const determinant = e1x * hx + e1y * hy + e1z * hz;
  if (determinant === 0) return Infinity;
  const sx = o[0] - p[a];
  const sy = o[1] - p[a + 1];
  const sz = o[2] - p[a + 2];
  const u = (sx * hx + sy * hy + sz * hz) / determinant;
  if (u < 0 || u > 1) return Infinity;
  const qx = sy * e1z - sz * e1y;
  const qy = sz * e1x - sx * e1z;
  const qz = sx * e1y - sy * e1x;
  const v = (d[0] * qx + d[1] * qy + d[2] * qz) / determinant;
  if (v < 0 || u + v > 1) return Infinity;
  return (e2x * qx + e2y * qy + e2z * qz) / determinant;
}
