// What this page has checked of the surfaces that are shown, in words and numbers.
import type { DrawnSurface, ShownComponents, StepFacts } from "../state/progress";
import { lengthText } from "../stream/dataset";
import { h } from "../shared/elements";
import { counted, grouped, inDigits } from "../shared/quantities";
import { componentWords, hidesAny } from "./component_filter";

// The final surface has no triangle.
export function isEmpty(shown: StepFacts): boolean {
  return shown.isFinal && shown.triangles === 0;
}

export function isClosed(shown: StepFacts): boolean {
  return shown.topology.borderEdges === 0;
}

// On one line: what is certain of all surfaces that are shown, of which there is one at least.
export function sealWords(drawn: readonly DrawnSurface[]): string {
  const components = allComponents(drawn);
  if (hidesAny(components) && components.shown === 0) return "Nothing shown: all components hidden";
  const closed = drawn.length > 1 ? "✓ Closed surfaces" : "✓ Closed surface";
  const sound = drawn.every(({ shown }) => isClosed(shown)) ? closed : "✓ No cracks";
  return hidesAny(components) ? `${sound}, ${grouped(components.shown)} of ${grouped(components.components)} components shown` : sound;
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

// That of which least is promised: the coarsest preview, else the one with the largest error.
export function leastAccurate(drawn: readonly DrawnSurface[]): StepFacts | null {
  const isLess = (a: StepFacts, b: StepFacts) => (a.spacing !== b.spacing ? a.spacing > b.spacing : a.errorVoxels > b.errorVoxels);
  return drawn.reduce<StepFacts | null>((least, { shown }) => (!least || isLess(shown, least) ? shown : least), null);
}

// How accurate it is, as a number with its unit: a bound, where it is certified; of a preview, which has none, the
// spacing of the samples that it looks at.
export function accuracyOf(shown: StepFacts, digits: number): { value: string; unit: string } {
  if (shown.spacing > 1) return { value: `1 in ${shown.spacing}`, unit: "samples per axis" };
  const voxels = inDigits(shown.errorVoxels, digits);
  const unit = voxels === "1" ? "voxel" : "voxels";
  return shown.isCertified ? { value: `≤ ${voxels}`, unit } : { value: voxels, unit };
}

export function errorWords(shown: StepFacts): string {
  if (shown.spacing > 1) {
    return `A preview that looks at one sample in ${shown.spacing} along each axis: parts may be missing, and what is there may ` +
      "lie several times so far from the full-resolution surface. It promises no error.";
  }
  if (shown.pixels === null) return errorAnywhere(shown);
  const seen = `Where you look, ${counted(shown.pixels, "pixel")} of the screen may be off. `;
  return seen + errorAnywhere(shown);
}

function errorAnywhere(shown: StepFacts): string {
  const world = lengthText(shown.errorWorld, shown);
  if (shown.isCertified) {
    return `No point of this surface is farther than this (${world}) from the full-resolution ` +
      "surface, nor the other way round; rounding to the lattice comes on top.";
  }
  if (!shown.preservesTopology) {
    return `The error allowed (${world}), while features up to ${inDigits(shown.tolerance, 3)} voxels ` +
      "may be missing, as you asked.";
  }
  return `The error of the original method (${world}); the real distance may exceed it.`;
}

export function certificateOf(drawn: readonly DrawnSurface[]): HTMLElement[] {
  const named = ({ number, shown }: DrawnSurface) => h("h3", {}, `Surface ${number}: isovalue ${inDigits(shown.isovalue, 6)}`);
  return [
    h("h2", {}, "Checked in this browser"),
    ...drawn.flatMap((surface) => [...(drawn.length > 1 ? [named(surface)] : []), ...checksOf(surface)]),
  ];
}

function checksOf({ shown, components }: DrawnSurface): HTMLElement[] {
  const { topology } = shown;
  const row = (name: string, value: string, tip: string) =>
    h("div", { "data-tip": tip }, h("dt", {}, name), h("dd", {}, value));
  const rows = [
    row("Cracks", topology.openEdges === 0 ? "none" : grouped(topology.openEdges),
      "Every edge belongs to two triangles that agree on the outside, except where the data ends."),
    row("Ends at the data's border", topology.borderEdges === 0 ? "nowhere: closed"
      : `${grouped(topology.borderEdges)} edges`, "The surface ends where the data ends."),
    row("Folds, degenerate triangles", grouped(topology.nonmanifoldEdges + topology.degenerateTriangles),
      "Edges of more than two triangles, and triangles without area."),
    row("Connected parts", grouped(topology.components), "Pieces that hang together."),
    row("Euler characteristic", String(topology.eulerCharacteristic),
      "Vertices - edges + triangles: 2 for a ball, 0 for a ring; each hole takes 2 away."),
    row("Topology", shown.preservesTopology
      ? shown.sameTopologyAs !== null ? `preserved, same as in step ${shown.sameTopologyAs + 1}` : "preserved"
      : shown.spacing > 1 ? "a preview: parts may be missing" : "as you asked, small parts may be missing",
      "Whether parts, tunnels and hollows are exactly those of the full-resolution surface."),
    row("Vertices, edges", `${grouped(topology.vertices)}, ${grouped(topology.edges)}`, "As counted here."),
    row("Digest", shown.digest,
      "The sum of one hash a triangle, computed here from what was decoded, equal to the server's."),
  ];
  return [
    ...(hidesAny(components) ? [h("p", {}, `${componentWords(components)}. What follows is of the whole surface.`)] : []),
    h("dl", {}, ...rows),
  ];
}
