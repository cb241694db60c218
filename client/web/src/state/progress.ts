// The status of the shown and the next surface, for the status bar and the certificate.
import type { MeshTopology } from "../mesh/boundary_matcher";
import type { ShellMode } from "../mesh/shell_decoder";
import type { DatasetInfo } from "../protocol/messages";

// What the server offers this client.
export interface ServedDatasets {
  list: DatasetInfo[] | null; // Null: not received yet.
  permitsSamples: boolean; // Slices of samples and not only surfaces.
}

export const noDatasets: ServedDatasets = { list: null, permitsSamples: true };

export interface StepFacts {
  step: number;
  isFinal: boolean;
  triangles: number;
  tiles: number;
  heldTiles: number;
  bytes: number; // Payloads of all tiles.
  errorWorld: number;
  lengthUnit: string; // The unit of errorWorld; empty: unknown.
  errorVoxels: number;
  isCertified: boolean; // The error is a bound.
  shell: ShellMode | null; // The mode of sample shells; null: a triangle mesh.
  spacing: number; // The spacing of a preview's samples; 1: all samples.
  pixels: number | null; // The allowed error in pixels if it follows the camera.
  preservesTopology: boolean;
  tolerance: number;
  isovalue: number;
  serverSeconds: number;
  digest: string;
  topology: MeshTopology;
  sameTopologyAs: number | null; // The earlier step that it was compared with.
}

// The visible components of the surface, if some are hidden.
export interface ShownComponents {
  minComponent: number; // In samples: components whose bounding box has a shorter diagonal are hidden.
  components: number; // All components of the surface.
  shown: number; // Visible components.
  triangles: number; // Visible triangles.
}

// The server's estimate, made before the surface is computed.
export interface SurfaceSize {
  triangles: number; // Estimated.
  budget: number; // The largest allowed number of triangles; 0: unlimited.
  bytes: number;
  errorVoxels: number;
}

// One sentence for the user, and its severity.
export interface Failure {
  text: string;
  isFatal: boolean;
  needsToken: boolean;
  needsView?: string; // The key of the surface whose parts the view decides on.
}

export interface ConnectionState {
  phase: "connecting" | "greeting" | "ready" | "lost";
  retryAt: number; // performance.now() of the next attempt, while lost; 0: none.
  failure: Failure | null;
  permitsSamples: boolean; // Slices of samples and not only surfaces.
}

export const noConnection: ConnectionState = { phase: "lost", retryAt: 0, failure: null, permitsSamples: true };

export interface Progress {
  isStreaming: boolean;
  // The current or latest stream.
  step: number; // The step being received.
  tilesToCome: number;
  tilesReceived: number;
  bytesReceived: number; // Bytes of all steps.
  shareRead: number; // The part of the next step's samples that this page has read from a file; 0: unknown.
  firstTile: number | null; // Milliseconds after the request.
  firstSurface: number | null;
  complete: number | null;
  shown: StepFacts | null; // The shown step, with all components.
  components: ShownComponents | null; // Null: all are shown.
  // The reason why the server is busy, and performance.now() of the next attempt.
  postponed: { text: string; until: number } | null;
  sizeToConfirm: SurfaceSize | null; // The requested size, if the server sent less.
  // A second field on the shown surface: the range of its values, and the largest difference between the field and the
  // interpolated colors; the vertices, and those without a value.
  scalars: { low: number; high: number; deviation: number; vertices: number; missing: number } | null;
  failure: Failure | null;
}

// The progress of a surface, and the state of the connection to the server.
export type ServedProgress = Progress & Pick<ConnectionState, "phase" | "retryAt">;

export interface DrawnSurface {
  number: number; // Counted from 1, as in the list of surfaces.
  label?: string; // Its name, if it is the surface of a label.
  shown: StepFacts;
  components: ShownComponents | null;
}

// All visible surfaces.
export interface SurfacesStatus {
  progress: ServedProgress; // The progress of the first visible surface, or else of the first one.
  drawn: DrawnSurface[];
  done: number; // Surfaces that have a final step or will never have one.
  visible: number; // Visible surfaces.
}

export const noProgress: Progress = {
  isStreaming: false,
  step: 0,
  tilesToCome: 0,
  tilesReceived: 0,
  bytesReceived: 0,
  shareRead: 0,
  firstTile: null,
  firstSurface: null,
  complete: null,
  shown: null,
  components: null,
  postponed: null,
  sizeToConfirm: null,
  scalars: null,
  failure: null,
};

export const noFailure = { text: "", isFatal: false, needsToken: false };
