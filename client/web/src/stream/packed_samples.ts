// Unpacks the samples of a SliceReply; conversation.proto describes the format.
import { SampleType } from "../protocol/messages";

const otherCount = "The server's samples are not as many as requested.";
const bytesOf = new Map([
  [SampleType.U8, 1],
  [SampleType.I8, 1],
  [SampleType.U16, 2],
  [SampleType.I16, 2],
  [SampleType.F32, 4],
]);

// Rejects if the bytes are not `count` numbers of this type; floats that are not packed if it is unspecified.
export async function unpackedSamples(type: SampleType, bytes: Uint8Array, count: number): Promise<Float32Array> {
  if (type === SampleType.UNSPECIFIED) {
    if (bytes.length !== 4 * count) throw new Error(otherCount);
    return new Float32Array(bytes.slice().buffer); // The bytes may be unaligned in their message.
  }
  const width = bytesOf.get(type);
  if (!width) throw new Error("The server sent samples of an unknown type.");
  const planes = await inflated(bytes, width * count);
  if (type === SampleType.F32) return new Float32Array(numbers(new Uint32Array(count), planes).buffer);
  if (type === SampleType.U8) return new Float32Array(numbers(new Uint8Array(count), planes));
  if (type === SampleType.I8) return new Float32Array(new Int8Array(numbers(new Uint8Array(count), planes).buffer));
  const shorts = numbers(new Uint16Array(count), planes);
  return new Float32Array(type === SampleType.U16 ? shorts : new Int16Array(shorts.buffer));
}

// Adds up the differences.
function numbers<T extends Uint8Array<ArrayBuffer> | Uint16Array<ArrayBuffer> | Uint32Array<ArrayBuffer>>(into: T, planes: Uint8Array): T {
  const count = into.length;
  const width = into.BYTES_PER_ELEMENT;
  let value = 0;
  for (let i = 0; i < count; ++i) {
    let code = planes[i];
    for (let byte = 1; byte < width; ++byte) code |= planes[byte * count + i] << (8 * byte);
    value += (code >>> 1) ^ -(code & 1);
    into[i] = value; // Modulo the type's range.
    value = into[i];
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
