// One line about the surface that is shown and the one that comes, and the certificate behind it.
import type { Progress, StepFacts } from "../state/progress";
import { grouped, h, inBytes, inDigits, inSeconds } from "./dom";

export class StatusBar {
  readonly element: HTMLElement;
  private readonly meter = h("div", { class: "meter" });
  private readonly facts = h("div", { class: "facts" });
  private readonly certificateButton: HTMLButtonElement;
  private readonly certificate = h("div", { class: "certificate", id: "certificate", hidden: true });

  constructor() {
    this.certificateButton = h("button", {
      type: "button",
      class: "seal",
      "aria-expanded": "false",
      "aria-controls": "certificate",
      "data-tip": "What this page has checked of the surface that is shown. Click for the details.",
    });
    this.certificateButton.addEventListener("click", () => {
      this.certificate.hidden = !this.certificate.hidden;
      this.certificateButton.setAttribute("aria-expanded", String(!this.certificate.hidden));
    });
    this.element = h("footer", { class: "bar" }, this.meter, this.certificate, this.facts,
      this.certificateButton);
  }

  show(progress: Progress): void {
    const { shown, isStreaming, tilesReceived, tilesToCome } = progress;
    const share = tilesToCome > 0 ? tilesReceived / tilesToCome : isStreaming ? 0 : 1;
    this.meter.style.setProperty("--share", String(share));
    this.meter.classList.toggle("is-active", isStreaming);
    this.facts.replaceChildren(...this.parts(progress));
    this.certificateButton.hidden = !shown;
    if (!shown) return;
    this.certificateButton.textContent = isClosed(shown) ? "✓ Closed surface" : "✓ No cracks";
    this.certificate.replaceChildren(...certificateOf(shown));
  }

  private parts(progress: Progress): HTMLElement[] {
    const { shown, isStreaming } = progress;
    const fact = (label: string, value: string, tip: string, name = "") =>
      h("span", { class: `fact ${name}`, "data-tip": tip },
        h("b", {}, value), h("span", {}, label));
    const parts: HTMLElement[] = [];
    const { step, tilesReceived, tilesToCome } = progress;
    const state = isStreaming
      ? tilesToCome > 0
        ? `Step ${step + 1}: tile ${tilesReceived} of ${tilesToCome}`
        : "Asking…"
      : progress.phase !== "ready"
        ? "Not connected"
        : shown?.isFinal
          ? "Complete"
          : shown
            ? "Preview"
            : "Waiting";
    parts.push(
      h("span", { class: "fact state", role: "status",
        "data-tip": "The surface comes in steps, each complete and without cracks; a step " +
          "replaces the one before when it is all there." }, h("b", {}, state),
        h("span", {}, shown ? (shown.isFinal ? `step ${shown.step + 1}, final` : `step ${shown.step + 1} shown`) : "")),
    );
    if (!shown) return parts;
    parts.push(
      fact("triangles", grouped(shown.triangles), "Of the surface that is shown."),
      fact(shown.errorVoxels === 1 ? "voxel error" : "voxels error",
        `≤ ${inDigits(shown.errorVoxels, 3)}`, errorWords(shown), "error"),
      fact(`in ${grouped(shown.tiles)} ${shown.tiles === 1 ? "tile" : "tiles"}`, inBytes(shown.bytes),
        `Compressed size of the surface that is shown. ${grouped(shown.heldTiles)} of its tiles were ` +
          "here already. " + `${inBytes(progress.bytesReceived)} came for this request.`),
    );
    if (progress.firstTile !== null) {
      parts.push(fact("first tile", inSeconds(progress.firstTile), "From the request to the first tile."));
    }
    if (progress.complete !== null) {
      parts.push(fact("all shown", inSeconds(progress.complete),
        "From the request until its final surface was checked and on the screen."));
    }
    return parts;
  }
}

function isClosed(shown: StepFacts): boolean {
  return shown.topology.borderEdges === 0;
}

function errorWords(shown: StepFacts): string {
  const world = `${inDigits(shown.errorWorld, 3)} world units`;
  if (shown.isCertified) {
    return `No point of this surface is farther than this (${world}) from the full-resolution ` +
      "surface, nor the other way round; rounding to the lattice comes on top.";
  }
  if (!shown.preservesTopology) {
    return `The error allowed (${world}), while features up to ${inDigits(shown.tolerance, 3)} voxels ` +
      "may be missing: a preview, or as you asked.";
  }
  return `The error of the original method (${world}); the real distance may exceed it.`;
}

function certificateOf(shown: StepFacts): HTMLElement[] {
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
      : "a preview: parts may be missing",
      "Whether parts, tunnels and hollows are exactly those of the full-resolution surface."),
    row("Vertices, edges", `${grouped(topology.vertices)}, ${grouped(topology.edges)}`, "As counted here."),
    row("Digest", shown.digest,
      "The sum of one hash a triangle, computed here from what was decoded, equal to the server's."),
  ];
  return [
    h("h2", {}, "Checked in this browser"),
    h("dl", {}, ...rows),
  ];
}
