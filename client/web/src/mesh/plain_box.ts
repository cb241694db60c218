// Payloads of tiles that a page without a server makes from a file: boxes of samples (common/codec/plain_box.hpp), which the
// decoder of sample shells marches; and triangles, where spacings meet in a tile.

import type { Vec3 } from "../stream/dataset";
import { type SampleArray, typeCode } from "../stream/sample_array";
import type { LatticeMesh } from "./tile_mesh";

export interface PlainBox {
  samples: SampleArray; // x fastest; without the layers.
  origin: Vec3; // The lowest corner, layers included, in spacings.
  count: Vec3; // Samples along the axes, layers included.
  layers: number; // Bit 2 axis + (0 low, 1 high): a layer beyond the data.
  layerValue: number;
  isovalue: number;
  resolution: number;
  spacingExponent: number;
}

export interface SurfaceCounts {
  vertices: number;
  triangles: number;
}

export const infiniteSamples = "The samples of a tile cannot be marched: some are infinite.";
const versions = { box: 2, triangles: 3 }; // Those of sample shells are 1.
const headerBytes = 48;
const meshHeaderBytes = 12; // The version, and the numbers of vertices and triangles.

// Its counts are 0 until setCounts().
export function plainPayload({ samples, origin, count, layers, layerValue, isovalue, resolution, spacingExponent }: PlainBox): Uint8Array {
  const payload = new Uint8Array(headerBytes + samples.byteLength);
  const view = new DataView(payload.buffer);
  payload.set([versions.box, typeCode(samples), resolution | (spacingExponent << 4), layers]);
  for (let axis = 0; axis < 3; ++axis) {
    view.setInt32(4 + 4 * axis, origin[axis], true);
    view.setInt32(16 + 4 * axis, count[axis], true);
  }
  view.setFloat32(36, layerValue, true);
  view.setFloat64(40, isovalue, true);
  payload.set(new Uint8Array(samples.buffer, samples.byteOffset, samples.byteLength), headerBytes);
  return payload;
}

export function setCounts(payload: Uint8Array, { vertices, triangles }: SurfaceCounts): void {
  const view = new DataView(payload.buffer);
  view.setUint32(28, vertices, true);
  view.setUint32(32, triangles, true);
}

export function isPlainBox(payload: Uint8Array): boolean {
  return payload[0] === versions.box;
}

export function meshPayload({ positions, triangles }: LatticeMesh): Uint8Array {
  const header = Uint32Array.of(versions.triangles, positions.length / 3, triangles.length / 3);
  const payload = new Uint8Array(meshHeaderBytes + positions.byteLength + triangles.byteLength);
  [header, positions, triangles].reduce((at, part) => {
    payload.set(new Uint8Array(part.buffer, part.byteOffset, part.byteLength), at);
    return at + part.byteLength;
  }, 0);
  return payload;
}

// Returns null if it is another payload. Its triangles may have any vertices: not trusted.
export function meshOfPayload(payload: Uint8Array): LatticeMesh | null {
  if (payload[0] !== versions.triangles || payload.length < meshHeaderBytes) return null;
  const [, vertices, triangles] = new Uint32Array(payload.slice(0, meshHeaderBytes).buffer);
  if (payload.length !== meshHeaderBytes + 12 * (vertices + triangles)) return null;
  const part = (from: number, count: number) => payload.slice(from, from + 12 * count).buffer;
  const [positions, corners] = [part(meshHeaderBytes, vertices), part(meshHeaderBytes + 12 * vertices, triangles)];
  return { positions: new Int32Array(positions), triangles: new Uint32Array(corners), normals: null };
}

interface Exports {
  memory: WebAssembly.Memory;
  shell_payload(size: number): number;
  shell_open(): number;
  shell_count(): number;
  shell_vertex_count(): number;
  shell_triangle_count(): number;
}

// Returns a function that counts the surface of a payload. It throws if there is no memory.
export async function surfaceCounter(wasm: BufferSource): Promise<(payload: Uint8Array) => SurfaceCounts> {
  const { instance } = await WebAssembly.instantiate(wasm);
  const shell = instance.exports as unknown as Exports;
  return (payload) => {
    const at = shell.shell_payload(payload.length);
    if (at === 0) throw new Error("There is not enough memory to make the surface.");
    new Uint8Array(shell.memory.buffer, at, payload.length).set(payload);
    const opened = shell.shell_open();
    if (opened !== 0) throw new Error(infiniteSamples);
    if (shell.shell_count() !== 0) throw new Error("There is not enough memory to make the surface.");
    return { vertices: shell.shell_vertex_count(), triangles: shell.shell_triangle_count() };
  };
}
