// Hides connected parts of a surface: all but the largest one, or the one that was picked.
import type { Settings } from "./state/settings";
import { mostHiddenParts } from "./state/settings";
import { justAbove, surfacesOf, withSurface } from "./state/surfaces";
import type { Vec3 } from "./stream/dataset";
import type { SurfaceSet } from "./surface_set";
import type { TilePool } from "./workers/tile_pool";

// What is to be changed, or why nothing is.
export type PartsChange = { change: Partial<Settings> } | { refusal: string };

// Leaves the component with the largest box.
export async function largestPart(surfaces: SurfaceSet, pool: TilePool, settings: Settings, surface: number): Promise<PartsChange> {
  const tiles = surfaces.shownTiles(settings).find(({ at }) => at === surface);
  const found = tiles && (await pool.select({ ids: tiles.drawn.ids, leastDiagonal: 0, hidden: [] }).catch(() => null));
  if (!found) return { refusal: "The surface is not shown, or has changed meanwhile." };
  const minComponent = justAbove(found.diagonals, 2 ** tiles.shown.resolution);
  if (minComponent === null) return { refusal: "Its largest parts are equally large." };
  return { change: withSurface(settings, surface, { minComponent }) };
}

// Hides the component nearest to a place in the world.
export function withoutPart(settings: Settings, surface: number, place: Vec3): PartsChange {
  const { hiddenParts = [] } = surfacesOf(settings)[surface];
  if (hiddenParts.length >= mostHiddenParts) return { refusal: `At most ${mostHiddenParts} parts of a surface are hidden one by one.` };
  const part = place.map((value) => Number(value.toPrecision(6))) as Vec3; // As addresses have it.
  return { change: withSurface(settings, surface, { hiddenParts: [...hiddenParts, part] }) };
}
