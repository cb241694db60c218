// Boxes of samples as payloads of tiles (common/codec/plain_box.hpp): what a page without a server makes from a file, and
// the decoder of sample shells marches.
import { type SampleArray, typeCode } from "../static/sample_array";
import type { Vec3 } from "../stream/dataset";

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

const version = 2;
const headerBytes = 48;

// Its counts are 0 until setCounts().
export function plainPayload({ samples, origin, count, layers, layerValue, isovalue, resolution, spacingExponent }: PlainBox): Uint8Array {
  const payload = new Uint8Array(headerBytes + samples.byteLength);
  const view = new DataView(payload.buffer);
  payload.set([version, typeCode(samples), resolution | (spacingExponent << 4), layers]);
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
    if (opened !== 0) throw new Error("The samples of a tile cannot be marched: some are infinite.");
    if (shell.shell_count() !== 0) throw new Error("There is not enough memory to make the surface.");
    return { vertices: shell.shell_vertex_count(), triangles: shell.shell_triangle_count() };
  };
}
