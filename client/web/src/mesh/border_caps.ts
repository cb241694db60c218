// Closes a part of a surface at the border of the data, to compute its volume. Each boundary loop gets a cap on the
// sides of the data's box. A loop on one side, or around an edge or a corner of the box, has one cap; for a loop that
// touches opposite sides the surface does not determine which part of the box is inside.
import { Components } from "./components";

// Returns triangles that close all loops, as triples of places in lattice coordinates; null: a loop has no cap. `open`:
// pairs of vertices in the direction of their only triangle; `low` and `high`: the extent of the part, which reaches
// the data's border wherever it is open.
export function borderCaps(
  open: Uint32Array,
  place: (vertex: number) => number[],
  low: readonly number[],
  high: readonly number[],
  vertices: number,
): number[][][] | null {
  const corners = [0, 1, 2, 3, 4, 5, 6, 7].map((bits) => low.map((from, axis) => (bits & (1 << axis) ? high[axis] : from)));
  const caps: number[][][] = [];
  for (const loop of loopsOf(open, vertices)) {
    // A fan from a corner lies on the sides at that corner if every edge lies on one of them.
    const corner = corners.find((at) => loop.every(([a, b]) => isOnASide(place(a), place(b), at)));
    if (!corner) return null;
    caps.push(...loop.map(([a, b]) => [place(b), place(a), corner]));
  }
  return caps;
}

function isOnASide(a: readonly number[], b: readonly number[], corner: readonly number[]): boolean {
  return corner.some((part, axis) => a[axis] === part && b[axis] === part);
}

// Returns the connected sets of edges.
function loopsOf(open: Uint32Array, vertices: number): (readonly [number, number])[][] {
  const joined = new Components(vertices);
  for (let e = 0; e < open.length; e += 2) joined.join(open[e], open[e + 1]);
  const loops = new Map<number, (readonly [number, number])[]>();
  for (let e = 0; e < open.length; e += 2) {
    const root = joined.root(open[e]);
    if (!loops.has(root)) loops.set(root, []);
    loops.get(root)!.push([open[e], open[e + 1]]);
  }
  return [...loops.values()];
}
