// The boundary of a tile: the open edges where it meets its neighbors, and counts of its interior. Whole surfaces are
// checked from the small boundaries of their tiles, so that unchanged tiles are never counted again.
import { Components } from "./components";
import { countEdges, type EdgeCounts } from "./edge_uses";
import type { LatticeBox, LatticeMesh } from "./tile_mesh";

export interface TileBoundary {
  triangles: number;
  innerVertices: number; // Vertices not on the boundary.
  innerEdges: number; // Edges with more than one triangle of this tile.
  nonmanifoldEdges: number; // Inner edges with more than two triangles.
  degenerateTriangles: number;
  components: number; // Components of this tile alone.
  // The boundary vertices: lattice coordinates, number in the tile, number of the component.
  positions: Int32Array;
  vertices: Uint32Array;
  component: Uint32Array;
  edges: Uint32Array; // Pairs of boundary vertices, in the direction of their triangle.
}

// `marched`: the box in which the viewer marched samples, none of them void, which ensures a manifold mesh.
export function boundaryOf(mesh: LatticeMesh, marched: LatticeBox | null = null): TileBoundary {
  const vertices = mesh.positions.length / 3;
  const components = new Components(vertices);
  for (let t = 0; t < mesh.triangles.length; t += 3) {
    components.join(mesh.triangles[t], mesh.triangles[t + 1]);
    components.join(mesh.triangles[t + 1], mesh.triangles[t + 2]);
  }
  const { counts, degenerate } = marched ? { counts: marchedEdges(mesh, marched), degenerate: 0 } : comparedEdges(mesh);
  const numbers = new Map<number, number>(); // The tile's vertex -> the boundary's.
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

function comparedEdges({ positions, triangles }: LatticeMesh): { counts: EdgeCounts; degenerate: number } {
  const directed = new Uint32Array(2 * triangles.length);
  let used = 0;
  for (let t = 0; t < triangles.length; t += 3) {
    const a = triangles[t];
    const b = triangles[t + 1];
    const c = triangles[t + 2];
    if (a === b || b === c || c === a) continue;
    directed[used] = directed[used + 5] = a;
    directed[used + 1] = directed[used + 2] = b;
    directed[used + 3] = directed[used + 4] = c;
    used += 6;
  }
  const counts = countEdges(directed.subarray(0, used), positions.length / 3);
  return { counts, degenerate: (triangles.length - used / 2) / 3 };
}

// An edge lies in a face of the box if both ends do. Then it lies in a face of one tetrahedron, which has no neighbor
// there, and has one triangle; every other edge has two.
function marchedEdges({ positions, triangles }: LatticeMesh, box: LatticeBox): EdgeCounts {
  const faces = new Uint8Array(positions.length / 3); // One bit per face of the box that contains the vertex.
  for (let v = 0; v < faces.length; ++v) {
    for (let axis = 0; axis < 3; ++axis) {
      const at = positions[3 * v + axis];
      if (at === box[axis]) faces[v] |= 1 << axis;
      if (at === box[axis + 3]) faces[v] |= 8 << axis;
    }
  }
  const open: number[] = [];
  for (let t = 0; t < triangles.length; t += 3) {
    for (let corner = 0; corner < 3; ++corner) {
      const from = triangles[t + corner];
      const to = triangles[t + ((corner + 1) % 3)];
      if ((faces[from] & faces[to]) !== 0) open.push(from, to);
    }
  }
  return { edges: (triangles.length + open.length / 2) / 2, nonmanifold: 0, open: Uint32Array.from(open) };
}
