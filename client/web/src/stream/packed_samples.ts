// Unpacks the samples of a SliceReply; conversation.proto describes the format.
import { SampleType } from "../protocol/messages";
import { arrayType, type SampleArray } from "./sample_array";

// As they were sent.
export interface PackedSamples {
  type: SampleType; // Unspecified: floats that are not packed.
  bytes: Uint8Array;
}

const otherCount = "The server's samples are not as many as requested.";
// Rejects if the bytes are not `count` numbers of this type.
export async function unpackedSamples({ type, bytes }: PackedSamples, count: number): Promise<SampleArray> {
  if (type === SampleType.UNSPECIFIED) {
    if (bytes.length !== 4 * count) throw new Error(otherCount);
    return new Float32Array(bytes.slice().buffer); // The bytes may be unaligned in their message.
  }
  const Type = arrayType(type);
  if (!Type) throw new Error("The server sent samples of an unknown type.");
  const width = Type.BYTES_PER_ELEMENT;
  const Sums = width === 4 ? Uint32Array : width === 2 ? Uint16Array : Uint8Array;
  return new Type(summed(new Sums(count), await inflated(bytes, width * count)).buffer);
}

// Adds up the differences.
function summed<T extends Uint8Array<ArrayBuffer> | Uint16Array<ArrayBuffer> | Uint32Array<ArrayBuffer>>(into: T, planes: Uint8Array): T {
  const count = into.length;
  const width = into.BYTES_PER_ELEMENT;
  let value = 0;
  for (let i = 0; i < count; ++i) {
    let code = planes[i];
    if (width > 1) code |= planes[count + i] << 8;
    if (width > 2) code |= (planes[2 * count + i] << 16) | (planes[3 * count + i] << 24);
    value = (value + ((code >>> 1) ^ -(code & 1))) | 0; // Modulo the type's range when it is stored.
    into[i] = value;
  }
  return into;
}

async function inflated(bytes: Uint8Array, length: number): Promise<Uint8Array> {
  const whole = new Uint8Array(length);
  const reader = new Blob([bytes as Uint8Array<ArrayBuffer>]).stream().pipeThrough(new DecompressionStream("deflate")).getReader();
  let at = 0;
  for (let part = await reader.read(); !part.done; part = await reader.read()) {
    if (at + part.value.length > length) {
      void reader.cancel();
      throw new Error(otherCount);
    }
    whole.set(part.value, at);
    at += part.value.length;
  }
  if (at !== length) throw new Error(otherCount);
  return whole;
}
