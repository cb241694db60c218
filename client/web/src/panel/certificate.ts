// Describes what the page has checked of the shown surfaces.

import { h } from "../shared/elements";
import { counted, grouped, inDigits } from "../shared/quantities";
import type { DrawnSurface, ShownComponents, StepFacts } from "../state/progress";
import { lengthText } from "../stream/dataset";
import { componentsText, hidesAny } from "./component_filter";
import { isFullResolution } from "./expected_text";

// Returns whether the final surface has no triangles.
export function isEmpty(shown: StepFacts): boolean {
  return shown.isFinal && shown.triangles === 0;
}

export function isClosed(shown: StepFacts): boolean {
  return shown.topology.borderEdges === 0;
}

// Returns one line that holds for all shown surfaces. Requires at least one.
export function certificateSummary(drawn: readonly DrawnSurface[]): string {
  const components = allComponents(drawn);
  if (hidesAny(components) && components.shown === 0) return "Nothing shown: all components hidden";
  const sound = drawn.every(({ shown }) => isClosed(shown)) ? "✓ Watertight" : "✓ No cracks";
  const within = errorSummary(drawn);
  const words = [within ? `${sound}, ${within}` : sound];
  if (hidesAny(components)) words.push(`${grouped(components.shown)} of ${grouped(components.components)} components shown`);
  return words.join(", ");
}

// "within 0.25 mm" if all are certified; otherwise "preview" or empty.
export function errorSummary(drawn: readonly DrawnSurface[]): string {
  if (drawn.length === 0) return "";
  if (drawn.some(({ shown }) => shown.spacing > 1)) return "preview";
  if (!drawn.every(({ shown }) => shown.isCertified)) return "";
  const { shown } = drawn.reduce((worst, one) => (one.shown.errorVoxels > worst.shown.errorVoxels ? one : worst));
  return shown.errorWorld === 0 ? "full resolution" : `within ${errorLength(shown)}`;
}

// "0.25 mm", or in voxels if the unit is unknown.
function errorLength(shown: StepFacts): string {
  return shown.lengthUnit ? lengthText(shown.errorWorld, shown, 2) : counted(shown.errorVoxels, "voxel", 2);
}

function allComponents(drawn: readonly DrawnSurface[]): ShownComponents | null {
  if (drawn.every(({ components }) => !hidesAny(components))) return null;
  const sum = (part: (surface: DrawnSurface) => number) => drawn.reduce((all, surface) => all + part(surface), 0);
  return {
    minComponent: 0,
    components: sum(({ components, shown }) => components?.components ?? shown.topology.components),
    shown: sum(({ components, shown }) => components?.shown ?? shown.topology.components),
    triangles: sum(trianglesOf),
  };
}

export function trianglesOf({ shown, components }: DrawnSurface): number {
  return components?.triangles ?? shown.triangles;
}

// Returns the surface with the weakest guarantee: the coarsest preview, or else the one with the largest error.
export function leastAccurate(drawn: readonly DrawnSurface[]): StepFacts | null {
  const isLess = (a: StepFacts, b: StepFacts) => (a.spacing !== b.spacing ? a.spacing > b.spacing : a.errorVoxels > b.errorVoxels);
  return drawn.reduce<StepFacts | null>((least, { shown }) => (!least || isLess(shown, least) ? shown : least), null);
}

// Returns the accuracy and its unit: a bound if certified; for previews, which have none, their spacing.
export function accuracyOf(shown: StepFacts, digits: number): { value: string; unit: string } {
  if (shown.spacing > 1) return { value: `1 in ${shown.spacing}`, unit: "samples per axis" };
  const voxels = inDigits(shown.errorVoxels, digits);
  const unit = voxels === "1" ? "voxel" : "voxels";
  return shown.isCertified ? { value: `≤ ${voxels}`, unit } : { value: voxels, unit };
}

// Returns the same in the file's unit, if any, along with the voxels.
export function accuracyInUnits(shown: StepFacts): { value: string; label: string } {
  const { value, unit } = accuracyOf(shown, 2);
  const label = shown.pixels === null ? "error" : "error anywhere";
  if (shown.spacing > 1) return { value, label: unit };
  if (!shown.lengthUnit) return { value: `${value} ${unit}`, label };
  const bound = shown.isCertified ? "≤ " : "";
  return { value: bound + lengthText(shown.errorWorld, shown, 2), label: `${label}, ${inDigits(shown.errorVoxels, 2)} ${unit}` };
}

export function errorExplanation(shown: StepFacts): string {
  if (shown.spacing > 1) {
    return (
      `A preview from one sample in ${shown.spacing} along each axis: parts may be missing, and the surface may ` +
      "deviate by several times that spacing from the full-resolution surface. It has no error bound."
    );
  }
  if (shown.pixels === null) return errorAnywhere(shown);
  const seen = `In the view, the error may cover ${counted(shown.pixels, "pixel")} of the screen. `;
  return seen + errorAnywhere(shown);
}

