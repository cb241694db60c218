import { matchBoundaries } from "../../../client/web/src/mesh/boundary_matcher";
import { cutLine } from "../../../client/web/src/mesh/cut";
import { nearestTriangle } from "../../../client/web/src/mesh/nearest_component";
import { boundaryOf } from "../../../client/web/src/mesh/tile_boundary";
import { drawnComponents, withDrawnComponents } from "../../../client/web/src/mesh/tile_components";
import type { LatticeMesh } from "../../../client/web/src/mesh/tile_mesh";
import { weldedInWorld } from "../../../client/web/src/mesh/welded_mesh";
import { manifestTile } from "../../../client/web/src/stream/step_checks";
import { found, messages, tileFrom } from "./golden_stream";

type Corner = [number, number, number];

// The eight triangles of an octahedron, counterclockwise from outside.
function octahedron([x, y, z]: Corner, radius: number): Corner[][] {
  const step = (i: number, axis: number) => (i === axis ? radius : i === axis + 3 ? -radius : 0);
  const at = (i: number): Corner => [x + step(i, 0), y + step(i, 1), z + step(i, 2)];
  return [
    [0, 1, 2],
    [1, 3, 2],
    [3, 4, 2],
    [4, 0, 2],
    [1, 0, 5],
    [3, 1, 5],
    [4, 3, 5],
    [0, 4, 5],
  ].map((face) => face.map(at));
}

function meshOf(faces: Corner[][]): LatticeMesh {
  const names = [...new Set(faces.flat().map((corner) => corner.join()))];
  return {
    positions: Int32Array.from(names.flatMap((name) => name.split(",").map(Number))),
    triangles: Uint32Array.from(faces.flat().map((corner) => names.indexOf(corner.join()))),
    normals: null,
  };
}

function tileOf(mesh: LatticeMesh) {
  const positions = Float32Array.from(mesh.positions);
  const triangles = Uint16Array.from(mesh.triangles);
  return { positions, triangles, normals: new Int16Array((4 * positions.length) / 3), sums: null, boundary: boundaryOf(mesh) };
}

// Two small components and a large one, whose bounding boxes have diagonals of 2, 4 and 40 times sqrt(3).
const faces = [octahedron([10, 10, 10], 1), octahedron([100, 100, 100], 20), octahedron([20, 10, 10], 2)].flat();
// Assigns faces to two tiles by their middles, so that the tiles meet along boundaries.
function cutAt(x: number) {
  const middle = (face: Corner[]) => (face[0][0] + face[1][0] + face[2][0]) / 3;
  return [faces.filter((face) => middle(face) < x), faces.filter((face) => middle(face) >= x)].map((part) => tileOf(meshOf(part)));
}

