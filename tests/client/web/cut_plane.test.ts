import { trackballRotation } from "../../../client/web/src/scene/cut_handles";
import { clipPlane, initialCut, movedCut, rotatedCut } from "../../../client/web/src/scene/cut_plane";
import { defaults, type Settings } from "../../../client/web/src/state/settings";
import type { Vec3 } from "../../../client/web/src/stream/dataset";
import { plain } from "./made_datasets";

const info = { ...plain("head"), dims: [11, 21, 31], indexToWorld: [1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0] };
const front = { eye: [5, -100, 15], target: [5, 10, 15] };
const cut = (settings: Partial<Settings>) => clipPlane({ ...defaults, ...settings }, info)!;
const distance = ({ normal, constant }: ReturnType<typeof cut>, [x, y, z]: Vec3) => normal.x * x + normal.y * y + normal.z * z + constant;

describe("CutPlane", () => {
  test("AxisPlanesSpanTheData", () => {
    expect(clipPlane(defaults, info)).toBeNull();
    expect(distance(cut({ clip: "y", clipAt: 0.25 }), [0, 5, 0])).toBeCloseTo(0, 9);
    expect(distance(cut({ clip: "y", clipAt: 0.25 }), [0, 6, 0])).toBeCloseTo(1, 9);
    expect(distance(cut({ clip: "y", clipAt: 0.25, clipFlipped: true }), [0, 6, 0])).toBeCloseTo(-1, 9);
  });

  test("ObliquePlanesSpanTheCornersOfTheData", () => {
    const clipNormal: Vec3 = [0.6, -0.8, 0];
    expect(distance(cut({ clip: "oblique", clipNormal, clipAt: 0 }), [0, 20, 7])).toBeCloseTo(0, 9);
    expect(distance(cut({ clip: "oblique", clipNormal, clipAt: 1 }), [10, 0, 3])).toBeCloseTo(0, 9);
    expect(distance(cut({ clip: "oblique", clipNormal, clipAt: 0.5 }), [5, 10, 15])).toBeCloseTo(0, 9);
  });

  test("FacesTheCameraByDefault", () => {
    const begun = initialCut({ clip: "oblique" }, defaults, front);
    expect(begun).toEqual({ clipNormal: [0, 1, 0], clipFlipped: false });
    expect(distance(cut({ clip: "oblique", ...begun }), [5, 12, 15])).toBeGreaterThan(0);
    const turned: Settings = { ...defaults, clip: "oblique", clipNormal: [0, 0, 1] };
    expect(initialCut({ clip: "oblique", clipNormal: null }, turned, front)).toEqual(begun); // By the button.
    expect(initialCut({ clipAt: 0.3 }, turned, front)).toEqual({});
    expect(initialCut({ clip: "oblique" }, { ...turned, clip: "off" }, front)).toEqual({ clipFlipped: false }); // Reuses the previous plane.
    const behind = { eye: [5, 100, 15], target: [5, 10, 15] };
    expect(initialCut({ clip: "y" }, defaults, behind)).toEqual({ clipFlipped: true });
    expect(initialCut({ clip: "y", clipFlipped: false }, defaults, behind)).toEqual({});
  });

  test("MovesWithinTheData", () => {
    expect(movedCut([0, 0, 1], [3, 3, 7.5], info)).toEqual({ clipAt: 0.25 });
    expect(movedCut([0, 0, 1], [3, 3, 99], info)).toEqual({ clipAt: 1 });
  });

  test("RotatesAroundAPlace", () => {
    const place: Vec3 = [4, 13, 20];
    const turned = rotatedCut([0, 0.6, 0.8], place, true, info);
    expect(turned).toMatchObject({ clip: "oblique", clipNormal: [0, 0.6, 0.8], clipFlipped: true });
    expect(distance(cut(turned), place)).toBeCloseTo(0, 9);
  });

  test("RotatesLikeATrackball", () => {
    const turned = (x: number, y: number) => trackballRotation([0, 0, 1], [1, 0, 0], [0, 1, 0], x, y); // Facing the camera at first.
    expect(turned(30, 0)[0]).toBeGreaterThan(0.2);
    expect(turned(30, 0)[1]).toBeCloseTo(0, 9);
    expect(turned(0, 30)[1]).toBeLessThan(-0.2);
    expect(turned(0, 0)).toEqual([0, 0, 1]);
  });
});
