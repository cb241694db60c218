// Makes the tiles of a surface: the samples of each cube that it crosses, as plain boxes; where spacings meet, triangles.
import type { payloadHasher } from "../mesh/content_digest";
import { meshPayload, plainPayload, type SurfaceCounts, setCounts, type surfaceCounter } from "../mesh/plain_box";
import type { ManifestTile, OctreeCube } from "../mesh/tile_mesh";
import type { CrossedCells } from "./crossed_cells";
import { LevelSamples } from "./level_samples";
import { MixedTile } from "./mixed_tile";
import { finerBeside, keyOf, type LevelCube, tileCells } from "./view_levels";

export interface Tools {
  count: Awaited<ReturnType<typeof surfaceCounter>>;
  hash: Awaited<ReturnType<typeof payloadHasher>>;
}

export interface MadeTile extends ManifestTile {
  payload: Uint8Array;
}

interface Part extends LevelCube {
  finer: OctreeCube[]; // Those of half the spacing that it touches.
}

type Made = SurfaceCounts & { payload: Uint8Array };

const maxTileTriangles = 2 ** 20;
const countedCubes = 24; // For an estimate.
const turn = 30; // Milliseconds until messages are received in between.

// Returns the cubes of a surface that has the same spacing everywhere.
export function uniformCubes(crossed: CrossedCells, spacing: number): LevelCube[] {
  const exponent = Math.min(crossed.volume.info.gridExponent, Math.log2(tileCells * spacing));
  return crossed.cubes(exponent).map((cube) => ({ cube, spacing }));
}

export class SurfaceLevel {
  readonly bricks: number[]; // Those that the surface crosses.
  readonly spacing: number; // The coarsest one.
  private readonly parts: Part[];

  constructor(
    private readonly crossed: CrossedCells,
    private readonly resolution: number,
    cubes: readonly LevelCube[],
  ) {
    this.spacing = cubes.reduce((coarsest, { spacing }) => Math.max(coarsest, spacing), 1);
    const byKey = new Map(cubes.map((one) => [keyOf(one.cube), one]));
    this.parts = cubes.map((one) => ({ ...one, finer: finerBeside(one, byKey) }));
    this.bricks = [...new Set(this.parts.flatMap((part) => this.bricksOf(part)))];
  }

  // Counts the triangles in some of the cubes.
  async expectedTriangles({ count }: Tools): Promise<number> {
    const apart = Math.ceil(this.parts.length / countedCubes);
    const some = this.parts.filter((_, i) => i % apart === 0);
    await this.crossed.volume.bricks.fetch(some.flatMap((part) => this.bricksOf(part)));
    let triangles = 0;
    for (const part of some) triangles += (await this.made(part, count))?.triangles ?? 0;
    const cells = (parts: readonly Part[]) => this.crossed.countIn(parts.map(({ cube }) => cube));
    return Math.round((triangles * cells(this.parts)) / Math.max(1, cells(some)));
  }

  // Returns null as soon as nobody wants them any more. Requires fetched bricks.
  async tiles({ count, hash }: Tools, isWanted: () => boolean): Promise<MadeTile[] | null> {
    const tiles: MadeTile[] = [];
    const left = [...this.parts];
    let began = performance.now();
    for (let part = left.pop(); part; part = left.pop()) {
      if (performance.now() - began > turn) {
        await new Promise((resolve) => setTimeout(resolve));
        began = performance.now();
      }
      if (!isWanted()) return null;
      const made = await this.made(part, count);
      if (made && made.triangles > maxTileTriangles) left.push(...octants(part));
      else if (made && made.triangles > 0) tiles.push({ ...made, cube: part.cube, key: hash(made.payload), bytes: made.payload.length });
    }
    return tiles;
  }

  private bricksOf(part: Part): number[] {
    return part.finer.length > 0 ? this.mixed(part).bricks.all : new LevelSamples(this.crossed, part.spacing).bricks(part.cube);
  }

  private async made(part: Part, count: Tools["count"]): Promise<Made | null> {
    const { crossed, resolution } = this;
    if (part.finer.length > 0) {
      const mesh = await this.mixed(part).mesh();
      return { payload: meshPayload(mesh), vertices: mesh.positions.length / 3, triangles: mesh.triangles.length / 3 };
    }
    const samples = new LevelSamples(crossed, part.spacing);
    const box = samples.read(part.cube, await crossed.volume.bricks.unpack(samples.bricks(part.cube)));
    if (!box) return null;
    const { isovalue, volume } = crossed;
    const payload = plainPayload({ ...box, layerValue: volume.info.outside ?? 0, isovalue, resolution, spacingExponent: Math.log2(part.spacing) });
    const counts = count(payload);
    setCounts(payload, counts);
    return { payload, ...counts };
  }

  private mixed(part: Part): MixedTile {
    return new MixedTile(this.crossed, part, part.finer, this.resolution);
  }
}

function octants({ cube: { exponent, x, y, z }, ...part }: Part): Part[] {
  return Array.from({ length: 8 }, (_, i) => ({
    ...part,
    cube: { exponent: exponent - 1, x: 2 * x + (i & 1), y: 2 * y + ((i >> 1) & 1), z: 2 * z + (i >> 2) },
  }));
}
