// The connected components of a tiled surface, and the surface without some of them: noise in scans causes thousands of
// small ones. Gives the same result as common/mesh/components.hpp for the welded mesh: triangles with a common vertex
// are connected, and the size of a component is the diagonal of its bounding box.
//
// The components within a tile are computed once; joining them takes time proportional to the boundaries.
import { Components } from "./components";
import { nearestComponent } from "./nearest_component";
import { PointNumbers } from "./point_numbers";
import type { TileBoundary } from "./tile_boundary";
import type { LatticeBox } from "./tile_mesh";

export type Triangles = Uint16Array | Uint32Array;

interface Tile {
  positions: Float32Array; // Lattice coordinates.
  triangles: Triangles;
  boundary: Pick<TileBoundary, "positions" | "vertices">;
}

export interface DrawnComponents {
  components: number; // All components of the surface.
  shown: number; // Drawn components.
  triangles: number; // Drawn triangles.
  largest: LatticeBox | null; // The box of the drawn component with the longest diagonal; null: none is drawn.
  // Per tile, its triangles with those of drawn components first, and the number of these; null: all are drawn.
  tiles: ({ triangles: Triangles; shown: number } | null)[];
}

// Selects the drawn components: those whose bounding box has a diagonal of at least `leastDiagonal` lattice steps,
// without those nearest to the `hidden` places; with `largestOnly` only the largest of them.
export interface DrawnChoice {
  leastDiagonal: number;
  hidden?: readonly (readonly number[])[];
  largestOnly?: boolean;
}

export function drawnComponents(tiles: readonly Tile[], { leastDiagonal, hidden = [], largestOnly = false }: DrawnChoice): DrawnComponents {
  const { ofTile, boxes } = joinedComponents(tiles);
  const diagonals = boxes.map(diagonalOf);
  let isShown = diagonals.map((diagonal) => diagonal >= leastDiagonal);
  for (const place of hidden) {
    const component = nearestComponent(tiles, (tile, vertex) => ofTile[tile][componentsOf(tiles[tile]).ofVertex[vertex]], boxes, place);
    if (component !== null) isShown[component] = false;
  }
  const largest = largestOf(tiles, ofTile, diagonals, isShown);
  if (largestOnly) isShown = isShown.map((_, component) => component === largest);
  const parted = tiles.map((tile, i) => partedTriangles(tile, (component) => isShown[ofTile[i][component]]));
  return {
    components: boxes.length,
    shown: isShown.filter(Boolean).length,
    triangles: tiles.reduce((n, { triangles }, i) => n + (parted[i]?.shown ?? triangles.length / 3), 0),
    largest: boxes[largest] ?? null,
    tiles: parted,
  };
}

// Returns the shown component with the longest diagonal, among equals that with the most triangles; -1: none.
function largestOf(tiles: readonly Tile[], ofTile: readonly Uint32Array[], diagonals: readonly number[], isShown: readonly boolean[]): number {
  const longest = diagonals.reduce((longest, diagonal, i) => (isShown[i] ? Math.max(longest, diagonal) : longest), -1);
  const candidates = [...diagonals.keys()].filter((i) => isShown[i] && diagonals[i] === longest);
  if (candidates.length <= 1) return candidates[0] ?? -1;
  const counts = new Uint32Array(diagonals.length);
  tiles.forEach((tile, i) => {
    const { ofVertex } = componentsOf(tile);
    for (let t = 0; t < tile.triangles.length; t += 3) ++counts[ofTile[i][ofVertex[tile.triangles[t]]]];
  });
  return candidates.reduce((best, i) => (counts[i] > counts[best] ? i : best));
}

// Returns the tiles with only the triangles of drawn components.
export function withDrawnComponents<T extends Tile>(tiles: readonly T[], choice: DrawnChoice): T[] {
  const { tiles: parted } = drawnComponents(tiles, choice);
  return tiles.map((tile, i) => {
    const part = parted[i];
    return part ? { ...tile, triangles: part.triangles.subarray(0, 3 * part.shown) } : tile;
  });
}

// The components of a single tile.
interface OwnComponents {
  ofVertex: Uint32Array;
  boxes: LatticeBox[];
}

