import { deflateSync } from "node:zlib";

import { SampleType } from "../../../client/web/src/protocol/messages";
import { unpackedSamples } from "../../../client/web/src/stream/packed_samples";

// Packs numbers of this many bytes, given as unsigned ones, by the description in the protocol.
function packed(values: readonly number[], width: number): Uint8Array {
  const range = 2 ** (8 * width);
  const planes = new Uint8Array(width * values.length);
  values.forEach((value, i) => {
    const difference = (value - (values[i - 1] ?? 0) + range) % range;
    const code = difference < range / 2 ? 2 * difference : 2 * range - 1 - 2 * difference;
    for (let byte = 0; byte < width; ++byte) planes[byte * values.length + i] = Math.floor(code / 256 ** byte) % 256;
  });
  return deflateSync(planes);
}

const unsigned = (values: readonly number[], width: number) => values.map((value) => (value + 256 ** width) % 256 ** width);

describe("PackedSamples", () => {
  test("AreUnpackedByType", async () => {
    const cases: [SampleType, number, number[]][] = [
      [SampleType.U8, 1, [0, 255, 7, 7, 128]],
      [SampleType.I8, 1, [0, -128, 127, -1, 1]],
      [SampleType.U16, 2, [0, 65535, 32768, 1, 1]],
      [SampleType.I16, 2, [-1024, 3071, 32767, -32768, 0]],
    ];
    for (const [type, width, values] of cases) {
      expect([...(await unpackedSamples({ type: type, bytes: packed(unsigned(values, width), width) }, 5))]).toEqual(values);
    }
  });

  test("MayBePlainFloats", async () => {
    const values = Float32Array.of(1.5, -2);
    expect(await unpackedSamples({ type: SampleType.UNSPECIFIED, bytes: new Uint8Array(values.buffer) }, 2)).toEqual(values);
  });

  test("KeepTheBitsOfFloats", async () => {
    const values = Float32Array.of(0.5, -1e30, NaN, 3e-40, Infinity);
    const bits = [...new Uint32Array(values.buffer)];
    expect(await unpackedSamples({ type: SampleType.F32, bytes: packed(bits, 4) }, 5)).toEqual(values);
  });

  test("AreRefusedIfTheyAreNotTheRequestedOnes", async () => {
    await expect(unpackedSamples({ type: SampleType.U8, bytes: packed([1, 2, 3], 1) }, 2)).rejects.toThrow("not as many");
    await expect(unpackedSamples({ type: SampleType.U8, bytes: packed([1, 2, 3], 1) }, 4)).rejects.toThrow("not as many");
    await expect(unpackedSamples({ type: SampleType.UNSPECIFIED, bytes: Uint8Array.of(1, 2, 3) }, 1)).rejects.toThrow("not as many");
    await expect(unpackedSamples({ type: 99 as SampleType, bytes: packed([1], 1) }, 1)).rejects.toThrow("unknown type");
    await expect(unpackedSamples({ type: SampleType.U8, bytes: Uint8Array.of(1, 2, 3) }, 1)).rejects.toThrow();
  });
});
