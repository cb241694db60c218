// What is known of a surface that is shown, and which of two is the better one to look at.
import { hex } from "./mesh/content_digest";
import { type DatasetInfo, ErrorMeasure } from "./protocol/messages";
import type { StepFacts } from "./state/progress";
import { type AssemblerEffect, type StepOfTiles } from "./stream/assembler";
import type { StreamRequest } from "./stream/conversation";
import { longestCellDiagonal, voxelLength } from "./stream/dataset";
import { preservesTopology, shellModeOf } from "./stream/step_checks";

export type Committed = AssemblerEffect & { kind: "committed" };

export interface ShownSurface {
  info: DatasetInfo;
  resolution: number;
  request: StreamRequest["request"];
  facts: StepFacts;
}

// How far a place on it may lie from the full-resolution surface, in world units: the certified error, and the rounding of
// vertices to the lattice, along their edges. Null: nothing is certified.
export function boundOf({ info, resolution, facts }: ShownSurface): number | null {
  return facts.isCertified ? facts.errorWorld + roundingBound(info, resolution) : null;
}

function roundingBound(info: DatasetInfo, resolution: number): number {
  return longestCellDiagonal(info) / 2 ** (resolution + 1);
}

// On the way to a finer surface of the same isovalue, nothing coarser than what is there is shown.
export function isRegression(before: ShownSurface | null, order: StreamRequest, facts: StepFacts): boolean {
  if (facts.isFinal || !before || before.info.name !== order.info.name) return false;
  if (before.request.isovalue !== order.request.isovalue) return false;
  // Its error is that of what the camera did not see; where it looked the surface is finer.
  if (before.request.threshold?.view) return true;
  const { errorWorld, tolerance } = before.facts;
  return facts.errorWorld > errorWorld || facts.tolerance > tolerance;
}

// Tiles of one memory can stand in for one another. Each surface of a view, by its number, has its own:
// what one of them drops the other may show.
export function memoryOf(surface: number, order: StreamRequest): string {
  const { info, request } = order;
  return `${surface}:${info.name}/${request.normals}/`;
}

export function idsOf(surface: number, order: StreamRequest, step: StepOfTiles): string[] {
  const prefix = memoryOf(surface, order);
  return step.tiles.map(({ key }) => prefix + key);
}

export function factsOf(order: StreamRequest, { step, topology, sameAs }: Committed): StepFacts {
  const { begin, end } = step;
  const request = begin.request!;
  const isPreserving = preservesTopology(begin);
  return {
    step: begin.step,
    isFinal: begin.isFinal,
    triangles: topology.triangles,
    tiles: step.tiles.length,
    heldTiles: step.held,
    bytes: step.tiles.reduce((n, tile) => n + tile.bytes, 0),
    errorWorld: begin.errorBoundWorld,
    lengthUnit: order.info.lengthUnit,
    errorVoxels: begin.errorBoundWorld / voxelLength(order.info),
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
