// Messages between the page, the tile workers and the mesh worker. A tile's id is its key within one tile cache: the
// same content with and without normals counts as two tiles.

import type { MeshTopology } from "../mesh/boundary_matcher";
import type { MeshFormat } from "../mesh/mesh_file";
import type { HalfSpace } from "../mesh/ray";
import type { ShellMode } from "../mesh/shell_decoder";
import type { TileBoundary } from "../mesh/tile_boundary";
import type { Triangles } from "../mesh/tile_components";
import type { LatticeBox, ManifestTile } from "../mesh/tile_mesh";
import type { MeshCalls } from "./mesh_worker";

// ---- page -> tile worker

export interface TileJob {
  kind: "decode";
  id: string;
  payload: Uint8Array;
  expected: ManifestTile;
  resolution: number;
  shell: ShellMode | null; // Null: a Draco mesh.
  hasNormals: boolean; // Whether a Draco mesh has normals.
  linear: number[]; // Lattice -> world, 3 x 3 by columns.
}

// ---- tile worker -> page

export interface DecodedTile {
  kind: "decoded";
  id: string;
  positions: Float32Array; // Lattice coordinates.
  triangles: Uint16Array | Uint32Array;
  normals: Int16Array;
}
export interface DamagedTile {
  kind: "damaged";
  id: string;
  text: string;
}
// There is no memory for a decoder; the worker decodes nothing.
export interface UndecodedTile {
  kind: "noMemory";
}
export type TileReply = DecodedTile | DamagedTile | UndecodedTile;

// ---- tile worker -> mesh worker

export interface StoredTile {
  kind: "tile";
  id: string;
  positions: Float32Array;
  triangles: Uint16Array | Uint32Array;
  normals: Int16Array;
  sums: Float32Array | null; // For computed normals.
  boundary: TileBoundary;
}

// ---- page -> mesh worker

export type MeshMessage =
  | { kind: "port"; port: MessagePort }
  | { kind: "drop"; ids: string[] }
  | { kind: "call"; request: number; name: keyof MeshCalls; args: unknown[] }; // Replied to.

// A surface to be written to a file.
export interface SavedSurface {
  drawn: DrawnTiles;
  toWorld: number[];
  step: number; // The length of a lattice step.
  format: MeshFormat;
}

// The tiles of a step, without the components that are not drawn.
export interface DrawnTiles {
  ids: readonly string[];
  leastDiagonal: number; // The shortest diagonal of a drawn component's bounding box, in lattice steps; 0: all are drawn.
  hidden: readonly (readonly number[])[]; // In lattice coordinates: the component nearest to each is not drawn.
  largestOnly?: boolean; // Draws only the remaining component with the longest diagonal; absent: false.
}

// A connected part of a surface: that of a drawn triangle, or the nearest to a place in lattice coordinates.
export type MeasuredPart = { id: string; triangle: number } | { place: readonly number[] };

// In lattice coordinates.
export interface PickRay {
  origin: number[];
  direction: number[];
  clip: HalfSpace[]; // The half-spaces that remain visible.
}

// ---- mesh worker -> page

export interface CheckedStep {
  topology: MeshTopology;
  // Computed normals that changed because a neighbor did.
  normals: { id: string; normals: Int16Array }[];
}
export interface Hit {
  point: [number, number, number]; // Lattice coordinates.
  id: string;
  triangle: number; // Index among the tile's drawn triangles.
}
// The drawn components of a step.
export interface Selection {
  components: number; // All components of the step.
  shown: number; // Drawn components.
  triangles: number; // Drawn triangles.
  largest: LatticeBox | null; // The box of the largest drawn component; null: none is drawn.
  // For each tile that is drawn in part: all triangles, drawn ones first, and the number of drawn ones.
  parted: { id: string; triangles: Triangles; shown: number }[];
}
export interface MeshReply {
  request: number;
  result?: unknown;
  error?: string;
}
