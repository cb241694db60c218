// Steps of sample shells that are rejected by their manifest, before any tile is decoded.
import { create, PayloadCodec, ShellStepSchema, ShellValues, type StepBegin, StepBeginSchema } from "../../../client/web/src/protocol/messages";
import { longestCellDiagonal } from "../../../client/web/src/stream/dataset";
import { displacementBound, manifestFault, preservesTopology, shellModeOf } from "../../../client/web/src/stream/step_checks";
import { dataset, request } from "./golden_stream";

const info = dataset();

function step(overrides: { codec?: PayloadCodec; values?: ShellValues; levels?: number; spacing?: number; error?: number; isShell?: boolean }): StepBegin {
  const { codec = PayloadCodec.SAMPLE_SHELL, values = ShellValues.QUANTIZED, levels = 2, spacing = 1, error = 10, isShell = true } = overrides;
  const shell = isShell ? create(ShellStepSchema, { values, levelsPerOctave: levels }) : undefined;
  return create(StepBeginSchema, { request: { ...request(), topologyTolerance: 2 }, codec, shell, finestSpacing: spacing, errorBoundWorld: error });
}

describe("ShellStepChecks", () => {
  test("AcceptEveryMode", () => {
    for (const levels of [1, 2, 4, 8]) expect(manifestFault(step({ levels }), info)).toBeNull();
    expect(manifestFault(step({ values: ShellValues.EXACT, levels: 0, error: 0 }), info)).toBeNull();
    expect(manifestFault(step({ values: ShellValues.LATTICE_EXACT, levels: 0, error: 0 }), info)).toBeNull();
    expect(shellModeOf(step({ values: ShellValues.LATTICE_EXACT, levels: 0, spacing: 4 }))).toEqual({ values: 1, levelsPerOctave: 0, spacing: 4 });
  });

  test("RejectContradictions", () => {
    expect(manifestFault(step({ codec: PayloadCodec.DRACO_LATTICE }), info)).toMatch(/does not match/);
    expect(manifestFault(step({ isShell: false }), info)).toMatch(/does not match/);
    expect(manifestFault(step({ codec: 3 as PayloadCodec }), info)).toMatch(/not negotiated/);
    expect(manifestFault(step({ levels: 3 }), info)).toMatch(/unknown values/);
    expect(manifestFault(step({ values: ShellValues.EXACT, levels: 2 }), info)).toMatch(/unknown values/);
    expect(manifestFault(step({ values: ShellValues.UNSPECIFIED, levels: 0 }), info)).toMatch(/unknown values/);
  });

  test("RejectErrorsBelowThoseOfTheLevels", () => {
    const bound = displacementBound({ values: 2, levelsPerOctave: 2, spacing: 1 }, info);
    expect(bound / longestCellDiagonal(info)).toBeCloseTo(0.0858, 4);
    expect(manifestFault(step({ error: bound }), info)).toBeNull();
    expect(manifestFault(step({ error: 0.99 * bound }), info)).toMatch(/sample shells allow/);
    expect(manifestFault(step({ error: 0, spacing: 2 }), info)).toBeNull(); // A preview has no error bound.
  });

  test("PreserveTopologyWithAnyTolerance", () => {
    expect(preservesTopology(step({}))).toBe(true);
    expect(preservesTopology(step({ spacing: 2 }))).toBe(false);
    expect(preservesTopology(step({ isShell: false, codec: PayloadCodec.DRACO_LATTICE }))).toBe(false);
  });
});
