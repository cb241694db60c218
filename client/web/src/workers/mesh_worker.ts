// A worker that keeps a copy of every tile for operations on whole surfaces: checks a step before it is shown, makes
// normals agree between tiles, selects the drawn components, finds intersections of the drawn triangles with rays and
// planes, measures parts, and writes files. It converts the samples of volumes, too.

import { type DataBorder, matchBoundaries } from "../mesh/boundary_matcher";
import { type CutPlane, cutLine } from "../mesh/cut";
import { type MassProperties, massProperties } from "../mesh/mass_properties";
import { nearestTriangle } from "../mesh/nearest_component";
import { pack } from "../mesh/normals";
import { nearestHit } from "../mesh/ray";
import { scalarAttribute } from "../mesh/scalars";
import { drawnComponents, withDrawnComponents } from "../mesh/tile_components";
import { weldedInWorld } from "../mesh/welded_mesh";
import { madeSlab } from "../scene/volume/slab";
import type { CheckedStep, DrawnTiles, Hit, MeasuredPart, MeshMessage, MeshReply, PickRay, SavedSurface, Selection, StoredTile } from "./worker_messages";

const tiles = new Map<string, StoredTile>();
// Tiles come from other workers: a step may be requested before its last tile arrives.
let waiting: { ids: readonly string[]; resolve: () => void; reject: (error: Error) => void }[] = [];

// Recent results of drawnTiles(), the latest last.
let drawn: { name: string; tiles: StoredTile[] }[] = [];
const maxDrawn = 8;

function addTile(tile: StoredTile): void {
  tiles.set(tile.id, tile);
  waiting = waiting.filter(({ ids, resolve }) => {
    if (!ids.every((id) => tiles.has(id))) return true;
    resolve();
    return false;
  });
}

function drop(ids: string[]): void {
  const dropped = new Set(ids);
  for (const id of ids) tiles.delete(id);
  drawn = drawn.filter((one) => !one.tiles.some(({ id }) => dropped.has(id)));
  waiting = waiting.filter(({ ids: wanted, reject }) => {
    if (!wanted.some((id) => dropped.has(id))) return true;
    reject(new Error("Its tiles were dropped."));
    return false;
  });
}

async function tilesOf(ids: readonly string[]): Promise<StoredTile[]> {
  if (!ids.every((id) => tiles.has(id))) {
    await new Promise<void>((resolve, reject) => waiting.push({ ids, resolve, reject }));
  }
  return ids.map((id) => tiles.get(id)!);
}

// Returns the tiles with only the drawn triangles. Cached, because picking and cutting repeat requests.
async function drawnTiles(which: DrawnTiles): Promise<StoredTile[]> {
  const { ids, leastDiagonal, hidden, largestOnly = false } = which;
  const whole = await tilesOf(ids);
  if (leastDiagonal === 0 && hidden.length === 0 && !largestOnly) return whole;
  const name = `${leastDiagonal} ${largestOnly} ${hidden.join(";")} ${ids.join(" ")}`;
  const found = drawn.find((one) => one.name === name) ?? { name, tiles: withDrawnComponents(whole, which) };
  drawn = [...drawn.filter((one) => one !== found), found].slice(-maxDrawn);
  return found.tiles;
}

async function selectComponents(which: DrawnTiles): Promise<Selection> {
  const { ids } = which;
  const { tiles: parts, ...counts } = drawnComponents(await tilesOf(ids), which);
  return { ...counts, parted: parts.flatMap((part, i) => (part ? [{ id: ids[i], ...part }] : [])) };
}

async function checkStep(ids: string[], border: DataBorder): Promise<CheckedStep> {
  const step = await tilesOf(ids);
  const seams = matchBoundaries(
    step.map((tile) => tile.boundary),
    border,
  );
  return { topology: seams.topology, normals: mergedNormals(step, seams.numbers, seams.rimVertices) };
}

