import { WorldSpace } from "../../../client/web/src/protocol/messages";
import { crossOf, planesThrough, scaleOf, slicePosition, windowOf } from "../../../client/web/src/samples/slices";
import { boxBetween } from "../../../client/web/src/scene/crop";
import { labelsAt } from "../../../client/web/src/scene/slice_drawing";
import { axisNormal, cutCorners, extentAlong, maxPixels, planeGrid, seenPart, sliceGrid, valueAt } from "../../../client/web/src/scene/slice_grid";
import { planeAxes } from "../../../client/web/src/scene/slice_view";
import { colorAt, colorMaps, colorRow } from "../../../client/web/src/shared/color_maps";
import { defaults } from "../../../client/web/src/state/settings";
import { nearestSample, type Vec3, worldSpacing } from "../../../client/web/src/stream/dataset";
import { plain } from "./made_datasets";

const low: Vec3 = [0, 10, -4];
const high: Vec3 = [100, 60, 4];

describe("SliceGrid", () => {
  test("CoversTheBoxOnAnyAxis", () => {
    for (const axis of [0, 1, 2]) {
      const { origin, right, down, width, height } = sliceGrid(low, high, axisNormal("xyz"[axis] as "x"), 0.25, [2, 1, 4]);
      const center = (x: number, y: number) => origin.map((part, i) => part + x * right[i] + y * down[i]);
      const [from, to] = [center(0, 0), center(width - 1, height - 1)];
      for (let i = 0; i < 3; ++i) {
        const expected = i === axis ? [0.75 * low[i] + 0.25 * high[i]] : [low[i], high[i]];
        expect(from[i]).toBeCloseTo(expected[0], 9);
        expect(to[i]).toBeCloseTo(expected.at(-1)!, 9);
      }
      expect([...right, ...down].map(Math.abs).filter((part) => part > 0)).toEqual(
        [
          [1, 4],
          [4, 2],
          [2, 1],
        ][axis],
      ); // Each pixel is a sample.
    }
  });

  test("CoversObliqueSections", () => {
    for (const normal of [
      [0.6, 0.8, 0],
      [1 / Math.sqrt(3), -1 / Math.sqrt(3), 1 / Math.sqrt(3)],
      [-1, 0, 0],
    ] as Vec3[]) {
      for (const at of [0, 0.1, 0.5, 1]) {
        const { origin, right, down, width, height } = sliceGrid(low, high, normal, at, [2, 2, 2]);
        const { from, to } = extentAlong(low, high, normal);
        const dot = (a: Vec3, b: Vec3) => a.reduce((sum, part, i) => sum + part * b[i], 0);
        expect(dot(origin, normal)).toBeCloseTo(from + at * (to - from), 6);
        for (const side of [right, down]) expect(dot(side, normal)).toBeCloseTo(0, 6);
        expect(dot(right, down)).toBeCloseTo(0, 6);
        const corners = cutCorners(low, high, normal, from + at * (to - from)); // All lie in the slice, at its border.
        const shares = corners.map((corner) =>
          [
            [right, width],
            [down, height],
          ].map(([side, pixels]) => {
            const step = side as Vec3;
            return dot(corner.map((part, i) => part - origin[i]) as Vec3, step) / dot(step, step) / ((pixels as number) - 1);
          }),
        );
        for (const along of [0, 1]) {
          const all = shares.map((share) => share[along]);
          if (at === 0 || at === 1) continue;
          expect(Math.min(...all)).toBeCloseTo(0, 6);
          expect(Math.max(...all)).toBeCloseTo(1, 6);
        }
        for (const place of corners)
          place.forEach((part, i) => {
            expect(part).toBeGreaterThan(low[i] - 1e-6);
            expect(part).toBeLessThan(high[i] + 1e-6);
          });
        if (at === 0.5) expect(corners.length).toBeGreaterThanOrEqual(4);
      }
    }
  });

  test("LimitsThePixelsOfAnyVolume", () => {
    const { width, height } = sliceGrid([0, 0, 0], [16384, 16384, 9000], [0, 0, 1], 0.5, [1, 1, 1]);
    expect([width, height]).toEqual([maxPixels, maxPixels]);
    expect(sliceGrid([0, 0, 0], [1, 0, 5], [0, 0, 1], 0.5, [1, 1, 1])).toMatchObject({ width: 2, height: 1 });
  });

  test("ReturnsTheValueAtAPlace", () => {
    const grid = sliceGrid([0, 0, 0], [3, 1, 9], [0, 0, 1], 0, [1, 1, 1]);
    const slice = { grid, values: Float32Array.from([0, 1, 2, 3, 4, 5, 6, 7]), sampleSpacing: 1 };
    expect(valueAt(slice, [0.2, 0.3, 0])).toBe(0);
    expect(valueAt(slice, [2.9, 0.9, 0])).toBe(7);
    expect(valueAt(slice, [2.2, 0.4, 0])).toBe(2);
    expect(valueAt(slice, [3.1, 0.9, 0])).toBeNaN();
    expect(valueAt(slice, [0.2, -0.1, 0])).toBeNaN();
  });
});

