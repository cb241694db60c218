import { accuracyInUnits, accuracyOf, certificateSummary, errorExplanation, leastAccurate } from "../../../client/web/src/panel/certificate";
import type { DrawnSurface, ShownComponents, StepFacts } from "../../../client/web/src/state/progress";

const facts = (overrides: Partial<StepFacts>) =>
  ({
    errorVoxels: 0.5,
    errorWorld: 0.25,
    lengthUnit: "mm",
    isCertified: true,
    preservesTopology: true,
    pixels: null,
    spacing: 1,
    tolerance: 0,
    ...overrides,
  }) as StepFacts;

describe("Accuracy", () => {
  test("ShowsCertifiedBounds", () => {
    expect(accuracyOf(facts({}), 3)).toEqual({ value: "≤ 0.5", unit: "voxels" });
    expect(accuracyOf(facts({ errorVoxels: 1 }), 3)).toEqual({ value: "≤ 1", unit: "voxel" });
    expect(errorExplanation(facts({}))).toMatch(/^No point of this surface is farther than this \(0\.25 mm\)/);
  });

  test("ShowsLengthsInTheUnitOfTheFile", () => {
    expect(accuracyInUnits(facts({}))).toEqual({ value: "≤ 0.25 mm", label: "error, 0.5 voxels" });
    expect(accuracyInUnits(facts({ lengthUnit: "" }))).toEqual({ value: "≤ 0.5 voxels", label: "error" });
    expect(accuracyInUnits(facts({ spacing: 4 }))).toEqual({ value: "1 in 4", label: "samples per axis" });
  });

  test("ShowsTheSpacingOfPreviews", () => {
    const preview = facts({ spacing: 4, errorVoxels: 4, isCertified: false, preservesTopology: false });
    expect(accuracyOf(preview, 3)).toEqual({ value: "1 in 4", unit: "samples per axis" });
    expect(errorExplanation(preview)).toMatch(/one sample in 4 along each axis.*no error bound/);
  });

  test("ShowsNoBoundWithoutCertification", () => {
    expect(accuracyOf(facts({ isCertified: false }), 3)).toEqual({ value: "0.5", unit: "voxels" });
    expect(errorExplanation(facts({ isCertified: false }))).toMatch(/actual distance may exceed it/);
    expect(errorExplanation(facts({ isCertified: false, preservesTopology: false, tolerance: 2 }))).toMatch(
      /features up to 2 voxels may be missing, as requested/,
    );
  });
});

describe("CertificateSummary", () => {
  const drawn = (borderEdges: number, components: Partial<ShownComponents> | null = null) =>
    ({ number: 1, shown: facts({ topology: { borderEdges, components: 5 } as StepFacts["topology"] }), components }) as DrawnSurface;

  test("RequiresAllSurfacesToBeWatertight", () => {
    expect(certificateSummary([drawn(0)])).toBe("✓ Watertight, within 0.25 mm");
    expect(certificateSummary([drawn(0), drawn(0)])).toBe("✓ Watertight, within 0.25 mm");
    expect(certificateSummary([drawn(0), drawn(6762)])).toBe("✓ No cracks, within 0.25 mm");
  });

  test("ShowsAnErrorOnlyIfAllAreCertified", () => {
    const with_ = (overrides: Partial<StepFacts>) => {
      const one = drawn(0);
      return { ...one, shown: { ...one.shown, ...overrides } };
    };
    expect(certificateSummary([with_({ isCertified: false })])).toBe("✓ Watertight");
    expect(certificateSummary([drawn(0), with_({ isCertified: false })])).toBe("✓ Watertight");
    expect(certificateSummary([with_({ spacing: 4 })])).toBe("✓ Watertight, preview");
    expect(certificateSummary([with_({ errorWorld: 0, errorVoxels: 0 })])).toBe("✓ Watertight, full resolution");
    expect(certificateSummary([with_({ lengthUnit: "" })])).toBe("✓ Watertight, within 0.5 voxels");
    expect(certificateSummary([drawn(0), with_({ errorWorld: 1, errorVoxels: 2 })])).toBe("✓ Watertight, within 1 mm");
  });

  test("SumsVisibleComponents", () => {
    const dusty = drawn(0, { components: 40, shown: 3, triangles: 9, minComponent: 8 });
    expect(certificateSummary([dusty])).toMatch(/3 of 40 components shown$/);
    expect(certificateSummary([drawn(0), dusty])).toMatch(/8 of 45 components shown$/);
  });
});

describe("LeastAccurateSurface", () => {
  const of = (overrides: Partial<StepFacts>) => ({ number: 1, shown: facts(overrides), components: null }) as DrawnSurface;

  test("PicksTheCoarsestPreviewOrLargestError", () => {
    expect(leastAccurate([])).toBeNull();
    expect(leastAccurate([of({ errorVoxels: 1 }), of({ errorVoxels: 2 })])?.errorVoxels).toBe(2);
    expect(leastAccurate([of({ errorVoxels: 9 }), of({ spacing: 2, errorVoxels: 2 }), of({ spacing: 8, errorVoxels: 8 })])?.spacing).toBe(8);
  });
});
