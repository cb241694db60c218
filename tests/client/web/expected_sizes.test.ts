import { ExpectedSizes } from "../../../client/web/src/expected_sizes";
import { dataset, request } from "./golden_stream";

const info = dataset();
const order = (isovalue: number, normals = 8) => ({ info, request: { ...request(), isovalue, normals } });
const size = (triangles: number) => ({ triangles, bytes: 2 * triangles, errorVoxels: 1 });

describe("ExpectedSizes", () => {
  test("RequestedOncePerRequest", () => {
    const sizes = new ExpectedSizes();
    expect(sizes.isWanted(order(0.1), false)).toBe(true);
    expect(sizes.isWanted(order(0.1), false)).toBe(false);
    expect(sizes.isWanted(order(0.1, 0), true)).toBe(true);
    sizes.forget();
    expect(sizes.isWanted(order(0.1, 0), false)).toBe(true);
  });

  test("UnknownWhileTheIsovalueIsDragged", () => {
    const sizes = new ExpectedSizes();
    sizes.isWanted(order(0.1), false);
    sizes.learn({ kind: "size", order: order(0.1), triangles: 10, bytes: 20, errorWorld: 1 });
    expect(sizes.get().expected?.triangles).toBe(10);
    expect(sizes.isWanted(order(0.2), true)).toBe(false);
    expect(sizes.get().expected).toBeNull();
    expect(sizes.isWanted(order(0.2), false)).toBe(true);
  });

  test("MillionsNeedConfirmation", () => {
    const sizes = new ExpectedSizes();
    expect(sizes.isAllowed(size(1_000_000))).toBe(true);
    expect(sizes.isAllowed(size(9_000_000))).toBe(false);
    sizes.allow(size(9_000_000));
    expect(sizes.isAllowed(size(10_000_000))).toBe(true);
    expect(sizes.isAllowed(size(20_000_000))).toBe(false);
  });

  test("LimitedByABudget", () => {
    const within = new ExpectedSizes().affordable(order(0.1));
    expect(within.request.maxTriangles).toBe(2_000_000n);
    expect(within.request.isovalue).toBe(0.1);
  });

  test("KnowSmallLabelsByTheirSamples", () => {
    const sizes = new ExpectedSizes();
    const label = (samples: bigint) => ({ ...info, member: { label: { samples } } }) as unknown as typeof info;
    sizes.among = 1000; // 10 000 triangles are for each.
    expect(sizes.isSmall(label(3_600n))).toBe(true);
    expect(sizes.isSmall(label(36_000n))).toBe(false);
    sizes.among = 2;
    expect(sizes.isSmall(label(36_000n))).toBe(true);
    expect(sizes.isSmall(label(0n)), "not counted").toBe(false);
    expect(sizes.isSmall(info), "no label").toBe(false);
  });

  test("ShareWhatAViewCanHave", () => {
    const sizes = new ExpectedSizes();
    sizes.among = 20;
    expect(sizes.isAllowed(size(500_000))).toBe(true);
    expect(sizes.isAllowed(size(500_001))).toBe(false);
    expect(sizes.affordable(order(0.1)).request.maxTriangles).toBe(200_000n);
  });
});
