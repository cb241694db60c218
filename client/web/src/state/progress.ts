// The status of the shown surface and of the next one, for the status bar and the certificate.
import type { MeshTopology } from "../mesh/boundary_matcher";
import type { ShellMode } from "../mesh/shell_decoder";

export interface StepFacts {
  step: number;
  isFinal: boolean;
  triangles: number;
  tiles: number;
  heldTiles: number;
  bytes: number; // The payloads of all its tiles.
  errorWorld: number;
  lengthUnit: string; // The unit of errorWorld; empty: unknown.
  errorVoxels: number;
  isCertified: boolean; // The error is a bound.
  shell: ShellMode | null; // It came as samples; null: as triangles.
  spacing: number; // The spacing of a preview's samples; 1: all samples.
  pixels: number | null; // The allowed error in pixels, if the camera was followed.
  preservesTopology: boolean;
  tolerance: number;
  isovalue: number;
  serverSeconds: number;
  digest: string;
  topology: MeshTopology;
  sameTopologyAs: number | null; // An earlier step of the stream that it was compared with.
}

// What of the surface is shown where small components are hidden.
export interface ShownComponents {
  minComponent: number; // Samples: those whose bounding box has a shorter diagonal are hidden.
  components: number; // Components of the whole surface.
  shown: number; // Components that are shown.
  triangles: number; // That are shown.
}

// As the server estimates it before it makes the surface.
export interface SurfaceSize {
  triangles: number; // Estimated.
  budget: number; // The most triangles that were allowed; 0: any number.
  bytes: number;
  errorVoxels: number;
}

export type ConnectionPhase = "connecting" | "greeting" | "ready" | "lost";

export interface Progress {
  phase: ConnectionPhase;
  retryAt: number; // performance.now() of the next attempt, while lost; 0: none.
  isStreaming: boolean;
  // The current or latest stream.
  step: number; // That is being received.
  tilesToCome: number;
  tilesReceived: number;
  bytesReceived: number; // The bytes of all steps.
  firstTile: number | null; // Milliseconds after the request.
  firstSurface: number | null;
  complete: number | null;
  shown: StepFacts | null; // Facts of the whole surface.
  components: ShownComponents | null; // and what of it is shown; null: all.
  // The server is busy: why, and performance.now() of the next attempt.
  postponed: { text: string; until: number } | null;
  heldBack: SurfaceSize | null; // The size of the requested surface, of which less was sent.
  // A second field on the shown surface: the range of its values, and the largest difference between the field and the
  // interpolated colors.
  scalars: { low: number; high: number; deviation: number } | null;
  // One sentence for the user, and how bad it is.
  failure: { text: string; isFatal: boolean; needsToken: boolean } | null;
}

export interface DrawnSurface {
  number: number; // From 1 on, as the list of surfaces has them.
  shown: StepFacts;
  components: ShownComponents | null;
}

// All visible surfaces.
export interface SurfacesStatus {
  progress: Progress; // Values of the first visible surface, else of the first one.
  isLead: boolean; // That is the first there is.
  drawn: DrawnSurface[];
  done: number; // Surfaces with a final step, or that will never have one.
  seen: number; // Visible surfaces.
}

export const noProgress: Progress = {
  phase: "connecting",
  retryAt: 0,
  isStreaming: false,
  step: 0,
  tilesToCome: 0,
  tilesReceived: 0,
  bytesReceived: 0,
  firstTile: null,
  firstSurface: null,
  complete: null,
  shown: null,
  components: null,
  postponed: null,
  heldBack: null,
  scalars: null,
  failure: null,
};

export const noErrors = { text: "", isFatal: false, needsToken: false };
