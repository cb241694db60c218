// Information about a shown surface, and the comparison of two.
import { hex } from "../mesh/content_digest";
import { type DatasetInfo, ErrorMeasure } from "../protocol/messages";
import type { StepFacts } from "../state/progress";
import type { AssemblerEffect } from "../stream/assembler";
import { latticeRoundingWorld, voxelLength } from "../stream/dataset";
import { preservesTopology, shellModeOf } from "../stream/step_checks";
import type { StreamRequest } from "../stream/stream_request";
import type { DrawnTiles } from "../workers/worker_messages";

export type Committed = AssemblerEffect & { kind: "committed" };

export interface ShownSurface {
  info: DatasetInfo;
  resolution: number;
  request: StreamRequest["isosurface"];
  facts: StepFacts;
}

// A shown surface, for measuring, cutting or saving.
export interface ShownTiles {
  at: number; // Index of the surface, 0 for the first.
  shown: ShownSurface;
  drawn: DrawnTiles;
  color: string;
  opacity: number; // 0 to 1.
}

// Returns the largest distance of its points to the full-resolution surface, in world units: the certified error plus
// the rounding of vertices to the lattice, along their edges. Null: not certified.
export function boundOf({ info, resolution, facts }: ShownSurface): number | null {
  return facts.isCertified ? facts.errorWorld + latticeRoundingWorld(info, resolution) : null;
}

// Returns whether the step is coarser than the shown one for the same isovalue; such steps are skipped.
export function isRegression(before: ShownSurface | null, request: StreamRequest, facts: StepFacts): boolean {
  if (facts.isFinal || !before || before.info.name !== request.info.name) return false;
  if (before.request.isovalue !== request.isosurface.isovalue) return false;
  // The step's error is the one outside the camera's view; inside, the step is finer.
  if (before.request.threshold?.view && before.facts.isFinal) return true;
  const { errorWorld, tolerance } = before.facts;
  return facts.errorWorld > errorWorld || facts.tolerance > tolerance;
}

// Prefix of tile ids. Tiles with the same prefix are interchangeable. Each surface of a view, by its number, has its
// own prefix, because another one may still show a tile that it drops.
export function tileIdPrefix(surface: number, request: StreamRequest): string {
  const { info, isosurface } = request;
  return `${surface}:${info.name}/${isosurface.normals}/`;
}

export function factsOf({ info }: StreamRequest, { step, topology, sameAs }: Committed): StepFacts {
  const { begin, end } = step;
  const request = begin.request!;
  const isPreserving = preservesTopology(begin);
  return {
    step: begin.step,
    isFinal: begin.isFinal,
    triangles: topology.triangles,
    tiles: step.tiles.length,
    heldTiles: step.cached,
    bytes: step.tiles.reduce((n, tile) => n + tile.bytes, 0),
    errorWorld: begin.errorBoundWorld,
    lengthUnit: info.lengthUnit,
    errorVoxels: begin.errorBoundWorld / voxelLength(info),
    pixels: begin.isFinal && request.maxTriangles === 0n ? (request.threshold?.view?.tolerancePixels ?? null) : null,
    isCertified: (request.bound === ErrorMeasure.CERTIFIED || begin.shell !== undefined) && isPreserving,
    shell: shellModeOf(begin),
    spacing: begin.finestSpacing || 1,
    preservesTopology: isPreserving,
    tolerance: request.topologyTolerance,
    isovalue: request.isovalue,
    serverSeconds: end.seconds,
    digest: hex(step.digest),
    topology,
    sameTopologyAs: sameAs,
  };
}
