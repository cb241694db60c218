// Checks the beginning of a step against the request and fixed limits before any tile is processed. A fault is the end
// of a sentence that begins with the step's number.
import { create, equals } from "@bufbuild/protobuf";

import { hex } from "../mesh/content_digest";
import type { ShellMode } from "../mesh/shell_decoder";
import { cubeName, type ManifestTile } from "../mesh/tile_mesh";
import {
  type DatasetInfo,
  type IsosurfaceRequest,
  IsosurfaceRequestSchema,
  PayloadCodec,
  ShellValues,
  type StepBegin,
  ThresholdMapSchema,
} from "../protocol/messages";
import { longestCellDiagonal } from "./dataset";

const maxTriangles = 60_000_000; // About what a browser's memory holds.
const maxTileTriangles = 2 ** 20;

export function manifestTile(summary: StepBegin["tiles"][number]): ManifestTile {
  return {
    key: hex({ high: summary.digestHigh, low: summary.digestLow }),
    cube: { exponent: summary.cubeExponent, x: summary.cubeX, y: summary.cubeY, z: summary.cubeZ },
    triangles: summary.triangles,
    vertices: summary.vertices,
    bytes: summary.bytes,
  };
}

// Returns whether the step promises the topology of the full-resolution surface.
export function preservesTopology(begin: StepBegin): boolean {
  return (begin.request?.topologyTolerance === 0 || begin.shell !== undefined) && begin.finestSpacing === 1;
}

// Returns the coding of a step's sample shells; null: Draco meshes.
export function shellModeOf({ shell, finestSpacing }: StepBegin): ShellMode | null {
  if (!shell) return null;
  const { values, levelsPerOctave } = shell;
  return { values: values - ShellValues.EXACT, levelsPerOctave, spacing: finestSpacing || 1 };
}

// Returns the largest displacement of shell vertices along their edges, in world units. 0 for exact values.
export function displacementBound({ levelsPerOctave, spacing }: ShellMode, info: DatasetInfo): number {
  if (levelsPerOctave === 0) return 0;
  return (0.5 - 1 / (1 + 2 ** (1 / levelsPerOctave))) * spacing * longestCellDiagonal(info);
}

function codecFault(begin: StepBegin, info: DatasetInfo): string | null {
  const mode = shellModeOf(begin);
  const isShell = begin.codec === PayloadCodec.SAMPLE_SHELL;
  if (!isShell && begin.codec !== PayloadCodec.DRACO_LATTICE) return "its codec was not negotiated";
  if (isShell !== (mode !== null)) return "its codec does not match its description of sample shells";
  if (!mode) return null;
  const isQuantized = begin.shell!.values === ShellValues.QUANTIZED;
  const levels = isQuantized ? [1, 2, 4, 8] : [0];
  if (!(mode.values in [0, 1, 2]) || !levels.includes(mode.levelsPerOctave)) return "its sample shells have unknown values";
  const bound = displacementBound(mode, info);
  if (mode.spacing === 1 && begin.errorBoundWorld < bound * (1 - 1e-9)) {
    return `it states an error bound of ${begin.errorBoundWorld}, but its sample shells allow ${bound}`;
  }
  return null;
}

export function manifestFault(begin: StepBegin, info: DatasetInfo): string | null {
  const fault = codecFault(begin, info);
  if (fault) return fault;
  const cubes = new Set<string>();
  const keys = new Set<string>();
  let triangles = 0;
  for (const tile of begin.tiles.map(manifestTile)) {
    const name = cubeName(tile.cube);
    const { exponent, x, y, z } = tile.cube;
    const side = 2 ** (info.gridExponent - exponent);
    if (!(side >= 1 && Math.max(x, y, z) < side)) return `${name} lies outside the grid`;
    if (tile.triangles < 1 || tile.triangles > maxTileTriangles) {
      return `${name} cannot have ${tile.triangles} triangles`;
    }
    if (tile.vertices < 3 || tile.vertices > 3 * tile.triangles) {
      return `${tile.vertices} vertices cannot belong to ${tile.triangles} triangles at ${name}`;
    }
    if (tile.bytes < 1) return `${name} has no bytes`;
    if (cubes.size === cubes.add(name).size) return `${name} is listed twice`;
    if (keys.size === keys.add(tile.key).size) return `${name} has the same content as another tile`;
    triangles += tile.triangles;
  }
  if (triangles > maxTriangles) {
    return `it announces ${triangles} triangles; this viewer allows ${maxTriangles}`;
  }
  return null;
}

// A preview may be coarser than the request; all else must match it.
export function parameterFault(begin: StepBegin, requested: IsosurfaceRequest): string | null {
  const given = begin.request;
  if (!given?.threshold || !requested.threshold) return "it has no parameters";
  const least = { given: given.threshold.atLeast, requested: requested.threshold.atLeast };
  if (least.given < least.requested || given.topologyTolerance < requested.topologyTolerance) {
    return "it is finer than the request";
  }
  if ((given.threshold.error ?? 0.25) < (requested.threshold.error ?? 0.25)) {
    return "its error is below the request's";
  }
  const mayDiffer = !begin.isFinal || requested.maxTriangles > 0n || requested.maxBytes > 0n;
  const compared = create(IsosurfaceRequestSchema, {
    ...given,
    ...(mayDiffer ? { topologyTolerance: requested.topologyTolerance } : {}),
    threshold: create(ThresholdMapSchema, {
      ...given.threshold,
      ...(mayDiffer ? { atLeast: least.requested } : {}),
      ...(begin.isFinal ? {} : { error: requested.threshold.error }),
      combine: given.threshold.combine || 1,
      regionCoordinates: given.threshold.regionCoordinates || 1,
    }),
    ...(begin.isFinal ? {} : { lattice: requested.lattice }),
  });
  if (!equals(IsosurfaceRequestSchema, compared, requested)) {
    return "its parameters differ from the request in more than accuracy";
  }
  if (begin.isFinal && begin.finestSpacing !== 1) return "the final step omits points";
  if (begin.isFinal && requested.maxTriangles > 0n) {
    const triangles = begin.tiles.reduce((n, tile) => n + tile.triangles, 0);
    if (BigInt(triangles) > requested.maxTriangles) return "it has more triangles than its budget";
  }
  return null;
}
