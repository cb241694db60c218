// Counts which edges the triangles use, and in which direction; the basis of all mesh checks.
//
// An edge of two triangles that traverse it in opposite directions is sound; an edge of one
// triangle is open (a boundary); all others are non-manifold.
export interface EdgeCounts {
  edges: number; // Distinct edges.
  nonmanifold: number;
  open: Uint32Array; // Pairs of vertices, in the direction of their only triangle.
}

// `directed`: pairs of different vertex numbers below `vertices`.
export function countEdges(directed: Uint32Array, vertices: number): EdgeCounts {
  // Sorts into buckets by the lower end; buckets are short.
  const first = new Uint32Array(vertices + 2);
  for (let e = 0; e < directed.length; e += 2) {
    ++first[Math.min(directed[e], directed[e + 1]) + 2];
  }
  for (let v = 1; v < first.length; ++v) first[v] += first[v - 1];
  const uppers = new Uint32Array(directed.length / 2);
  const upwards = new Uint8Array(directed.length / 2);
  for (let e = 0; e < directed.length; e += 2) {
    const from = directed[e];
    const to = directed[e + 1];
    const slot = first[Math.min(from, to) + 1]++;
    uppers[slot] = Math.max(from, to);
    upwards[slot] = from < to ? 1 : 0;
  }
  const open: number[] = [];
  let edges = 0;
  let nonmanifold = 0;
  for (let lower = 0; lower < vertices; ++lower) {
    const begin = first[lower];
    const end = first[lower + 1];
    for (let i = begin; i < end; ++i) {
      let uses = 0;
      let ups = 0;
      let seenBefore = false;
      for (let j = begin; j < end; ++j) {
        if (uppers[j] !== uppers[i]) continue;
        if (j < i) {
          seenBefore = true;
          break;
        }
        ++uses;
        ups += upwards[j];
      }
      if (seenBefore) continue;
      ++edges;
      if (uses === 1) {
        if (ups === 1) open.push(lower, uppers[i]);
        else open.push(uppers[i], lower);
      } else if (uses !== 2 || ups !== 1) {
        ++nonmanifold;
      }
    }
  }
  return { edges, nonmanifold, open: Uint32Array.from(open) };
}
