import { accuracyOf, errorWords } from "../../../client/web/src/panel/certificate";
import type { StepFacts } from "../../../client/web/src/state/progress";

const facts = (said: Partial<StepFacts>) => ({
  errorVoxels: 0.5, errorWorld: 0.25, lengthUnit: "mm", isCertified: true, preservesTopology: true, pixels: null, spacing: 1,
  tolerance: 0, ...said,
}) as StepFacts;

describe("Accuracy", () => {
  test("IsABoundWhereItIsCertified", () => {
    expect(accuracyOf(facts({}), 3)).toEqual({ value: "≤ 0.5", unit: "voxels" });
    expect(accuracyOf(facts({ errorVoxels: 1 }), 3)).toEqual({ value: "≤ 1", unit: "voxel" });
    expect(errorWords(facts({}))).toMatch(/^No point of this surface is farther than this \(0\.25 mm\)/);
  });

  test("OfAPreviewIsItsSpacingBecauseItPromisesNoError", () => {
    const preview = facts({ spacing: 4, errorVoxels: 4, isCertified: false, preservesTopology: false });
    expect(accuracyOf(preview, 3)).toEqual({ value: "1 in 4", unit: "samples" });
    expect(errorWords(preview)).toMatch(/one sample in 4 along each axis.*promises no error/);
  });

  test("IsNoBoundInThePapersMeasureOrWherePartsMayVanish", () => {
    expect(accuracyOf(facts({ isCertified: false }), 3)).toEqual({ value: "0.5", unit: "voxels" });
    expect(errorWords(facts({ isCertified: false }))).toMatch(/real distance may exceed it/);
    expect(errorWords(facts({ isCertified: false, preservesTopology: false, tolerance: 2 }))).toMatch(/features up to 2 voxels may be missing, as you asked/);
  });
});
