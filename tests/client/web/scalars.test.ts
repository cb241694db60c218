import { missingValues, scalarAttribute } from "../../../client/web/src/mesh/scalars";
import { noteOf } from "../../../client/web/src/panel/field_section";
import type { ServerKind, StepBegin } from "../../../client/web/src/protocol/messages";
import { ResumableStream, type StreamEffect } from "../../../client/web/src/stream/resumable_stream";
import { dataset, messages, request } from "./golden_stream";

describe("ScalarAttribute", () => {
  // Sorted by z, then y, then x: vertices 3, 1, 0, 2.
  const positions = Float32Array.from([5, 5, 1, 2, 5, 1, 0, 0, 9, 7, 3, 1]);

  test("AssignsCodesToVertices", () => {
    const attribute = scalarAttribute(positions, Uint8Array.from([0, 127, 254, 255]), 8);
    expect([...attribute]).toEqual([2, 1.5, -1, 1]);
  });

  test("ReadsLittleEndianCodes", () => {
    const codes = Uint8Array.from([0xff, 0xff, 0xfe, 0xff, 0, 0, 0xff, 0x7f]);
    const [second, first, third, none] = [...scalarAttribute(positions, codes, 16)];
    expect([none, first, second]).toEqual([-1, 2, 1]);
    expect(third).toBeCloseTo(1.5, 5);
  });
});

describe("MissingValues", () => {
  test("AreCountedAndShown", () => {
    expect(missingValues(Uint8Array.from([0, 255, 254, 255]), 8)).toBe(2);
    expect(missingValues(Uint8Array.from([255, 254, 255, 255, 254, 255]), 16)).toBe(1);
    const field = { low: 0, high: 1, deviation: 0.5, vertices: 8 };
    expect(noteOf({ ...field, missing: 0 })).not.toContain("no value");
    expect(noteOf({ ...field, missing: 2 })).toContain("25 % of the vertices have no value.");
    expect(noteOf({ ...field, missing: 8 })).toBe("No vertex has a value: the dataset lies elsewhere.");
  });
});

describe("AssemblerScalars", () => {
  const [, , begin] = messages();
  const step = begin.value as StepBegin;

  function colored() {
    const stream = new ResumableStream({ cachedTiles: () => [] });
    stream.request({ info: dataset(), isosurface: request(), scalars: { dataset: "dose", low: -1, high: 3 } });
    const [opened] = stream.open(1n);
    expect(opened).toMatchObject({ message: { value: { scalars: { dataset: "dose", low: -1, high: 3 } } } });
    const range = { low: -1, high: 3, bits: 16 };
    stream.received({ case: "stepBegin", value: { ...step, requestId: 1n, scalars: range } } as ServerKind);
    return (change: object): StreamEffect[] => {
      const codes = new Uint8Array(2 * step.tiles[1].vertices);
      const value = { requestId: 1n, step: 0, index: 1, codes, largestDeviation: 0.25, ...change };
      return stream.received({ case: "tileScalars", value } as ServerKind);
    };
  }

  test("ArriveWithTheirTile", () => {
    const [effect] = colored()({});
    expect(effect).toMatchObject({ kind: "scalars", values: { deviation: 0.25, range: { low: -1, high: 3 } } });
    expect((effect as { values: { key: string } }).values.key).toMatch(/^[0-9a-f]{32}$/);
  });

  test("AreRejectedIfTheyContradictTheManifest", () => {
    for (const change of [{ index: 99 }, { step: 1 }, { codes: new Uint8Array(3) }]) {
      expect(colored()(change)).toMatchObject([{ kind: "failed" }]);
    }
    expect(colored()({ requestId: 0n })).toEqual([]);
  });
});
