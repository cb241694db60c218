// A tile whose cube touches finer ones: its tetrahedra are bisected where those have samples on a common edge, as in
// the paper's framework, so that the surface has no crack. Everywhere else they are those of its own spacing.
//
// Of the samples between those of the spacing, the middle of an edge belongs to the mesh if it lies in a finer cube, that of a face or
// of a cell if the middle of one of its edges does: then so do all that it was bisected from, in every tile alike.
import { infiniteSamples } from "../mesh/plain_box";
import { PointNumbers } from "../mesh/point_numbers";
import type { LatticeMesh, OctreeCube } from "../mesh/tile_mesh";
import type { Vec3 } from "../stream/dataset";
import { type CrossedCells, cellsOf } from "./crossed_cells";
import { BrickSet } from "./field_samples";
import { coarseExtent, coarseSpacing, indexIn } from "./level_extents";
import type { LevelCube } from "./view_levels";

type Point = readonly [x: number, y: number, z: number, value: number]; // A grid point.

const paths = [
  [0, 1],
  [0, 2],
  [1, 0],
  [1, 2],
  [2, 0],
  [2, 1],
]; // The axes of the first two edges from a cell's even corner to its odd one.

export class MixedTile {
  private readonly finer: { low: Vec3; high: Vec3 }[];
  private readonly outside: number;
  private points!: PointNumbers; // What mesh() makes.
  private triangles!: number[];
  private samples!: (x: number, y: number, z: number) => number;

  // `finer`: the cubes of half the spacing that touch this one.
  constructor(
    private readonly crossed: CrossedCells,
    private readonly leaf: LevelCube,
    finer: readonly OctreeCube[],
    private readonly resolution: number,
  ) {
    const { outside } = crossed.volume.info;
    this.outside = outside === undefined ? Number.NaN : Math.fround(outside);
    this.finer = finer.map(({ exponent, x, y, z }) => {
      const side = 2 ** exponent;
      return { low: [x * side, y * side, z * side], high: [(x + 1) * side, (y + 1) * side, (z + 1) * side] };
    });
  }

  // The bricks that mesh() needs.
  get bricks(): BrickSet {
    const { info } = this.crossed.volume;
    const bricks = new BrickSet(this.crossed.volume);
    this.eachCrossed((cell) => {
      if (this.leaf.spacing === coarseSpacing && !this.besideFiner(cell, coarseSpacing).length) return;
      const first = cell.map((at) => Math.max(0, at - info.margin)) as Vec3;
      const last = cell.map((at, axis) => Math.min(info.dims[axis] - 1, at - info.margin + coarseSpacing)) as Vec3;
      for (let i = 0; i < 8; ++i) bricks.add(...([0, 1, 2].map((axis) => ((i >> axis) & 1 ? last[axis] : first[axis])) as Vec3));
    });
    return bricks;
  }

  async mesh(): Promise<LatticeMesh> {
    const { spacing } = this.leaf;
    this.samples = await this.bricks.samples();
    this.points = new PointNumbers(1 << 12);
    this.triangles = [];
    this.eachCrossed(([x, y, z]) => {
      for (let k = z; k < z + coarseSpacing; k += spacing) {
        for (let j = y; j < y + coarseSpacing; j += spacing) for (let i = x; i < x + coarseSpacing; i += spacing) this.marchCell([i, j, k]);
      }
    });
    return { positions: this.points.coordinates(), triangles: Uint32Array.from(this.triangles), normals: null };
  }

  // Visits the lowest corners of crossed cells.
  private eachCrossed(act: (corner: Vec3) => void): void {
    this.crossed.visit(cellsOf(this.leaf.cube), (x, y, z) => {
      act([coarseSpacing * x, coarseSpacing * y, coarseSpacing * z]);
      return false;
    });
  }

  private besideFiner(low: Vec3, side: number): { low: Vec3; high: Vec3 }[] {
    return this.finer.filter((cube) => low.every((at, axis) => at <= cube.high[axis] && at + side >= cube.low[axis]));
  }

  private marchCell(low: Vec3): void {
    const { spacing } = this.leaf;
    const beside = this.besideFiner(low, spacing);
    const isFiner = (x: number, y: number, z: number) =>
      beside.some((cube) => x >= cube.low[0] && x <= cube.high[0] && y >= cube.low[1] && y <= cube.high[1] && z >= cube.low[2] && z <= cube.high[2]);
    const isEven = low.map((at) => (at / spacing) % 2 === 0);
    const even = this.point(low[0] + (isEven[0] ? 0 : spacing), low[1] + (isEven[1] ? 0 : spacing), low[2] + (isEven[2] ? 0 : spacing));
    const along = (from: Point, ...axes: number[]) =>
      this.point(...([0, 1, 2].map((axis) => from[axis] + (axes.includes(axis) ? (isEven[axis] ? spacing : -spacing) : 0)) as Vec3));
    const odd = along(even, 0, 1, 2);
    const hasCenter = beside.length > 0 && edgesOf(low, spacing).some((middle) => isFiner(...middle));
    const center = hasCenter ? this.middle(even, odd) : null;
    for (const [i, j] of paths) {
      const [one, two] = [along(even, i), along(even, i, j)];
      if (!center) this.march(even, one, two, odd);
      else for (const face of [[even, one, two] as const, [one, two, odd] as const]) this.marchFace(...face, center, isFiner);
    }
  }

