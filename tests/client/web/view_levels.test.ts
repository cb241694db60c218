// A surface that is too large for a page is fine near the eye and coarser elsewhere, and has no crack in between.
import { readFileSync } from "node:fs";

import { isSound, matchBoundaries } from "../../../client/web/src/mesh/boundary_matcher";
import { payloadHasher } from "../../../client/web/src/mesh/content_digest";
import { surfaceCounter } from "../../../client/web/src/mesh/plain_box";
import { type ShellMode, shellDecoder } from "../../../client/web/src/mesh/shell_decoder";
import { boundaryOf } from "../../../client/web/src/mesh/tile_boundary";
import { create, FrustumSchema, SampleType, ThresholdViewSchema } from "../../../client/web/src/protocol/messages";
import { CrossedCells } from "../../../client/web/src/static/crossed_cells";
import { cellExtent, coarseExtent, type Extent, sizeOf } from "../../../client/web/src/static/level_extents";
import type { PreparedVolume } from "../../../client/web/src/static/prepared_file";
import { brickSide } from "../../../client/web/src/static/sample_bricks";
import { SurfaceLevel, uniformCubes } from "../../../client/web/src/static/surface_level";
import { cubesByView, type LevelCube } from "../../../client/web/src/static/view_levels";
import { dataBorder, type Vec3 } from "../../../client/web/src/stream/dataset";
import { plain as named } from "./made_datasets";

const wasm = readFileSync(new URL("../../../common/codec/wasm/shell_decoder.wasm", import.meta.url));
const tools = (async () => ({ count: await surfaceCounter(wasm), hash: await payloadHasher() }))();
const cells = 8; // A side of a tile: the volumes are small.

type Field = (x: number, y: number, z: number) => number;
const waves: Field = (x, y, z) =>
  100 * (Math.sin(0.21 * x) * Math.cos(0.17 * y) + Math.sin(0.19 * y) * Math.cos(0.23 * z) + Math.sin(0.2 * z) * Math.cos(0.22 * x));
const rough: Field = (x, y, z) => waves(x, y, z) + 60 * Math.sin(1.3 * x + 0.7 * y) * Math.sin(1.1 * y - 0.9 * z);

// What a prepared file of these samples holds.
function volumeOf(field: Field, dims: Vec3, { margin = 35, outside }: { margin?: number; outside?: number } = {}): PreparedVolume {
  const info = {
    ...named("made"),
    type: SampleType.I16,
    dims,
    margin,
    outside,
    gridExponent: 7,
    voidSamples: 0n,
    spacing: [1, 1, 1],
    indexToWorld: [1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0],
  };
  const samples = Int16Array.from({ length: dims[0] * dims[1] * dims[2] }, (_, i) =>
    Math.round(field(i % dims[0], Math.floor(i / dims[0]) % dims[1], Math.floor(i / dims[0] / dims[1]))),
  );
  const value = (x: number, y: number, z: number) => samples[x + dims[0] * (y + dims[1] * z)];
  const filled = (extent: Extent, size: number, values: (place: Vec3) => number[]) => {
    const array = new Int16Array(size * sizeOf(extent));
    for (let i = 0; i < sizeOf(extent); ++i) {
      const [x, y] = extent.count;
      array.set(values([i % x, Math.floor(i / x) % y, Math.floor(i / x / y)].map((at) => at + extent.low) as Vec3), size * i);
    }
    return array;
  };
  const coarse = filled(coarseExtent(info), 1, (at) => [value(...(at.map((n) => 8 * n - margin) as Vec3))]);
  const ranges = filled(cellExtent(info), 2, (at) => {
    const inside = (n: number, axis: number) => Math.min(dims[axis] - 1, Math.max(0, n - margin));
    const [low, high] = [at.map((n, axis) => inside(8 * n, axis)), at.map((n, axis) => inside(8 * n + 8, axis))];
    let [least, greatest] = [Infinity, -Infinity];
    for (let z = low[2]; z <= high[2]; ++z) {
      for (let y = low[1]; y <= high[1]; ++y) {
        for (let x = low[0]; x <= high[0]; ++x) [least, greatest] = [Math.min(least, value(x, y, z)), Math.max(greatest, value(x, y, z))];
      }
    }
    return [least, greatest];
  });
  const counts = dims.map((n) => Math.ceil(n / brickSide)) as Vec3;
  const extent = (...at: Vec3) => at.map((n, axis) => Math.min(brickSide, dims[axis] - brickSide * n)) as Vec3;
  const brick = (index: number) => {
    const at: Vec3 = [index % counts[0], Math.floor(index / counts[0]) % counts[1], Math.floor(index / counts[0] / counts[1])];
    const [nx, ny, nz] = extent(...at);
    return Int16Array.from({ length: nx * ny * nz }, (_, i) =>
      value(16 * at[0] + (i % nx), 16 * at[1] + (Math.floor(i / nx) % ny), 16 * at[2] + Math.floor(i / nx / ny)),
    );
  };
  const bricks = {
    counts,
    extent,
    index: (x: number, y: number, z: number) => x + counts[0] * (y + counts[1] * z),
    unpack: async (wanted: number[]) => new Map(wanted.map((index) => [index, brick(index)])),
  };
  return { info, coarse, ranges, bricks } as unknown as PreparedVolume;
}