describe("LinkedSlices", () => {
  const info = { ...plain("a"), indexToWorld: [1, 0, 0, 0, 1, 0, 0, 0, 1, 10, 0, 0] };

  test("FollowTheMedicalConvention", () => {
    const lps = { space: WorldSpace.LPS, lengthUnit: "mm" };
    expect(planeAxes(lps, 2)).toEqual({ axis: 2, right: { axis: 0, sign: 1 }, down: { axis: 1, sign: 1 } });
    expect(planeAxes({ space: WorldSpace.RAS, lengthUnit: "mm" }, 2)).toEqual({ axis: 2, right: { axis: 0, sign: -1 }, down: { axis: 1, sign: -1 } });
    expect(planeAxes(lps, 1)).toEqual({ axis: 1, right: { axis: 0, sign: 1 }, down: { axis: 2, sign: -1 } });
    expect(planeAxes({ space: WorldSpace.RAS, lengthUnit: "mm" }, 0)).toEqual({ axis: 0, right: { axis: 1, sign: -1 }, down: { axis: 2, sign: -1 } });
  });

  test("ShowMicroscopesImagesWithTheirFirstRowAtTheTop", () => {
    const microscope = { space: WorldSpace.UNSPECIFIED, lengthUnit: "µm" };
    expect(planeAxes(microscope, 2).down).toEqual({ axis: 1, sign: 1 });
    expect(planeAxes(microscope, 1).down).toEqual({ axis: 2, sign: 1 });
    const simulation = { space: WorldSpace.UNSPECIFIED, lengthUnit: "m" };
    expect(planeAxes(simulation, 2).down).toEqual({ axis: 1, sign: -1 });
  });

  test("BeginAtTheUpperLeftCorner", () => {
    for (const space of [WorldSpace.LPS, WorldSpace.RAS]) {
      for (const axis of [0, 1, 2]) {
        const sides = planeAxes({ space, lengthUnit: "" }, axis);
        const { origin, right, down, width, height } = planeGrid(low, high, sides, low[axis] + 1, [2, 2, 2]);
        expect(origin[axis]).toBe(low[axis] + 1);
        for (const [along, step, count] of [
          [sides.right, right, width],
          [sides.down, down, height],
        ] as const) {
          const [from, to] = along.sign > 0 ? [low, high] : [high, low];
          expect(origin[along.axis]).toBe(from[along.axis]);
          expect(origin[along.axis] + (count - 1) * step[along.axis]).toBeCloseTo(to[along.axis], 9);
        }
      }
    }
  });

  test("KnowTheSamplesOfTheAxes", () => {
    // A volume of 9 x 9 x 9 samples; index z is world x.
    const thick = { ...plain("a"), indexToWorld: [0, -0.5, 0, 0, 0, 0.5, 3, 0, 0, 10, 0, 0], spacing: [0.5, 0.5, 3] };
    expect(worldSpacing(thick)).toEqual([3, 0.5, 0.5]);
    expect(nearestSample(thick, 0, 14.2)).toBe(13);
    expect(nearestSample(thick, 1, -99)).toBe(-4);
    expect(nearestSample(thick, 2, 99)).toBe(4);
    const oblique = { ...thick, indexToWorld: [0.4, 0.3, 0, -0.3, 0.4, 0, 0, 0, 3, 0, 0, 0] };
    expect(worldSpacing(oblique)).toEqual([0.5, 0.5, 3]);
  });

  test("HaveAllSamplesOfWhatIsSeenInLargeVolumes", () => {
    const box = { low: [0, 0, 0] as Vec3, high: [4095, 2047, 99] as Vec3 };
    const spacing: Vec3 = [1, 0.5, 1];
    const sides = planeAxes({ space: WorldSpace.LPS, lengthUnit: "mm" }, 1); // x to the right, z downwards.
    const part = (x: number) => seenPart(box, sides, [x, 700, 50], [0.1, 0.3], spacing);
    const { low, high } = part(2048.2);
    expect([low[1], high[1], low[2], high[2]]).toEqual([0, 2047, 0, 99]); // Across the plane, and all pixels.
    expect(low[0]).toBeLessThan(2048 - 0.05 * 4095);
    expect(high[0]).toBeGreaterThan(2048 + 0.05 * 4095);
    const { width, right } = planeGrid(low, high, sides, 700, spacing);
    expect([width <= maxPixels, right[0], low[0] % 1]).toEqual([true, 1, 0]);
    expect(part(2060)).toEqual(part(2048.2));
    expect(part(4000).high[0]).toBe(4095);
    expect(part(4000).low[0]).toBeGreaterThan(low[0]);
  });

  test("MeetInTheCenterByDefault", () => {
    expect(crossOf(null, info)).toEqual([14, 4, 4]);
    expect(crossOf(null, { ...info, dims: [8, 9, 9] })[0]).toBe(14); // A sample, not between two.
    expect(crossOf([12, -3, 99], info)).toEqual([12, 0, 8]);
  });

  test("MoveToTheCenterOfABoxThatTheyMiss", () => {
    const box = boxBetween({ low: [11, 1, 1], high: [13, 3, 7] });
    expect(planesThrough(box, { ...defaults, layout: "four" }, info)).toEqual({ cross: [12, 2, 4] });
    expect(planesThrough(box, { ...defaults, layout: "four", cross: [11, 3, 1] }, info)).toEqual({});
    expect(planesThrough(box, { ...defaults, slice: "y" }, info)).toEqual({ sliceAt: 0.25 });
    expect(planesThrough(box, { ...defaults, slice: "z" }, info)).toEqual({});
    expect(planesThrough(box, defaults, info)).toEqual({});
    expect(planesThrough(boxBetween({ low: [1, 0, 0], high: [0, 1, 1] }), { ...defaults, layout: "four", slice: "y" }, info)).toEqual({});
  });
});

