// Decodes a tile's sample shell into a mesh on the lattice: decodes the samples around the surface and runs marching
// tetrahedra. Uses the decoder of common/codec, compiled to WebAssembly; its README.md describes the format.
//
// Nothing that the server sends is trusted. The payload is checked against its digest, and the header against the
// manifest, before memory is allocated; the decoder then rejects the bytes or returns exactly the listed vertices and
// triangles, inside the header's box.
import { payloadHasher } from "./content_digest";
import { isPlainBox, meshOfPayload } from "./plain_box";
import { TileError } from "./tile_error";
import { cubeName, isInside, type LatticeBox, type LatticeMesh, type ManifestTile, type OctreeCube } from "./tile_mesh";

const quantized = 2;

// The coding of all shells of a step; `values` as in the header: 0 exact, 1 lattice-exact, 2 quantized.
export interface ShellMode {
  values: number;
  levelsPerOctave: number; // 1, 2, 4 or 8 if quantized, otherwise 0.
  spacing: number; // Grid steps.
}

// For smoothedSums(): fewer levels give more uneven triangles.
export function smoothingRounds({ values, levelsPerOctave }: ShellMode): number {
  return values !== quantized ? 1 : ({ 1: 4, 2: 3 }[levelsPerOctave] ?? 2);
}

export interface MarchedTile {
  mesh: LatticeMesh;
  box: LatticeBox | null; // The surface ends at its faces alone; null: unknown.
}

// Throws TileError.
export type ShellDecoder = (payload: Uint8Array, expected: ManifestTile, mode: ShellMode, resolution: number) => MarchedTile;

// The exports of common/codec/wasm/shell_wasm.cpp; pointers are offsets into `memory`.
interface Exports {
  memory: WebAssembly.Memory;
  shell_payload(size: number): number;
  shell_open(): number;
  shell_decode(): number;
  shell_vertex_count(): number;
  shell_triangle_count(): number;
  shell_vertices(): number;
  shell_triangles(): number;
  shell_lattice_resolution(): number;
  shell_spacing_exponent(): number;
  shell_values(): number;
  shell_levels_per_octave(): number;
  shell_has_void(): number;
  shell_low(axis: number): number;
  shell_high(axis: number): number;
}

const statuses = ["", "an unknown version", "a bad header", "contents that are damaged"];

export async function shellDecoder(wasm: BufferSource): Promise<ShellDecoder> {
  const { instance } = await WebAssembly.instantiate(wasm);
  const shell = instance.exports as unknown as Exports;
  const hashOf = await payloadHasher();
  return (payload, expected, mode, resolution) => {
    const damaged = (what: string) => new TileError(`Tile at ${cubeName(expected.cube)}: ${what}.`);
    const digest = hashOf(payload);
    if (digest !== expected.key) {
      throw damaged(`its bytes have the digest ${digest}; the manifest lists ${expected.key}`);
    }
    const made = meshOfPayload(payload);
    if (made) {
      const fault = meshFault(made, expected, resolution);
      if (fault) throw damaged(fault);
      return { mesh: made, box: null };
    }
    const at = shell.shell_payload(payload.length);
    if (at === 0) throw damaged(`there is no memory for its ${payload.length} bytes`);
    new Uint8Array(shell.memory.buffer, at, payload.length).set(payload);
    const opened = shell.shell_open();
    if (opened !== 0) throw damaged(`its sample shell has ${statuses[opened] ?? "a fault"}`);
    const fault = headerFault(shell, expected, mode, resolution, isPlainBox(payload));
    if (fault) throw damaged(fault);
    const decoded = shell.shell_decode();
    if (decoded < 0) throw damaged(`there is no memory for its ${expected.triangles} triangles`);
    if (decoded !== 0) throw damaged(`its sample shell has ${statuses[decoded] ?? "a fault"}`);
    const box = [0, 1, 2].flatMap(shell.shell_low).concat([0, 1, 2].map(shell.shell_high)) as LatticeBox;
    return {
      // Copies, because the decoder reuses its memory.
      mesh: {
        positions: new Int32Array(shell.memory.buffer, shell.shell_vertices(), 3 * expected.vertices).slice(),
        triangles: new Uint32Array(shell.memory.buffer, shell.shell_triangles(), 3 * expected.triangles).slice(),
        normals: null,
      },
      box: shell.shell_has_void() === 0 ? box : null,
    };
  };
}

function meshFault({ positions, triangles }: LatticeMesh, expected: ManifestTile, resolution: number): string | null {
  const [vertices, count] = [positions.length / 3, triangles.length / 3];
  if (vertices !== expected.vertices || count !== expected.triangles) return "it has other counts than the manifest lists";
  if (triangles.some((vertex) => vertex >= vertices)) return "a triangle has an unknown vertex";
  return isInside(positions, expected.cube, resolution) ? null : "a vertex lies outside the tile's cube";
}

// `mayBeFiner`: other tiles of the step have its spacing.
function headerFault(shell: Exports, expected: ManifestTile, mode: ShellMode, resolution: number, mayBeFiner: boolean): string | null {
  const [vertices, triangles] = [shell.shell_vertex_count(), shell.shell_triangle_count()];
  if (vertices !== expected.vertices || triangles !== expected.triangles) {
    return `it declares ${triangles} triangles and ${vertices} vertices; the manifest lists ${expected.triangles} and ${expected.vertices}`;
  }
  const levels = shell.shell_values() === quantized ? shell.shell_levels_per_octave() : 0;
  if (shell.shell_values() !== mode.values || levels !== mode.levelsPerOctave) {
    return "the values of its samples are coded in another way than the step says";
  }
  const spacing = 2 ** shell.shell_spacing_exponent();
  if (shell.shell_lattice_resolution() !== resolution || (mayBeFiner ? spacing > mode.spacing : spacing !== mode.spacing)) {
    return "its samples or its lattice have another spacing than the step's";
  }
  return isBoxInside(shell, expected.cube, resolution) ? null : "its samples lie outside the tile's cube";
}

function isBoxInside(shell: Exports, cube: OctreeCube, resolution: number): boolean {
  const side = 2 ** (cube.exponent + resolution);
  return [cube.x, cube.y, cube.z].every((place, axis) => shell.shell_low(axis) >= place * side && shell.shell_high(axis) <= (place + 1) * side);
}
