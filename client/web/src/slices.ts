// Joins slices: settings become planes, planes become questions to the server, answers what is shown.
// One question is under way at a time; of those that come meanwhile the last one follows.
import { Plane, Vector3 } from "three";

import type { DatasetInfo } from "./protocol/messages";
import type { ColourScale } from "./shared/colour_maps";
import { airBelow } from "./shared/sample_window";
import { inLattice } from "./scene/picking";
import { sliceGrid } from "./scene/slice_grid";
import { SlicePlane } from "./scene/slice_plane";
import type { Stage } from "./scene/stage";
import type { Settings } from "./state/settings";
import { surfacesOf } from "./state/surfaces";
import { latticeToWorld, voxelLength, worldBox } from "./stream/dataset";
import type { Questions, SliceValues } from "./stream/questions";
import { suggestedIsovalue } from "./stream/request";
import type { SurfaceSet } from "./surface_set";
import type { TilePool } from "./workers/tile_pool";

export class Slices {
  readonly plane: SlicePlane;
  private wanted = ""; // The key of the slice that was requested last.
  private isAsking = false;
  private isCutting = false;
  private isCutDue = false;
  private shown: SliceValues | null = null;

  constructor(
    stage: Stage,
    private readonly pool: TilePool,
    private readonly surfaces: SurfaceSet,
    private readonly questions: Questions,
    private readonly current: () => { info: DatasetInfo | null; settings: Settings; range: ValueRange | null },
    private readonly failed: (text: string) => void,
  ) {
    this.plane = new SlicePlane(stage.scene, () => stage.invalidate());
  }

  // The settings, the dataset or the surfaces may have changed.
  update(): void {
    const { info, settings, range } = this.current();
    const where = slicePlace(settings);
    if (!info || !where) {
      this.wanted = "";
      this.shown = null;
      this.plane.show(null);
      return;
    }
    const scale = scaleOf(settings.level, settings.windowWidth, settings.samplesLog, range ?? info);
    const air = settings.transparentAir ? airBelow(info) : -Infinity;
    this.plane.setLook({ map: settings.sliceColors, ...scale, above: where.isFilling ? leastIsovalue(settings, info) : air });
    const wanted = `${info.name} ${info.contentId} ${where.axis} ${where.at}`;
    if (wanted !== this.wanted) {
      this.wanted = wanted;
      if (!this.isAsking) void this.ask(info, where);
    }
    this.cutSoon();
  }

  private async ask(info: DatasetInfo, where: Place): Promise<void> {
    this.isAsking = true;
    const asked = this.wanted;
    const { low, high } = worldBox(info);
    try {
      const slice = await this.questions.slice(info.name, sliceGrid(low, high, where.axis, where.at, voxelLength(info)));
      if (this.wanted !== "") this.plane.show((this.shown = slice));
    } catch (error) {
      if (this.wanted === asked) this.failed(`There is no slice: ${(error as Error).message}`);
    }
    this.isAsking = false;
    if (this.wanted === asked || this.wanted === "") return this.cutSoon();
    const now = this.current();
    const next = slicePlace(now.settings);
    if (now.info && next) void this.ask(now.info, next);
  }

  // The lines are those of the plane that is shown, which may be behind the settings while one drags.
  private cutSoon(): void {
    this.isCutDue = true;
    if (!this.isCutting) void this.cut();
  }

  private async cut(): Promise<void> {
    this.isCutting = true;
    while (this.isCutDue) {
      this.isCutDue = false;
      const { settings } = this.current();
      const { shown } = this;
      if (!shown) break;
      const plane = planeOf(shown);
      const lines = await Promise.all(this.surfaces.shownTiles(settings).map(async ({ shown: surface, drawn, colour }) => {
        const toWorld = latticeToWorld(surface.info, surface.resolution);
        const segments = await this.pool.cut(drawn, inLattice(plane, toWorld));
        return { segments, toWorld, colour };
      })).catch(() => null); // Tiles have gone meanwhile: those that came call again.
      if (lines && shown === this.shown) this.plane.showLines(lines);
    }
    this.isCutting = false;
  }
}

// `usual`: the default window; all values if there is none.
export type ValueRange = Pick<DatasetInfo, "min" | "max"> & { usual?: { level: number; width: number } };

interface Place {
  axis: number;
  at: number; // 0 to 1.
  isFilling: boolean; // Shows the inside of the surfaces alone.
}

// A slice that is asked for by itself, else that which fills the cut.
export function slicePlace({ slice, sliceAt, clip, clipAt, filled }: Settings): Place | null {
  if (slice !== "off") return { axis: "xyz".indexOf(slice), at: sliceAt, isFilling: false };
  if (clip !== "off" && filled) return { axis: "xyz".indexOf(clip), at: clipAt, isFilling: true };
  return null;
}

// The values of the first and the last colour: as set, else the defaults, else the range of the data.
export function windowOf(
  level: number | null, windowWidth: number | null, { min, max, usual }: ValueRange,
): { low: number; high: number } {
  const width = windowWidth ?? usual?.width ?? max - min;
  const middle = level ?? usual?.level ?? (min + max) / 2;
  return { low: middle - width / 2, high: middle + width / 2 };
}

// The same for a scale that may be logarithmic. Where values are not positive, that begins at the thousandth
// part of the last colour's value; where none is, it is linear.
export function scaleOf(
  level: number | null, windowWidth: number | null, wantsLog: boolean, range: ValueRange,
): Omit<ColourScale, "map"> {
  const { low, high } = windowOf(level, windowWidth, range);
  if (!wantsLog || high <= 0) return { low, high, isLog: false };
  const least = range.min > 0 && range.min < high ? range.min : high / 1000;
  return { low: low > 0 && low < high ? low : least, high, isLog: true };
}

function leastIsovalue(settings: Settings, info: DatasetInfo): number {
  const shown = surfacesOf(settings).filter(({ visible }) => visible);
  return Math.min(...shown.map(({ isovalue }) => isovalue ?? suggestedIsovalue(info)));
}

function planeOf({ grid: { origin, right, down } }: SliceValues): Plane {
  const normal = new Vector3(...right).cross(new Vector3(...down)).normalize();
  return new Plane().setFromNormalAndCoplanarPoint(normal, new Vector3(...origin));
}