// Gives each boundary vertex the sum over all tiles that share it; returns the tiles whose normals changed.
function mergedNormals(step: StoredTile[], numbers: Uint32Array[], count: number): CheckedStep["normals"] {
  if (step.some((tile) => !tile.sums)) return [];
  const sums = new Float32Array(3 * count);
  step.forEach(({ boundary, sums: own }, i) => {
    numbers[i].forEach((number, j) => {
      for (let axis = 0; axis < 3; ++axis) {
        sums[3 * number + axis] += own![3 * boundary.vertices[j] + axis];
      }
    });
  });
  const changed: CheckedStep["normals"] = [];
  const before = new Int16Array(4);
  step.forEach((tile, i) => {
    let isOther = false;
    numbers[i].forEach((number, j) => {
      const at = 4 * tile.boundary.vertices[j];
      before.set(tile.normals.subarray(at, at + 4));
      const [x, y, z] = sums.subarray(3 * number, 3 * number + 3);
      pack(tile.normals, tile.boundary.vertices[j], x, y, z);
      isOther ||= before.some((value, k) => value !== tile.normals[at + k]);
    });
    if (isOther) changed.push({ id: tile.id, normals: tile.normals.slice() });
  });
  return changed;
}

// What the page can call.
const calls = {
  check: checkStep,
  select: selectComponents, // The drawn components of a step.
  pick: async (drawn: DrawnTiles, { origin, direction, clip }: PickRay): Promise<Hit | null> => nearestHit(await drawnTiles(drawn), origin, direction, clip),
  // Measures a connected part, given by a triangle from a hit of the same drawn tiles or by a place; null: all parts.
  measure: async (drawn: DrawnTiles, toWorld: number[], part: MeasuredPart | null): Promise<MassProperties | null> => {
    const shown = await drawnTiles(drawn);
    if (!part || !("place" in part)) return massProperties(shown, toWorld, part);
    const nearest = nearestTriangle(shown, part.place);
    return nearest && massProperties(shown, toWorld, nearest);
  },
  // Converts the scalars of a second field at the tile's vertices for the GPU.
  scalars: async (id: string, codes: Uint8Array, bits: number): Promise<Float32Array> => {
    const [tile] = await tilesOf([id]);
    return scalarAttribute(tile.positions, codes, bits);
  },
  // Returns segments; plane and segments in lattice coordinates.
  cut: async (drawn: DrawnTiles, plane: CutPlane): Promise<Float32Array> => cutLine(await drawnTiles(drawn), plane),
  // The writers are loaded with the first file.
  file: async ({ drawn, toWorld, step, format }: SavedSurface): Promise<Uint8Array> => {
    const { meshFile } = await import("../mesh/mesh_file");
    return meshFile(weldedInWorld(await drawnTiles(drawn), toWorld), format, step);
  },
  slab: madeSlab, // A part of a volume.
};

export type MeshCalls = typeof calls;

function transfers(result: Awaited<ReturnType<MeshCalls[keyof MeshCalls]>>): ArrayBufferLike[] {
  if (result instanceof Uint8Array || result instanceof Float32Array) return [result.buffer];
  if (result && "parted" in result) return result.parted.map(({ triangles }) => triangles.buffer);
  if (result && "texels" in result) return [result.texels.buffer, result.ranges.low.buffer, result.ranges.high.buffer];
  if (result && "topology" in result) return result.normals.map(({ normals }) => normals.buffer);
  return [];
}

self.onmessage = async ({ data }: MessageEvent<MeshMessage>) => {
  if (data.kind === "port") {
    data.port.onmessage = (event: MessageEvent<StoredTile>) => addTile(event.data);
  } else if (data.kind === "drop") {
    drop(data.ids);
  } else {
    const reply: MeshReply = { request: data.request };
    try {
      const result = await (calls[data.name] as (...args: unknown[]) => ReturnType<MeshCalls[keyof MeshCalls]>)(...data.args);
      self.postMessage({ ...reply, result }, { transfer: transfers(result) as ArrayBuffer[] });
    } catch (error) {
      self.postMessage({ ...reply, error: (error as Error).message });
    }
  }
};