  // Marches the tetrahedron between half a face of the cell, with a right angle at `corner`, and its center.
  private marchFace(from: Point, corner: Point, to: Point, center: Point, isFiner: (x: number, y: number, z: number) => boolean): void {
    const opposite = [0, 1, 2].map((axis) => from[axis] + to[axis] - corner[axis]) as Vec3;
    const hasMiddle = (a: Point | Vec3, b: Point | Vec3) => isFiner((a[0] + b[0]) / 2, (a[1] + b[1]) / 2, (a[2] + b[2]) / 2);
    const isSplit = [hasMiddle(from, corner), hasMiddle(corner, to)];
    if (!isSplit[0] && !isSplit[1] && !hasMiddle(to, opposite) && !hasMiddle(opposite, from)) return this.march(from, corner, to, center);
    const face = this.middle(from, to);
    for (const [at, [a, b]] of [[from, corner] as const, [corner, to] as const].entries()) {
      if (!isSplit[at]) {
        this.march(a, b, face, center);
        continue;
      }
      const edge = this.middle(a, b);
      this.march(a, edge, face, center);
      this.march(edge, b, face, center);
    }
  }

  // As common/codec/detail/cell_cases.cpp does.
  private march(...corners: [Point, Point, Point, Point]): void {
    const { isovalue } = this.crossed;
    const isPositive = (point: Point) => point[3] > isovalue;
    const positive = corners.filter(isPositive);
    if (positive.length === 0 || positive.length === 4 || corners.some(([, , , value]) => Number.isNaN(value))) return;
    if (corners.some(([, , , value]) => !Number.isFinite(value))) throw new Error(infiniteSamples);
    const [a, b, c, d] = [...positive, ...corners.filter((point) => !isPositive(point))];
    const edges = { 1: [a, b, a, c, a, d], 2: [a, c, a, d, b, d, b, c], 3: [d, a, d, b, d, c] }[positive.length]!;
    const vertices = Array.from({ length: edges.length / 2 }, (_, i) => this.vertex(edges[2 * i], edges[2 * i + 1]));
    if (determinant(a, b, c, d) < 0) vertices.reverse();
    for (let i = 2; i < vertices.length; ++i) this.triangles.push(vertices[0], vertices[i - 1], vertices[i]);
  }

  // As lattice_vertex in server/core does.
  private vertex(one: Point, other: Point): number {
    const isFirst = one[0] !== other[0] ? one[0] < other[0] : one[1] !== other[1] ? one[1] < other[1] : one[2] < other[2];
    const [from, to] = isFirst ? [one, other] : [other, one];
    const apart = [0, 1, 2].map((axis) => to[axis] - from[axis]);
    const length = Math.max(...apart.map(Math.abs));
    const steps = length * 2 ** this.resolution;
    const nearest = Math.trunc(((this.crossed.isovalue - from[3]) / (to[3] - from[3])) * steps + 0.5);
    const cut = Math.min(steps - 1, Math.max(1, nearest));
    const [x, y, z] = [0, 1, 2].map((axis) => from[axis] * 2 ** this.resolution + (apart[axis] / length) * cut);
    return this.points.numberOf(x, y, z);
  }

  private middle(a: Point, b: Point): Point {
    return this.point((a[0] + b[0]) / 2, (a[1] + b[1]) / 2, (a[2] + b[2]) / 2);
  }

  private point(x: number, y: number, z: number): Point {
    const { info, coarse } = this.crossed.volume;
    const at = [x - info.margin, y - info.margin, z - info.margin];
    if (!at.every((index, axis) => index >= 0 && index < info.dims[axis])) return [x, y, z, this.outside];
    const isCoarse = this.leaf.spacing === coarseSpacing && (x | y | z) % coarseSpacing === 0;
    const value = isCoarse ? coarse[indexIn(coarseExtent(info), x / coarseSpacing, y / coarseSpacing, z / coarseSpacing)] : this.samples(at[0], at[1], at[2]);
    return [x, y, z, value];
  }
}

// The middles of a cell's edges.
function edgesOf([x, y, z]: Vec3, side: number): Vec3[] {
  const half = side / 2;
  const ends = [0, side];
  return ends.flatMap((i) =>
    ends.flatMap((j): Vec3[] => [
      [x + half, y + i, z + j],
      [x + i, y + half, z + j],
      [x + i, y + j, z + half],
    ]),
  );
}

function determinant(a: Point, b: Point, c: Point, d: Point): number {
  const [p, q, r] = [b, c, d].map((point) => [0, 1, 2].map((axis) => point[axis] - a[axis]));
  return p[0] * (q[1] * r[2] - q[2] * r[1]) - p[1] * (q[0] * r[2] - q[2] * r[0]) + p[2] * (q[0] * r[1] - q[1] * r[0]);
}
