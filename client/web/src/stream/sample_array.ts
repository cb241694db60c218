// Samples in the types of datasets.
import type { SampleType } from "../protocol/messages";

export type SampleArray = Uint8Array | Int8Array | Uint16Array | Int16Array | Float32Array;

const arrays = [Uint8Array, Int8Array, Uint16Array, Int16Array, Float32Array]; // From SampleType.U8 to SampleType.F32.

export function arrayType(type: SampleType): (typeof arrays)[number] {
  return arrays[type - 1];
}

// 0 for u8 to 4 for f32, as in common/codec/plain_box.hpp.
export function typeCode(samples: SampleArray): number {
  return arrays.findIndex((array) => samples instanceof array);
}

export function sampleBytes(type: SampleType): number {
  return arrayType(type).BYTES_PER_ELEMENT;
}

// Copies bytes, which may be unaligned. Prepared files are little-endian, as are all browsers' machines.
export function samplesOf(type: SampleType, bytes: Uint8Array): SampleArray {
  return new (arrayType(type))(bytes.slice().buffer as ArrayBuffer);
}
