// Fetches the newest requested slice and the lines where it cuts the surfaces.
import { Plane, Vector3 } from "three";

import { halfSpaceInLattice } from "../scene/picking";
import type { CutLines } from "../scene/slice_plane";
import { latestOnly } from "../shared/latest_only";
import { nameOfLabel } from "../state/series";
import type { Settings } from "../state/settings";
import { latticeToWorld } from "../stream/dataset";
import type { DatasetQueries, SliceGrid, SliceValues } from "../stream/dataset_queries";
import type { SurfaceSet } from "../surfaces/surface_set";
import type { TilePool } from "../workers/tile_pool";

export interface SliceRequest {
  key: string; // Identifies the samples and the plane.
  dataset: string;
  grid: SliceGrid;
}

export interface SliceSources {
  queries: DatasetQueries;
  surfaces: SurfaceSet;
  pool: TilePool;
  settings: () => Settings;
  failed: (text: string) => void; // Called with a sentence.
}

export class LatestSlice {
  private requested: SliceRequest | null = null;
  private slice: SliceValues | null = null;
  private readonly fetch = latestOnly((requested: SliceRequest) => this.fetched(requested));
  private readonly cut = latestOnly(() => this.cutLines());

  constructor(
    private readonly sources: SliceSources,
    private readonly shows: { slice: (slice: SliceValues | null) => void; lines: (lines: readonly CutLines[]) => void },
  ) {}

  // Null: none. Call also when surfaces have changed.
  request(wanted: SliceRequest | null): void {
    const isOther = wanted?.key !== this.requested?.key;
    this.requested = wanted;
    if (!wanted) {
      this.slice = null;
      return this.shows.slice(null);
    }
    if (isOther) this.fetch(wanted);
    this.cut(null);
  }

  private async fetched(requested: SliceRequest): Promise<void> {
    if (!this.requested) return;
    try {
      const slice = await this.sources.queries.slice(requested.dataset, requested.grid);
      if (this.requested) this.shows.slice((this.slice = slice));
    } catch (error) {
      if (this.requested?.key === requested.key) this.sources.failed(`Cannot show the slice: ${(error as Error).message}`);
    }
    this.cut(null);
  }

  // Cuts with the plane that is shown, which may lag behind the settings while dragging.
  private async cutLines(): Promise<void> {
    const { pool, surfaces, settings } = this.sources;
    const { slice } = this;
    if (!slice) return;
    const plane = planeOf(slice);
    const lines = await Promise.all(
      surfaces.shownTiles(settings()).map(async ({ shown: surface, drawn, color }) => {
        const toWorld = latticeToWorld(surface.info, surface.resolution);
        const segments = await pool.call("cut", drawn, halfSpaceInLattice(plane, toWorld));
        const label = surface.info.member?.label;
        return { segments, toWorld, color, label: label ? nameOfLabel(label, settings()) : null };
      }),
    ).catch(() => null); // Tiles were removed meanwhile: the arrival of new ones triggers another cut.
    if (lines && slice === this.slice) this.shows.lines(lines);
  }
}

function planeOf({ grid: { origin, right, down } }: SliceValues): Plane {
  const normal = new Vector3(...right).cross(new Vector3(...down)).normalize();
  return new Plane().setFromNormalAndCoplanarPoint(normal, new Vector3(...origin));
}
