// Joins tiles by their boundaries: gives the same counts as common/mesh/mesh_checks.hpp for the welded mesh, in time
// proportional to the boundaries.
//
// Assumes that a vertex not on a boundary belongs to one tile only. This holds for every isosurface on the lattice: a
// vertex lies inside one edge of the framework, and its triangles surround it.
import { Components } from "./components";
import { countEdges } from "./edge_uses";
import { PointNumbers } from "./point_numbers";
import type { TileBoundary } from "./tile_boundary";

// Where a surface may end: on the faces of a box, or up to `inset` lattice steps inside it.
export interface DataBorder {
  low: [number, number, number];
  high: [number, number, number];
  inset: number;
  anywhere: boolean; // The data have void samples, at any of which a surface may end.
}

export interface MeshTopology {
  vertices: number;
  edges: number;
  triangles: number;
  eulerCharacteristic: number;
  components: number;
  borderEdges: number; // Edges of one triangle on the data's border.
  openEdges: number; // Edges of one triangle elsewhere: cracks.
  nonmanifoldEdges: number;
  degenerateTriangles: number;
}

export function isSound(found: MeshTopology): boolean {
  return found.openEdges === 0 && found.nonmanifoldEdges === 0 && found.degenerateTriangles === 0;
}

export interface BoundaryMatcher {
  topology: MeshTopology;
  // For each tile, the numbers of its boundary vertices among those of all boundaries.
  numbers: Uint32Array[];
  rimVertices: number;
}

export function matchBoundaries(boundaries: readonly TileBoundary[], border: DataBorder): BoundaryMatcher {
  const points = new PointNumbers(boundaries.reduce((n, boundary) => n + boundary.vertices.length / 2, 16));
  const numbers = boundaries.map((boundary) => {
    const own = new Uint32Array(boundary.vertices.length);
    for (let i = 0; i < own.length; ++i) {
      const p = boundary.positions;
      own[i] = points.numberOf(p[3 * i], p[3 * i + 1], p[3 * i + 2]);
    }
    return own;
  });
  const directed = new Uint32Array(boundaries.reduce((n, boundary) => n + boundary.edges.length, 0));
  let used = 0;
  boundaries.forEach((boundary, tile) => {
    for (const vertex of boundary.edges) directed[used++] = numbers[tile][vertex];
  });
  const seams = countEdges(directed, points.size);
  const coordinates = points.coordinates();
  let borderEdges = 0;
  for (let e = 0; e < seams.open.length; e += 2) {
    borderEdges += isOnBorder(border, coordinates, seams.open[e], seams.open[e + 1]) ? 1 : 0;
  }
  const sum = (of: (boundary: TileBoundary) => number) => boundaries.reduce((n, boundary) => n + of(boundary), 0);
  const vertices = sum((boundary) => boundary.innerVertices) + points.size;
  const edges = sum((boundary) => boundary.innerEdges) + seams.edges;
  const triangles = sum((boundary) => boundary.triangles);
  return {
    topology: {
      vertices,
      edges,
      triangles,
      eulerCharacteristic: vertices - edges + triangles,
      components: countComponents(boundaries, numbers, points.size),
      borderEdges,
      openEdges: seams.open.length / 2 - borderEdges,
      nonmanifoldEdges: sum((boundary) => boundary.nonmanifoldEdges) + seams.nonmanifold,
      degenerateTriangles: sum((boundary) => boundary.degenerateTriangles),
    },
    numbers,
    rimVertices: points.size,
  };
}

// Components of tiles that share a vertex are one.
function countComponents(boundaries: readonly TileBoundary[], numbers: Uint32Array[], shared: number): number {
  const firstOf = boundaries.map(() => 0);
  let total = shared;
  boundaries.forEach((boundary, tile) => {
    firstOf[tile] = total;
    total += boundary.components;
  });
  const sets = new Components(total);
  boundaries.forEach((boundary, tile) => {
    numbers[tile].forEach((vertex, i) => sets.join(vertex, firstOf[tile] + boundary.component[i]));
  });
  return sets.count();
}

function isOnBorder(border: DataBorder, points: Int32Array, a: number, b: number): boolean {
  if (border.anywhere) return true;
  for (let axis = 0; axis < 3; ++axis) {
    const a1 = points[3 * a + axis];
    const b1 = points[3 * b + axis];
    if (Math.max(a1, b1) <= border.low[axis] + border.inset) return true;
    if (Math.min(a1, b1) >= border.high[axis] - border.inset) return true;
  }
  return false;
}
