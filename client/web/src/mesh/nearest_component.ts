// Finds the component nearest to a place, which identifies a picked component in any step of the surface.
import { cross, dot, minus } from "../shared/vectors";
import type { LatticeBox } from "./tile_mesh";

type Point = readonly number[];

interface Tile {
  positions: Float32Array;
  triangles: Uint16Array | Uint32Array;
}

// `componentOf`: the component of a vertex of a tile; `boxes`: around each component. Returns null if there is no
// triangle. The time is proportional to the triangles of the components whose boxes are nearer than the result.
export function nearestComponent(
  tiles: readonly Tile[],
  componentOf: (tile: number, vertex: number) => number,
  boxes: readonly LatticeBox[],
  place: Point,
): number | null {
  const toBox = boxes.map((box) => distanceToBox(box, place));
  let nearest: number | null = null;
  let least = Infinity;
  tiles.forEach(({ positions: p, triangles }, tile) => {
    const corner = (vertex: number): Point => [p[3 * vertex] - place[0], p[3 * vertex + 1] - place[1], p[3 * vertex + 2] - place[2]];
    for (let t = 0; t < triangles.length; t += 3) {
      const component = componentOf(tile, triangles[t]);
      if (toBox[component] >= least) continue;
      const distance = distanceToTriangle(corner(triangles[t]), corner(triangles[t + 1]), corner(triangles[t + 2]));
      if (distance >= least) continue;
      least = distance;
      nearest = component;
    }
  });
  return nearest;
}

// Returns the triangle nearest to a place; null: there is none.
export function nearestTriangle(tiles: readonly (Tile & { id: string })[], place: Point): { id: string; triangle: number } | null {
  let nearest: { id: string; triangle: number } | null = null;
  let least = Infinity;
  for (const { id, positions: p, triangles } of tiles) {
    const corner = (vertex: number): Point => [p[3 * vertex] - place[0], p[3 * vertex + 1] - place[1], p[3 * vertex + 2] - place[2]];
    for (let t = 0; t < triangles.length; t += 3) {
      const corners = [triangles[t], triangles[t + 1], triangles[t + 2]];
      if (isBeyond(p, corners, place, least)) continue;
      const distance = distanceToTriangle(corner(corners[0]), corner(corners[1]), corner(corners[2]));
      if (distance >= least) continue;
      least = distance;
      nearest = { id, triangle: t / 3 };
    }
  }
  return nearest;
}

// Returns whether the triangle is farther away than `distance` along some axis: a cheap test that most triangles pass.
function isBeyond(p: Float32Array, [a, b, c]: readonly number[], place: Point, distance: number): boolean {
  for (let axis = 0; axis < 3; ++axis) {
    const [x, y, z] = [p[3 * a + axis] - place[axis], p[3 * b + axis] - place[axis], p[3 * c + axis] - place[axis]];
    if ((x >= distance && y >= distance && z >= distance) || (x <= -distance && y <= -distance && z <= -distance)) return true;
  }
  return false;
}

function distanceToBox(box: LatticeBox, place: Point): number {
  return Math.hypot(...[0, 1, 2].map((axis) => Math.max(box[axis] - place[axis], 0, place[axis] - box[axis + 3])));
}

// Returns the distance from the origin to the triangle's plane if the projection is inside, else to the nearest edge.
function distanceToTriangle(a: Point, b: Point, c: Point): number {
  const normal = cross(minus(b, a), minus(c, a));
  const length = Math.hypot(...normal);
  const isInside = [
    [a, b],
    [b, c],
    [c, a],
  ].every(([from, to]) => dot(cross(minus(to, from), from), normal) <= 0);
  if (length > 0 && isInside) return Math.abs(dot(normal, a)) / length;
  return Math.min(distanceToEdge(a, b), distanceToEdge(b, c), distanceToEdge(c, a));
}

function distanceToEdge(a: Point, b: Point): number {
  const along = minus(b, a);
  const squared = dot(along, along);
  const share = squared > 0 ? Math.min(1, Math.max(0, -dot(a, along) / squared)) : 0;
  return Math.hypot(...a.map((value, axis) => value + share * along[axis]));
}