describe("Slices", () => {
  test("FillTheCutByDefault", () => {
    expect(slicePosition(defaults)).toBeNull();
    expect(slicePosition({ ...defaults, clip: "y", clipAt: 0.3 })).toEqual({ normal: [0, 1, 0], at: 0.3, isFilling: true });
    expect(slicePosition({ ...defaults, clip: "oblique", clipNormal: [0, 0.6, 0.8] })).toEqual({ normal: [0, 0.6, 0.8], at: 0.5, isFilling: true });
    expect(slicePosition({ ...defaults, clip: "y", filled: false })).toBeNull();
    expect(slicePosition({ ...defaults, clip: "y", slice: "z", sliceAt: 0.1 })).toEqual({ normal: [0, 0, 1], at: 0.1, isFilling: false });
  });

  test("HaveTheSelectedOrDefaultWindow", () => {
    const info = { min: -1000, max: 3000 };
    expect(windowOf(null, null, info)).toEqual({ low: -1000, high: 3000 });
    expect(windowOf(40, 400, info)).toEqual({ low: -160, high: 240 });
    expect(windowOf(null, null, { ...info, usual: { level: 40, width: 80 } })).toEqual({ low: 0, high: 80 });
    expect(windowOf(10, null, { ...info, usual: { level: 40, width: 80 } })).toEqual({ low: -30, high: 50 });
    expect(scaleOf(40, 400, false, info)).toEqual({ low: -160, high: 240, isLog: false });
  });
});

describe("ColorMaps", () => {
  test("ClampOutsideOfTheirRange", () => {
    expect(colorAt("viridis", -3)).toEqual([0x44, 0x01, 0x54]);
    expect(colorAt("viridis", 7)).toEqual([0xfd, 0xe7, 0x25]);
    expect(colorAt("gray", 0.5)).toEqual([128, 128, 128]);
    expect([...colorRow("gray", 3)]).toEqual([0, 0, 0, 255, 128, 128, 128, 255, 255, 255, 255, 255]);
  });

  // Except in diverging maps, larger values are lighter: for print and color-blind readers.
  test("HaveMonotonicLightness", () => {
    for (const map of colorMaps.filter((one) => one !== "coolwarm")) {
      const lightness = (share: number) => {
        const [r, g, b] = colorAt(map, share);
        return 0.2126 * r + 0.7152 * g + 0.0722 * b;
      };
      for (let i = 1; i <= 20; ++i) expect(lightness(i / 20)).toBeGreaterThan(lightness((i - 1) / 20));
    }
  });
});

describe("LabelsAt", () => {
  // The contour of a square of side 10 with a hole of side 2, in lattice steps of half a unit, on the plane z = 3.
  const loop = (...corners: number[][]) => corners.flatMap(([x, y], i) => [2 * x, 2 * y, 6, ...corners[(i + 1) % corners.length].map((at) => 2 * at), 6]);
  const square = (low: number, size: number) => loop([low, low], [low + size, low], [low + size, low + size], [low, low + size]);
  const toWorld = [0.5, 0, 0, 0, 0.5, 0, 0, 0, 0.5, 0, 0, 0];
  const cut = (segments: number[], label: string | null) => ({ segments: Float32Array.from(segments), toWorld, color: "#fff", label });
  const sides = planeAxes({ space: WorldSpace.UNSPECIFIED, lengthUnit: "mm" }, 2);

  test("AreThoseWhoseContoursEncloseThePlace", () => {
    const lines = [cut([...square(0, 10), ...square(4, 2)], "Kidney"), cut(square(1, 2), "Cyst"), cut(square(0, 10), null)];
    expect(labelsAt([2, 2, 3], lines, sides)).toEqual(["Kidney", "Cyst"]);
    expect(labelsAt([5, 5, 3], lines, sides)).toEqual([]); // In the hole.
    expect(labelsAt([11, 5, 3], lines, sides)).toEqual([]);
  });

  test("IgnoreContoursThatAreOpenBesideThePlace", () => {
    const open = cut(square(0, 10).slice(6), "Lung"); // Without the side at y = 0: rays along x pass through two others.
    expect(labelsAt([2, 2, 3], [open], sides)).toEqual(["Lung"]);
    const opposite = cut(square(0, 10).slice(0, 18), "Lung"); // Without the side at x = 0.
    expect(labelsAt([2, 2, 3], [opposite], sides)).toEqual([]);
  });
});
