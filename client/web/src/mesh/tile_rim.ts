// What the rest of a step must know of one tile: the open edges where it meets its neighbours, and
// counts of what lies inside. So a whole surface is checked from its tiles' rims, which are a small
// part of it, and a tile that stays is never counted again.
import { Components } from "./components";
import { countEdges } from "./edge_uses";
import type { LatticeMesh } from "./tile_mesh";

export interface TileRim {
  triangles: number;
  innerVertices: number; // Not on the rim.
  innerEdges: number; // Of more than one triangle of this tile.
  nonmanifoldEdges: number; // Of them.
  degenerateTriangles: number;
  components: number; // Of the tile alone.
  // The vertices on the rim: lattice coordinates, number in the tile, number of the component.
  positions: Int32Array;
  vertices: Uint32Array;
  component: Uint32Array;
  edges: Uint32Array; // Pairs of rim vertices, in the direction of their triangle.
}

export function rimOf(mesh: LatticeMesh): TileRim {
  const vertices = mesh.positions.length / 3;
  const components = new Components(vertices);
  let degenerate = 0;
  const directed = new Uint32Array(2 * mesh.triangles.length);
  let used = 0;
  for (let t = 0; t < mesh.triangles.length; t += 3) {
    const a = mesh.triangles[t];
    const b = mesh.triangles[t + 1];
    const c = mesh.triangles[t + 2];
    components.join(a, b);
    components.join(b, c);
    if (a === b || b === c || c === a) {
      ++degenerate;
      continue;
    }
    directed[used] = directed[used + 5] = a;
    directed[used + 1] = directed[used + 2] = b;
    directed[used + 3] = directed[used + 4] = c;
    used += 6;
  }
  const counts = countEdges(directed.subarray(0, used), vertices);
  const numbers = new Map<number, number>(); // Tile's vertex -> rim's.
  const edges = counts.open.map((vertex) => {
    let number = numbers.get(vertex);
    if (number === undefined) numbers.set(vertex, (number = numbers.size));
    return number;
  });
  const onRim = Uint32Array.from(numbers.keys());
  const labels = new Map<number, number>();
  const component = onRim.map((vertex) => {
    const root = components.root(vertex);
    let label = labels.get(root);
    if (label === undefined) labels.set(root, (label = labels.size));
    return label;
  });
  const positions = new Int32Array(3 * onRim.length);
  onRim.forEach((vertex, i) => {
    positions.set(mesh.positions.subarray(3 * vertex, 3 * vertex + 3), 3 * i);
  });
  return {
    triangles: mesh.triangles.length / 3,
    innerVertices: vertices - onRim.length,
    innerEdges: counts.edges - counts.open.length / 2,
    nonmanifoldEdges: counts.nonmanifold,
    degenerateTriangles: degenerate,
    components: components.count(),
    positions,
    vertices: onRim,
    component,
    edges,
  };
}
