// Samples in the types of prepared files.
import { SampleType } from "../protocol/messages";

export type SampleArray = Uint8Array | Int8Array | Uint16Array | Int16Array | Float32Array;

const types = {
  u8: [SampleType.U8, Uint8Array],
  i8: [SampleType.I8, Int8Array],
  u16: [SampleType.U16, Uint16Array],
  i16: [SampleType.I16, Int16Array],
  f32: [SampleType.F32, Float32Array],
} as const;

// Undefined: no such type.
export function sampleTypeOf(name: unknown): SampleType | undefined {
  return Object.hasOwn(types, String(name)) ? types[String(name) as keyof typeof types][0] : undefined;
}

export function arrayType(type: SampleType): (typeof types)[keyof typeof types][1] {
  return Object.values(types).find(([one]) => one === type)![1];
}

export function sampleBytes(type: SampleType): number {
  return arrayType(type).BYTES_PER_ELEMENT;
}

// Copies bytes, which may be unaligned. Prepared files are little-endian, as are all browsers' machines.
export function samplesOf(type: SampleType, bytes: Uint8Array): SampleArray {
  return new (arrayType(type))(bytes.slice().buffer as ArrayBuffer);
}

// 0 for u8 to 4 for f32, as in common/codec/plain_box.hpp.
export function samplesTypeCode(samples: SampleArray): number {
  return Object.values(types).findIndex(([, array]) => samples instanceof array);
}
