import { readFileSync } from "node:fs";
import { expectedText } from "../../../client/web/src/panel/expected_text";
import { inTriangleRange, maxEstimateFactor, minEstimateFactor } from "../../../client/web/src/shared/quantities";
import type { StepFacts } from "../../../client/web/src/state/progress";
import { ExpectedSizes, shareOfLabel } from "../../../client/web/src/surfaces/expected_sizes";
import { dataset, request as plainRequest } from "./golden_stream";

const info = dataset();
const request = (isovalue: number, normals = 8) => ({ info, isosurface: { ...plainRequest(), isovalue, normals } });
const size = (triangles: number) => ({ triangles, budget: 0, bytes: 2 * triangles, errorVoxels: 1 });

describe("ExpectedSizes", () => {
  test("AreRequestedOncePerRequest", () => {
    const sizes = new ExpectedSizes();
    expect(sizes.isWanted(request(0.1), false)).toBe(true);
    expect(sizes.isWanted(request(0.1), false)).toBe(false);
    expect(sizes.isWanted(request(0.1, 0), true)).toBe(true);
    const failed = request(0.2);
    expect(sizes.isWanted(failed, false)).toBe(true);
    sizes.forget(failed);
    expect(sizes.isWanted(failed, false)).toBe(true);
  });

  test("AreUnknownWhileDraggingTheIsovalue", () => {
    const sizes = new ExpectedSizes();
    sizes.isWanted(request(0.1), false);
    sizes.record(request(0.1), { triangles: 10n, bytes: 20n, errorBoundWorld: 1 });
    expect(sizes.get().expected?.triangles).toBe(10);
    expect(sizes.isWanted(request(0.2), true)).toBe(false);
    expect(sizes.get().expected).toBeNull();
    expect(sizes.isWanted(request(0.2), false)).toBe(true);
  });

  test("RequireConfirmationOfMillions", () => {
    const sizes = new ExpectedSizes();
    expect(sizes.isAllowed(size(1_000_000))).toBe(true);
    expect(sizes.isAllowed(size(9_000_000))).toBe(false);
    sizes.confirm(size(9_000_000));
    expect(sizes.isAllowed(size(10_000_000))).toBe(true);
    expect(sizes.isAllowed(size(20_000_000))).toBe(false);
  });

  test("AreLimitedByABudget", () => {
    const within = new ExpectedSizes().withBudget(request(0.1));
    expect(within.isosurface.maxTriangles).toBe(2_000_000n);
    expect(within.isosurface.isovalue).toBe(0.1);
  });

  test("AllowSmallLabelsByTheirSamples", () => {
    const sizes = new ExpectedSizes();
    const label = (samples: bigint) => ({ ...info, member: { label: { samples } } }) as unknown as typeof info;
    sizes.surfaceCount = 1000; // Each may have 10 000 triangles.
    expect(sizes.isSmall(label(3_600n))).toBe(true);
    expect(sizes.isSmall(label(36_000n))).toBe(false);
    sizes.surfaceCount = 2;
    expect(sizes.isSmall(label(36_000n))).toBe(true);
    expect(sizes.isSmall(label(0n)), "not counted").toBe(false);
    expect(sizes.isSmall(info), "no label").toBe(false);
  });

  test("CountLabelsByTheirSamples", () => {
    const label = (samples: bigint) => ({ ...info, member: { label: { samples } } }) as unknown as typeof info;
    expect(200 * shareOfLabel(label(1000n))).toBeLessThan(0.2);
    expect([shareOfLabel(info), shareOfLabel(label(0n)), shareOfLabel(label(1_000_000_000n))]).toEqual([1, 1, 1]);
  });

  test("DivideTheLimitOfAView", () => {
    const sizes = new ExpectedSizes();
    sizes.surfaceCount = 20;
    expect(sizes.isAllowed(size(500_000))).toBe(true);
    expect(sizes.isAllowed(size(500_001))).toBe(false);
    expect(sizes.withBudget(request(0.1)).isosurface.maxTriangles).toBe(200_000n);
  });
});

describe("ExpectedText", () => {
  const drawn = (more: object) => ({ isFinal: true, shell: null, triangles: 200_000, ...more }) as StepFacts;
  const textOf = (shown: StepFacts | null) => expectedText(size(250_000), shown).replaceAll("\u202f", " ");

  test("IsTheEstimateOfASimplifiedSurface", () => {
    expect(expectedText(null, null)).toBe("");
    expect(textOf(null)).toBe("180 000 to 380 000 triangles, about 488 KiB");
    expect(textOf(drawn({}))).toBe(textOf(null));
  });

  test("NamesADrawnFullResolution", () => {
    const shell = { values: 0, levelsPerOctave: 0, spacing: 1 };
    expect(textOf(drawn({ shell, triangles: 2_516_852 }))).toBe("As a file: 180 000 to 380 000 triangles, about 488 KiB");
    expect(textOf(drawn({ shell, triangles: 2_516_852, isFinal: false }))).toBe(textOf(null));
  });
});

describe("TriangleRange", () => {
  test("IsRoundedOutwardWithinTheBudget", () => {
    const plain = (text: string) => text.replaceAll("\u202f", " ");
    expect(plain(inTriangleRange(15_200))).toBe("11 000 to 23 000 triangles");
    expect(plain(inTriangleRange(15_200, 12_000))).toBe("11 000 to 12 000 triangles");
    expect(plain(inTriangleRange(15_200, 1_000))).toBe("1 000 triangles");
    expect(plain(inTriangleRange(1_000_000))).toBe("750 000 to 1.5 million triangles");
    expect(inTriangleRange(0)).toBe("0 triangles");
  });

  test("MatchesTheCommandLine", () => {
    const header = readFileSync(new URL("../../../common/request/estimate_range.hpp", import.meta.url), "utf8");
    expect(header).toContain(`kMinEstimateFactor = ${minEstimateFactor};`);
    expect(header).toContain(`kMaxEstimateFactor = ${maxEstimateFactor};`);
  });
});
