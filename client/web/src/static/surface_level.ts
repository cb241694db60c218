// Makes the tiles of a surface at a uniform level: the samples of each cube that it crosses, as plain boxes.
import type { payloadHasher } from "../mesh/content_digest";
import { plainPayload, type SurfaceCounts, setCounts, type surfaceCounter } from "../mesh/plain_box";
import type { ManifestTile, OctreeCube } from "../mesh/tile_mesh";
import { LevelSamples } from "./level_samples";
import type { PreparedVolume } from "./prepared_file";
import type { SampleArray } from "./sample_array";

export interface Tools {
  count: Awaited<ReturnType<typeof surfaceCounter>>;
  hash: Awaited<ReturnType<typeof payloadHasher>>;
}

export interface MadeTile extends ManifestTile {
  payload: Uint8Array;
}

const maxTileTriangles = 2 ** 20;
const countedCubes = 24; // For an estimate.
const turn = 30; // Milliseconds until messages are received in between.

export class SurfaceLevel {
  readonly bricks: number[]; // Those that the surface crosses.
  private readonly samples: LevelSamples;
  private readonly cubes: OctreeCube[];

  constructor(
    private readonly volume: PreparedVolume,
    private readonly isovalue: number,
    private readonly resolution: number,
    readonly spacing: number,
  ) {
    this.samples = new LevelSamples(volume, isovalue, spacing);
    this.cubes = this.samples.cubes();
    this.bricks = [...new Set(this.cubes.flatMap((cube) => this.samples.bricks(cube)))];
  }

  // Counts the triangles in some of the cubes.
  async expectedTriangles({ count }: Tools): Promise<number> {
    const apart = Math.ceil(this.cubes.length / countedCubes);
    const some = this.cubes.filter((_, i) => i % apart === 0);
    await this.volume.bricks.fetch(some.flatMap((cube) => this.samples.bricks(cube)));
    let triangles = 0;
    for (const cube of some) {
      const payload = this.payload(cube, await this.volume.bricks.unpack(this.samples.bricks(cube)));
      if (payload) triangles += count(payload).triangles;
    }
    return Math.round((triangles * this.samples.crossedCells(this.cubes)) / Math.max(1, this.samples.crossedCells(some)));
  }

  // Returns null as soon as nobody wants them any more. Requires fetched bricks.
  async tiles(tools: Tools, isWanted: () => boolean): Promise<MadeTile[] | null> {
    const tiles: MadeTile[] = [];
    const left = [...this.cubes];
    let began = performance.now();
    for (let cube = left.pop(); cube; cube = left.pop()) {
      if (performance.now() - began > turn) {
        await new Promise((resolve) => setTimeout(resolve));
        began = performance.now();
      }
      if (!isWanted()) return null;
      const payload = this.payload(cube, await this.volume.bricks.unpack(this.samples.bricks(cube)));
      const counts: SurfaceCounts = payload ? tools.count(payload) : { vertices: 0, triangles: 0 };
      if (counts.triangles > maxTileTriangles) left.push(...octants(cube));
      else if (payload && counts.triangles > 0) {
        setCounts(payload, counts);
        tiles.push({ ...counts, cube, key: tools.hash(payload), bytes: payload.length, payload });
      }
    }
    return tiles;
  }

  private payload(cube: OctreeCube, bricks: ReadonlyMap<number, SampleArray>): Uint8Array | null {
    const box = this.samples.read(cube, bricks);
    const { isovalue, resolution } = this;
    const { outside } = this.volume.info;
    return box && plainPayload({ ...box, layerValue: outside ?? 0, isovalue, resolution, spacingExponent: Math.log2(this.samples.spacing) });
  }
}

function octants({ exponent, x, y, z }: OctreeCube): OctreeCube[] {
  return Array.from({ length: 8 }, (_, i) => ({ exponent: exponent - 1, x: 2 * x + (i & 1), y: 2 * y + ((i >> 1) & 1), z: 2 * z + (i >> 2) }));
}