const found = new WeakMap<Float32Array, OwnComponents>(); // By a tile's positions.

function componentsOf({ positions: p, triangles }: Tile): OwnComponents {
  const before = found.get(p);
  if (before) return before;
  const sets = new Components(p.length / 3);
  for (let t = 0; t < triangles.length; t += 3) {
    sets.join(triangles[t], triangles[t + 1]);
    sets.join(triangles[t + 1], triangles[t + 2]);
  }
  const ofVertex = new Uint32Array(p.length / 3);
  const boxes: LatticeBox[] = [];
  for (let v = 0; v < ofVertex.length; ++v) {
    const root = sets.root(v); // The smallest vertex of its set, which comes first.
    ofVertex[v] = root === v ? boxes.push(emptyBox()) - 1 : ofVertex[root];
    const box = boxes[ofVertex[v]];
    for (let axis = 0; axis < 3; ++axis) {
      const at = p[3 * v + axis];
      if (at < box[axis]) box[axis] = at;
      if (at > box[axis + 3]) box[axis + 3] = at;
    }
  }
  const own = { ofVertex, boxes };
  found.set(p, own);
  return own;
}

// Joins components of tiles that share a vertex. Returns, for each tile, the surface's component of each of its own,
// and the boxes of the surface's components in order of appearance.
function joinedComponents(tiles: readonly Tile[]): { ofTile: Uint32Array[]; boxes: LatticeBox[] } {
  const own = tiles.map(componentsOf);
  const firstOf: number[] = [];
  let total = 0;
  for (const { boxes } of own) {
    firstOf.push(total);
    total += boxes.length;
  }
  const sets = new Components(total);
  const points = new PointNumbers(tiles.reduce((n, { boundary }) => n + boundary.vertices.length / 2, 16));
  const firstAt: number[] = []; // By point, the first component found there.
  tiles.forEach(({ boundary: { positions: p, vertices } }, tile) => {
    vertices.forEach((vertex, i) => {
      const point = points.numberOf(p[3 * i], p[3 * i + 1], p[3 * i + 2]);
      const component = firstOf[tile] + own[tile].ofVertex[vertex];
      if (point === firstAt.length) firstAt.push(component);
      else sets.join(firstAt[point], component);
    });
  });
  const boxes: LatticeBox[] = [];
  const numbers = new Uint32Array(total);
  const ofTile = own.map((one, tile) => {
    return Uint32Array.from(one.boxes, (box, i) => {
      const component = firstOf[tile] + i;
      const root = sets.root(component);
      numbers[component] = root === component ? boxes.push(emptyBox()) - 1 : numbers[root];
      extend(boxes[numbers[component]], box);
      return numbers[component];
    });
  });
  return { ofTile, boxes };
}

function partedTriangles(tile: Tile, isShown: (component: number) => boolean): DrawnComponents["tiles"][number] {
  const { ofVertex, boxes } = componentsOf(tile);
  if (boxes.every((_, component) => isShown(component))) return null;
  const { triangles } = tile;
  const parted = triangles.slice();
  let first = 0;
  let last = triangles.length;
  for (let t = 0; t < triangles.length; t += 3) {
    let to = first;
    if (isShown(ofVertex[triangles[t]])) first += 3;
    else to = last -= 3;
    for (let corner = 0; corner < 3; ++corner) parted[to + corner] = triangles[t + corner];
  }
  return { triangles: parted, shown: first / 3 };
}

function emptyBox(): LatticeBox {
  return [Infinity, Infinity, Infinity, -Infinity, -Infinity, -Infinity];
}

function extend(box: LatticeBox, by: LatticeBox): void {
  for (let axis = 0; axis < 3; ++axis) {
    box[axis] = Math.min(box[axis], by[axis]);
    box[axis + 3] = Math.max(box[axis + 3], by[axis + 3]);
  }
}

// The root of an exact sum: rounded once, identically on all machines.
function diagonalOf([x0, y0, z0, x1, y1, z1]: LatticeBox): number {
  return Math.sqrt((x1 - x0) ** 2 + (y1 - y0) ** 2 + (z1 - z0) ** 2);
}
