import { clipPlanes, cropFaces, cropPlanes } from "../../../client/web/src/scene/crop";
import { defaults } from "../../../client/web/src/state/settings";
import { plain } from "./made_datasets";

const info = { ...plain("head"), dims: [11, 21, 31], indexToWorld: [1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0] };
const crop = { low: [2, -5, 6], high: [8, 10, 99] } as { low: [number, number, number]; high: [number, number, number] };

describe("Crop", () => {
  test("KeepsTheInsideOfItsPlanes", () => {
    const isInside = (x: number, y: number, z: number) => cropPlanes(crop).every((plane) => plane.distanceToPoint(plane.normal.clone().set(x, y, z)) >= 0);
    expect(isInside(2, 0, 6)).toBe(true);
    expect(isInside(8, 10, 30)).toBe(true);
    expect([isInside(1.9, 0, 7), isInside(8.1, 0, 7), isInside(5, 10.1, 7), isInside(5, 0, 5.9)]).toEqual([false, false, false, false]);
    expect(cropPlanes(null)).toEqual([]);
  });

  test("FollowsTheCut", () => {
    expect(clipPlanes({ ...defaults, crop, clip: "x" }, info)).toHaveLength(7);
    expect(clipPlanes({ ...defaults, crop, clip: "x" }, info).slice(1)).toEqual(cropPlanes(crop));
    expect(clipPlanes(defaults, info)).toEqual([]);
  });

  test("HasFacesInsideTheDataOnly", () => {
    expect(cropFaces(crop, info)).toEqual([
      { number: 0, normal: [1, 0, 0], at: 0.2 },
      { number: 1, normal: [1, 0, 0], at: 0.8 },
      { number: 3, normal: [0, 1, 0], at: 0.5 },
      { number: 4, normal: [0, 0, 1], at: 0.2 },
    ]);
    expect(cropFaces(null, info)).toEqual([]);
  });
});