describe("TileComponents", () => {
  test("DoNotDependOnTheTiling", () => {
    for (const tiles of [[tileOf(meshOf(faces))], cutAt(10), cutAt(20), cutAt(100), faces.map((face) => tileOf(meshOf([face])))]) {
      expect(drawnComponents(tiles, { leastDiagonal: 0 })).toMatchObject({ components: 3, shown: 3, triangles: 24, tiles: tiles.map(() => null) });
      expect(drawnComponents(tiles, { leastDiagonal: 5 })).toMatchObject({ components: 3, shown: 2, triangles: 16 });
      const large = drawnComponents(tiles, { leastDiagonal: 10 });
      expect(large).toMatchObject({ components: 3, shown: 1, triangles: 8, largest: [80, 80, 80, 120, 120, 120] });
      expect(drawnComponents(tiles, { leastDiagonal: 100 })).toMatchObject({ components: 3, shown: 0, triangles: 0, largest: null });
    }
  });

  test("HideTheNearestComponent", () => {
    for (const tiles of [[tileOf(meshOf(faces))], cutAt(10), cutAt(100)]) {
      // The middle of a face of the large component. Vertices of the small ones are nearer than its own.
      const onPlanet = [100 - 20 / 3, 100 - 20 / 3, 100 - 20 / 3];
      expect(drawnComponents(tiles, { leastDiagonal: 0, hidden: [onPlanet] })).toMatchObject({
        components: 3,
        shown: 2,
        triangles: 16,
        largest: [18, 8, 8, 22, 12, 12],
      });
      expect(drawnComponents(tiles, { leastDiagonal: 0, hidden: [onPlanet, [10, 10, 12]] })).toMatchObject({ shown: 1, triangles: 8 });
      expect(drawnComponents(tiles, { leastDiagonal: 10, hidden: [onPlanet] })).toMatchObject({ shown: 0, triangles: 0, largest: null });
      const [left] = withDrawnComponents(tiles, { leastDiagonal: 0, hidden: [onPlanet] });
      expect(left.triangles.length % 3).toBe(0);
    }
  });

  test("MeasureDistancesToTriangles", () => {
    // A small triangle that is nearer to the place than all vertices of the large triangle below it.
    const large = tileOf(
      meshOf([
        [
          [0, 0, 0],
          [90, 0, 0],
          [0, 90, 0],
        ],
      ]),
    );
    const speck = tileOf(
      meshOf([
        [
          [30, 30, 6],
          [31, 30, 6],
          [30, 31, 6],
        ],
      ]),
    );
    expect(drawnComponents([large, speck], { leastDiagonal: 0, hidden: [[30, 30, 2]] }).tiles.map((part) => part?.shown ?? null)).toEqual([0, null]);
    expect(drawnComponents([large, speck], { leastDiagonal: 0, hidden: [[30, 30, 5]] }).tiles.map((part) => part?.shown ?? null)).toEqual([null, 0]);
  });

  test("KeepOnlyTheLargest", () => {
    for (const tiles of [[tileOf(meshOf(faces))], cutAt(10), cutAt(100)]) {
      const alone = drawnComponents(tiles, { leastDiagonal: 0, largestOnly: true });
      expect(alone).toMatchObject({ components: 3, shown: 1, triangles: 8, largest: [80, 80, 80, 120, 120, 120] });
      const next = drawnComponents(tiles, { leastDiagonal: 0, hidden: [[100, 100, 80]], largestOnly: true });
      expect(next).toMatchObject({ components: 3, shown: 1, largest: [18, 8, 8, 22, 12, 12] });
      expect(drawnComponents(tiles, { leastDiagonal: 100, largestOnly: true })).toMatchObject({ shown: 0, largest: null });
    }
  });

  test("KeepOneOfEqualSize", () => {
    const twins = [octahedron([10, 10, 10], 5), octahedron([50, 10, 10], 5)];
    const alike = { leastDiagonal: 0, largestOnly: true };
    expect(
      drawnComponents(
        twins.map((one) => tileOf(meshOf(one))),
        alike,
      ),
    ).toMatchObject({ components: 2, shown: 1, triangles: 8 });
    // Keeps the one with more triangles.
    const [one, other] = [tileOf(meshOf(twins[0].slice(0, 7))), tileOf(meshOf(twins[1]))];
    expect(drawnComponents([one, other], alike)).toMatchObject({ shown: 1, triangles: 8, largest: [45, 5, 5, 55, 15, 15] });
  });

  test("FindTheNearestTriangle", () => {
    const large = {
      id: "large",
      ...tileOf(
        meshOf([
          [
            [0, 0, 0],
            [90, 0, 0],
            [0, 90, 0],
          ],
        ]),
      ),
    };
    const specks = {
      id: "specks",
      ...tileOf(
        meshOf([
          [
            [80, 80, 6],
            [81, 80, 6],
            [80, 81, 6],
          ],
          [
            [30, 30, 6],
            [31, 30, 6],
            [30, 31, 6],
          ],
        ]),
      ),
    };
    expect(nearestTriangle([large, specks], [30, 30, 2])).toEqual({ id: "large", triangle: 0 });
    expect(nearestTriangle([large, specks], [30, 30, 5])).toEqual({ id: "specks", triangle: 1 });
    expect(nearestTriangle([], [0, 0, 0])).toBeNull();
  });

  test("KeepComponentsOfTheMinimumDiagonal", () => {
    const box = tileOf(
      meshOf([
        [
          [0, 0, 0],
          [2, 3, 0],
          [2, 0, 6],
        ],
      ]),
    ); // The diagonal of 2, 3 and 6 is 7.
    expect(drawnComponents([box], { leastDiagonal: 7 }).shown).toBe(1);
    expect(drawnComponents([box], { leastDiagonal: 7 * (1 + Number.EPSILON) }).shown).toBe(0);
  });

  test("PermuteTheTrianglesOfTiles", () => {
    const tiles = cutAt(100);
    const corners = (triangles: Iterable<number>) => {
      const all = [...triangles];
      return Array.from({ length: all.length / 3 }, (_, t) => all.slice(3 * t, 3 * t + 3).join()).sort();
    };
    const { tiles: parted } = drawnComponents(tiles, { leastDiagonal: 10 });
    expect(parted[0]!.shown).toBe(4);
    expect(corners(parted[0]!.triangles)).toEqual(corners(tiles[0].triangles));
    expect(parted[1]).toBeNull();
  });

  test("AreOmittedFromFilesAndCuts", () => {
    const tiles = withDrawnComponents(cutAt(100), { leastDiagonal: 10 });
    const across = { normal: [0, 0, 1], constant: -10 }; // Through the small components, below the large one.
    expect(cutLine(cutAt(100), across).length).toBeGreaterThan(0);
    expect(cutLine(tiles, across)).toHaveLength(0);
    const { positions, triangles } = weldedInWorld(tiles, [1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0]);
    expect([positions.length / 3, triangles.length / 3]).toEqual([6, 8]);
  });

  test("MatchTheRecordedTopology", async () => {
    const all = messages();
    const begin = all.find(({ case: kind }) => kind === "stepBegin")!.value as { tiles: Parameters<typeof manifestTile>[0][] };
    const payloads = all.filter(({ case: kind }) => kind === "tile").map(({ value }) => (value as { payload: Uint8Array }).payload);
    const meshes = await Promise.all(begin.tiles.map((entry, i) => tileFrom(payloads[i], manifestTile(entry))));
    const tiles = meshes.map((mesh) => ({ ...tileOf(mesh), triangles: mesh.triangles }));
    const border = { low: [0, 0, 0] as Corner, high: [1, 1, 1] as Corner, inset: 0, anywhere: true };
    expect(
      matchBoundaries(
        tiles.map(({ boundary }) => boundary),
        border,
      ).topology.components,
    ).toBe(found.components);
    expect(drawnComponents(tiles, { leastDiagonal: 0 })).toMatchObject({ components: found.components, triangles: found.triangles });
    const { largest } = drawnComponents(tiles, { leastDiagonal: 32 });
    expect(largest).not.toBeNull();
    expect(Math.max(...largest!) - Math.min(...largest!)).toBeLessThanOrEqual(32 * 32);
  });
});
