import { Combination } from "../../../client/web/src/protocol/messages";
import { defaults, type WrittenSettings, writtenDefaults } from "../../../client/web/src/state/settings";
import { voxelLength, worldBox } from "../../../client/web/src/stream/dataset";
import { isosurfaceRequest, isSameRequest, nearestPixel, surfaceKey } from "../../../client/web/src/stream/request";
import { ViewDependentDetail } from "../../../client/web/src/viewer/view_dependent_detail";
import { dataset } from "./golden_stream";

const info = dataset();
const { low, high } = worldBox(info);
const middle = low.map((at, axis) => (at + high[axis]) / 2);
// A view from the front at this distance from the data's box.
const viewFrom = (distance: number) => ({
  eye: [middle[0], low[1] - distance, middle[2]],
  target: middle,
  up: [0, 0, 1],
  fieldOfView: 35,
  heightPixels: 600,
  aspect: 1,
});
const requestFor = (overrides: Partial<WrittenSettings>, distance: number | null) =>
  isosurfaceRequest(info, { ...writtenDefaults, isovalue: 0.1, ...overrides }, distance === null ? null : viewFrom(distance));
const far = 1000 * voxelLength(info);
const near = 10 * voxelLength(info);

describe("ScreenSpaceError", () => {
  test("PixelLengthIsThatAtTheNearestData", () => {
    expect(nearestPixel(info, viewFrom(far))).toBeCloseTo((2 * 1000 * Math.tan((17.5 * Math.PI) / 180)) / 600, 9);
    expect(nearestPixel(info, { ...viewFrom(0), eye: middle })).toBe(0);
  });

  test("IsOmittedForDistantViews", () => {
    const plain = requestFor({}, null);
    expect(plain.threshold!.view).toBeUndefined();
    expect(isSameRequest(requestFor({}, far), plain)).toBe(true);
    expect(isSameRequest(requestFor({}, 2 * far), plain)).toBe(true);
    expect(isSameRequest(requestFor({ error: 0 }, near), requestFor({ error: 0 }, null))).toBe(true);
    expect(isSameRequest(requestFor({ followView: false }, near), requestFor({ followView: false }, null))).toBe(true);
  });

  test("IsNeverCoarserThanTheAllowedError", () => {
    const { threshold } = requestFor({ error: 0.5, pixels: 2 }, near);
    expect(threshold).toMatchObject({ combine: Combination.MINIMUM, error: 0.5, view: { tolerancePixels: 2, frustum: { outside: 0.5 } } });
    // The view replaces `error`, so a box around all data restates it.
    const [box] = threshold!.regions;
    expect(box.threshold).toBe(0.5);
    const { low: from, high: to } = box.shape.value as { low: number[]; high: number[] };
    expect(from.every((at, axis) => at < low[axis] - voxelLength(info))).toBe(true);
    expect(to.every((at, axis) => at > high[axis] + voxelLength(info))).toBe(true);
  });

  test("KeepsRegions", () => {
    const region = { kind: "ball" as const, center: [1, 2, 3] as [number, number, number], radius: 4, error: 0 };
    const { threshold } = requestFor({ error: 0.5, region }, near);
    expect(threshold!.regions.map(({ threshold: one }) => one)).toEqual([0.5, 0]);
    const coarser = { ...region, error: 4 };
    expect(isSameRequest(requestFor({ error: 0.5, region: coarser }, near), requestFor({ error: 0.5, region: coarser }, null))).toBe(true);
  });

  test("IsThatOfTooLargeSurfacesAloneWhileOthersAreCompleted", () => {
    const detail = new ViewDependentDetail();
    const view = () => detail.view(defaults, () => viewFrom(far));
    const request = (isovalue: number) => isosurfaceRequest(info, { ...writtenDefaults, error: 0, isovalue }, view());
    const plain = request(0.2);
    expect(detail.require(surfaceKey(info, 0.1))).toBe(true);
    for (const milliseconds of [5000, 10]) {
      expect([request(0.1).threshold?.view === undefined, isSameRequest(request(0.2), plain)]).toEqual([false, true]);
      detail.recordDuration(milliseconds); // Of the surface that is not too large.
    }
    expect(detail.require(surfaceKey(info, 0.1))).toBe(false);
  });
});