function viewFrom(eye: Vec3, lookAt: Vec3) {
  const frustum = create(FrustumSchema, { lookAt, up: [0, 0, 1], aspect: 1.5 });
  return create(ThresholdViewSchema, { eye, fieldOfView: 35, heightPixels: 600, tolerancePixels: 1, frustum });
}

async function tilesOf(crossed: CrossedCells, cubes: readonly LevelCube[]) {
  return (await new SurfaceLevel(crossed, 5, cubes).tiles(await tools, () => true))!;
}

// The topology of all tiles as a step of the viewer.
async function topologyOf(crossed: CrossedCells, cubes: readonly LevelCube[]) {
  const spacing = Math.max(...cubes.map((one) => one.spacing));
  const decode = await shellDecoder(wasm);
  const mode: ShellMode = { values: 0, levelsPerOctave: 0, spacing };
  const boundaries = (await tilesOf(crossed, cubes)).map((tile) => {
    const { mesh, box } = decode(tile.payload, tile, mode, 5);
    return boundaryOf(mesh, box);
  });
  return matchBoundaries(boundaries, dataBorder(crossed.volume.info, 5, spacing > 1 ? spacing / 2 : 0, spacing)).topology;
}

const spacingsOf = (cubes: readonly LevelCube[]) => [...new Set(cubes.map(({ spacing }) => spacing))].sort((a, b) => a - b);

describe("SpacingsByView", () => {
  test.each([
    ["waves", waves, [41, 41, 41] as Vec3, {}],
    ["rough", rough, [41, 41, 41] as Vec3, {}],
    ["with another margin", rough, [30, 37, 33] as Vec3, { margin: 38 }],
    ["closed outside", rough, [42, 31, 34] as Vec3, { margin: 37, outside: -400 }],
  ])("HaveNoCrack: %s", async (_, field, dims, placed) => {
    const volume = volumeOf(field, dims, placed);
    const places: [Vec3, number, number][] = [
      [[20, 18, 21], -20.5, 10],
      [[60, 20, 25], 60.5, 10],
    ];
    for (const [eye, isovalue, bricks] of places) {
      const crossed = new CrossedCells(volume, isovalue);
      const cubes = cubesByView(crossed, viewFrom(eye, [20, 20, 20]), bricks, cells);
      expect(spacingsOf(cubes).length).toBeGreaterThan(1);
      const topology = await topologyOf(crossed, cubes);
      expect(topology.triangles).toBeGreaterThan(300);
      expect(isSound(topology), `${eye}: ${JSON.stringify(topology)}`).toBe(true);
    }
  });

  test("CloseASurfaceThatIsClosed", async () => {
    const ball: Field = (x, y, z) => 20 * (48 - Math.hypot(x - 53, y - 52, z - 51));
    const crossed = new CrossedCells(volumeOf(ball, [104, 104, 104], { margin: 5 }), 3.5);
    const cubes = cubesByView(crossed, viewFrom([2, 2, 2], [53, 52, 51]), 60, cells);
    expect(spacingsOf(cubes)).toEqual([1, 2, 4, 8]);
    expect(await topologyOf(crossed, cubes)).toMatchObject({ components: 1, eulerCharacteristic: 2, borderEdges: 0, openEdges: 0 });
  });

  test("AreThoseOfTheFullSurfaceNearTheEye", async () => {
    const crossed = new CrossedCells(volumeOf(rough, [41, 41, 41]), 10.5);
    const cubes = cubesByView(crossed, viewFrom([0, 0, 0], [20, 20, 20]), 10, cells);
    const near = cubes.filter(({ spacing }) => spacing === 1);
    expect(near.length).toBeGreaterThan(3);
    expect(near.some(({ cube }) => cube.x + cube.y + cube.z < 16)).toBe(true);
    const full = await tilesOf(
      crossed,
      crossed.cubes(3).map((cube) => ({ cube, spacing: 1 })),
    );
    const keys = new Set(full.map(({ key }) => key));
    const finest = (await tilesOf(crossed, cubes)).filter(({ cube }) => cube.exponent === 3);
    expect(finest.every(({ key }) => keys.has(key))).toBe(true);
  });

  test("GrowFinerWithTheBudget", () => {
    const crossed = new CrossedCells(volumeOf(rough, [41, 41, 41]), 10.5);
    const finest = (bricks: number) => cubesByView(crossed, viewFrom([0, 0, 0], [20, 20, 20]), bricks, cells).filter(({ spacing }) => spacing === 1).length;
    expect(finest(10)).toBeLessThan(finest(40));
    expect(finest(1e6)).toBe(crossed.cubes(3).length); // A pixel is smaller than a voxel there.
  });

  test("AreUniformWithoutAView", () => {
    const crossed = new CrossedCells(volumeOf(waves, [41, 41, 41]), 10.5);
    expect(spacingsOf(uniformCubes(crossed, 2))).toEqual([2]);
  });
});
