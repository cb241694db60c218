// The intersection of a surface with a plane.
interface Tile {
  positions: Float32Array;
  triangles: Uint16Array | Uint32Array;
}

// The places x with normal . x + constant = 0, in the tiles' coordinates.
export interface CutPlane {
  normal: readonly number[];
  constant: number;
}

// Returns segments, as two places of three coordinates each. A corner on the plane counts as beyond it, so that
// neighbors agree: a closed surface gives closed lines.
export function cutLine(tiles: readonly Tile[], { normal: [nx, ny, nz], constant }: CutPlane): Float32Array {
  const segments: number[] = [];
  for (const { positions: p, triangles } of tiles) {
    const sides = new Float64Array(p.length / 3);
    for (let v = 0; v < sides.length; ++v) sides[v] = nx * p[3 * v] + ny * p[3 * v + 1] + nz * p[3 * v + 2] + constant;
    for (let t = 0; t < triangles.length; t += 3) {
      const b0 = sides[triangles[t]] >= 0;
      const b1 = sides[triangles[t + 1]] >= 0;
      const b2 = sides[triangles[t + 2]] >= 0;
      if (b0 === b1 && b1 === b2) continue;
      const alone = b1 === b2 ? 0 : b0 === b2 ? 1 : 2; // The corner alone on its side; the plane cuts its two edges.
      for (const step of [1, 2]) {
        const from = triangles[t + alone];
        const to = triangles[t + ((alone + step) % 3)];
        // Ordered by vertex number, so that both triangles at an edge compute the same place.
        const [a, b] = from < to ? [from, to] : [to, from];
        const share = sides[a] / (sides[a] - sides[b]);
        for (let axis = 0; axis < 3; ++axis) {
          segments.push(p[3 * a + axis] + share * (p[3 * b + axis] - p[3 * a + axis]));
        }
      }
    }
  }
  return Float32Array.from(segments);
}