function errorAnywhere(shown: StepFacts): string {
  const world = lengthText(shown.errorWorld, shown);
  if (shown.isCertified) {
    const why = isFullResolution(shown) ? " It may be less than allowed: the full resolution arrived sooner than a simplified surface." : "";
    return (
      `No point of this surface is farther than this (${world}) from the full-resolution ` + `surface, nor vice versa, before coordinates are rounded.${why}`
    );
  }
  if (!shown.preservesTopology) {
    return `The allowed error (${world}); features up to ${inDigits(shown.tolerance, 3)} voxels may be missing, as requested.`;
  }
  return `The error estimate of the original method (${world}); the actual distance may exceed it.`;
}

const maxDetailed = 24; // Surfaces described in full.

// `isOfFiles`: the page reads the samples itself.
export function certificateOf(drawn: readonly DrawnSurface[], isOfFiles = false): HTMLElement[] {
  const named = ({ number, shown, label }: DrawnSurface) => h("h3", {}, `Surface ${number}: ${label ?? `isovalue ${shown.isovalue}`}`);
  const others = drawn.length - maxDetailed;
  const rest = others > 0 ? [h("p", {}, `${counted(others, "more surface", 12)} ${others === 1 ? "was" : "were"} checked in the same way.`)] : [];
  return drawn
    .slice(0, maxDetailed)
    .flatMap((surface) => [
      ...(drawn.length > 1 ? [named(surface)] : []),
      h("p", { class: "certified-error" }, h("b", {}, errorHeadline(surface.shown)), ` ${errorExplanation(surface.shown)}`),
      ...checksOf(surface),
      ...promisesOf(surface.shown, isOfFiles),
    ])
    .concat(rest);
}

function errorHeadline(shown: StepFacts): string {
  if (shown.spacing > 1) return "Preview.";
  const { value, unit } = accuracyOf(shown, 3);
  const world = shown.lengthUnit ? ` = ${lengthText(shown.errorWorld, shown)}` : "";
  return `Error ${value} ${unit}${world}.`;
}

function row(name: string, value: string, tip: string): HTMLElement {
  return h("div", { "data-tip": tip }, h("dt", {}, name), h("dd", {}, value));
}

function checksOf({ shown, components }: DrawnSurface): HTMLElement[] {
  const { topology, shell } = shown;
  const rows = [
    row(
      "Cracks",
      topology.openEdges === 0 ? "none" : grouped(topology.openEdges),
      "Every edge belongs to two triangles that agree on the outside, except where the data ends.",
    ),
    row(
      "Ends at the border of the data",
      topology.borderEdges === 0 ? "nowhere: closed" : `${grouped(topology.borderEdges)} edges`,
      "The surface ends where the data ends.",
    ),
    row(
      "Folds, degenerate triangles",
      grouped(topology.nonmanifoldEdges + topology.degenerateTriangles),
      "Edges with more than two triangles, and triangles with zero area.",
    ),
    row("Connected components", grouped(topology.components), "Parts of the surface that are not connected to each other."),
    row("Euler characteristic", String(topology.eulerCharacteristic), "Vertices - edges + triangles: 2 for a sphere, 0 for a torus; each hole subtracts 2."),
    ...(shown.sameTopologyAs === null
      ? []
      : [
          row(
            "Topology",
            `same as in step ${shown.sameTopologyAs + 1}`,
            "Components and Euler characteristic were compared with those of an earlier step with the same topology.",
          ),
        ]),
    row("Vertices, edges", `${grouped(topology.vertices)}, ${grouped(topology.edges)}`, "Counted in this browser."),
    row(
      "Triangles generated",
      shell ? "in this browser, from samples" : "by the server",
      shell
        ? "Received as sample shells, on which this browser ran marching tetrahedra. The digest is that of their bytes."
        : "Received as Draco meshes. The digest is that of their triangles, as decoded in this browser.",
    ),
    row("Digest", shown.digest, "The sum of one hash for each triangle or payload, computed in this browser; equal to the server's."),
  ];
  return [
    ...(hidesAny(components) ? [h("p", {}, `${componentsText(components)}. The following applies to the whole surface.`)] : []),
    h("h2", {}, "Checked in this browser"),
    h("dl", {}, ...rows),
  ];
}

function promisesOf(shown: StepFacts, isOfFiles: boolean): HTMLElement[] {
  const topology = shown.preservesTopology
    ? "that of the full-resolution surface"
    : shown.spacing > 1
      ? "a preview: parts may be missing"
      : "small parts may be missing, as requested";
  const rows = [
    row(
      "Error",
      shown.isCertified ? "a bound, certified" : "no bound",
      isOfFiles
        ? "This page has marched all samples around the surface, which have the checksums of their file."
        : "The server computes the bound from all samples, which this page does not have.",
    ),
    row("Topology", topology, "Whether components, tunnels and cavities are exactly those of the full-resolution surface."),
    row("Samples", "those of the dataset", "The surface belongs to this dataset and isovalue."),
  ];
  return [h("h2", { class: "is-promise" }, isOfFiles ? "From the samples of the file" : "Guaranteed by the server"), h("dl", {}, ...rows)];
}
