import { cutLine } from "../../../client/web/src/mesh/cut";
import { massProperties, volumeBound } from "../../../client/web/src/mesh/mass_properties";
import { WorldSpace } from "../../../client/web/src/protocol/messages";
import { axisNames } from "../../../client/web/src/scene/axis_names";
import { angleAt, areaText, distanceOf, lengthWithBound, volumeText } from "../../../client/web/src/scene/measures";
import { volumeHint } from "../../../client/web/src/scene/measuring";
import { ticks } from "../../../client/web/src/scene/ticks";
import { roundedWithin, withBound } from "../../../client/web/src/shared/quantities";
import { placeText } from "../../../client/web/src/stream/dataset";
import { plain } from "./made_datasets";

const identity = [1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0];

// The closed surface of a box, counterclockwise from outside, in two tiles that share an edge loop.
function box(low: number[], high: number[], name: string) {
  const corner = (bits: number) => [0, 1, 2].map((axis) => (bits & (1 << axis) ? high : low)[axis]);
  const positions = Float32Array.from([0, 1, 2, 3, 4, 5, 6, 7].flatMap(corner));
  const sides = [
    [0, 2, 3, 1],
    [4, 5, 7, 6],
    [0, 1, 5, 4],
    [2, 6, 7, 3],
    [0, 4, 6, 2],
    [1, 3, 7, 5],
  ];
  const triangles = sides.map(([a, b, c, d]) => [a, b, c, a, c, d]);
  const tile = (id: string, from: number, to: number) => ({ id, positions, triangles: Uint16Array.from(triangles.slice(from, to).flat()) });
  return [tile(`${name}/left`, 0, 3), tile(`${name}/right`, 3, 6)];
}

describe("Coordinates", () => {
  test("HaveNoRoundingErrors", () => {
    const info = { ...plain("head"), spacing: [0.5, 0.5, 2] };
    expect(placeText([1.138e-14, -1e-15, 12.345678], info)).toBe("0, 0, 12.346");
  });
});

const values = (...range: Parameters<typeof ticks>) => ticks(...range).map(({ value }) => value);

describe("MassProperties", () => {
  const tiles = [...box([0, 0, 0], [2, 3, 4], "a"), ...box([10, 10, 10], [11, 11, 11], "b")];

  test("MeasureTheRequestedPart", () => {
    expect(massProperties(tiles, identity, { id: "a/right", triangle: 5 })).toMatchObject({ triangles: 12, area: 52, volume: 24, isCapped: false });
    expect(massProperties(tiles, identity, { id: "b/left", triangle: 0 })).toMatchObject({ triangles: 12, area: 6, volume: 1, isCapped: false });
    expect(massProperties(tiles, identity, { id: "b/left", triangle: 6 })).toBeNull();
    expect(massProperties(tiles, identity, { id: "c", triangle: 0 })).toBeNull();
  });

  test("BoundVolumesByTheTubeFormula", () => {
    // All places within a distance of a box: its sides, quarters of cylinders, and a ball.
    const found = massProperties(tiles, identity, { id: "a/right", triangle: 5 })!;
    for (const d of [0.001, 0.1, 0.5]) {
      const added = 52 * d + Math.PI * (2 + 3 + 4) * d ** 2 + (4 / 3) * Math.PI * d ** 3;
      expect(volumeBound(found, d)).toBeGreaterThanOrEqual(added);
      expect(volumeBound(found, d)).toBeCloseTo(added + 4 * Math.PI * d ** 3, 9); // Eight half balls instead of one ball.
    }
  });

  test("UseWorldUnitsInMirroredWorlds", () => {
    const toWorld = [-0.5, 0, 0, 0, 2, 0, 0, 0, 1, 100, -7, 3];
    const found = massProperties(tiles, toWorld, { id: "a/left", triangle: 0 })!;
    expect(found.volume).toBeCloseTo(24, 12);
    expect(found.area).toBeCloseTo(2 * (1 * 6 + 6 * 4 + 1 * 4), 12);
  });

  test("OpenSurfacesHaveNoVolume", () => {
    expect(massProperties(tiles.slice(0, 1), identity, { id: "a/left", triangle: 0 })).toMatchObject({ volume: null, isCapped: false });
  });

  // The box without some of its sides: z low, z high, y low, y high, x low, x high.
  const without = (...sides: number[]) => {
    const [left, right] = box([5, 5, 5], [7, 8, 9], "a");
    const triangles = [...left.triangles, ...right.triangles].filter((_, i) => !sides.includes(Math.floor(i / 6)));
    return massProperties([{ id: "a", positions: left.positions, triangles: Uint16Array.from(triangles) }], identity, { id: "a", triangle: 0 })!;
  };

  test("CapSurfacesAtTheBorderOfTheData", () => {
    expect(without(5)).toMatchObject({ volume: 24, area: 52 - 12, isCapped: true }); // Without one side.
    expect(without(1, 5)).toMatchObject({ volume: 24, isCapped: true }); // Without two adjacent sides.
    expect(without(4, 5)).toMatchObject({ volume: 24, isCapped: true }); // Without two opposite sides.
    const corner = { id: "a", positions: Float32Array.from([9, 5, 5, 5, 8, 5, 5, 5, 7]), triangles: Uint16Array.of(0, 1, 2) };
    const found = massProperties([corner], identity, { id: "a", triangle: 0 })!;
    expect(found.isCapped).toBe(true); // Open at a corner.
    expect(found.volume).toBeCloseTo((4 * 3 * 2) / 6, 12);
  });
});

describe("CutLine", () => {
  const tiles = box([0, 0, 0], [2, 3, 4], "a");

  test("IsClosedForClosedSurfaces", () => {
    for (const constant of [-1, -0.5, -3.75]) {
      const line = cutLine(tiles, { normal: [0.3, 0.4, 1], constant });
      const ends = new Map<string, number>();
      for (let i = 0; i < line.length; i += 3) {
        const end = [...line.subarray(i, i + 3)].join();
        ends.set(end, (ends.get(end) ?? 0) + 1);
      }
      expect(ends.size).toBeGreaterThan(3);
      expect([...ends.values()].every((uses) => uses === 2)).toBe(true);
    }
  });

  test("HasTheLengthOfTheSection", () => {
    const line = cutLine(tiles, { normal: [0, 0, 1], constant: -1 });
    let length = 0;
    for (let i = 0; i < line.length; i += 6) {
      expect(line[i + 2]).toBe(1);
      length += Math.hypot(line[i + 3] - line[i], line[i + 4] - line[i + 1]);
    }
    expect(length).toBeCloseTo(10, 6);
  });

  test("IsEmptyOutsideOfTheSurface", () => {
    expect(cutLine(tiles, { normal: [0, 0, 1], constant: -5 })).toHaveLength(0);
    expect(cutLine(tiles, { normal: [0, 0, 1], constant: 1 })).toHaveLength(0);
  });
});

describe("Measures", () => {
  test("ThreePlacesHaveLengthsAndAnAngle", () => {
    expect(distanceOf([1, 2, 3], [1, 5, 7])).toBe(5);
    expect(angleAt([0, 0, 0], [2, 0, 0], [0, 3, 0])).toBeCloseTo(90, 12);
    expect(angleAt([1, 1, 1], [2, 1, 1], [-3, 1, 1])).toBeCloseTo(180, 12);
    expect(angleAt([1, 1, 1], [1, 1, 1], [2, 1, 1])).toBeNull();
  });

  test("ShowAllDigitsAtFullResolution", () => {
    expect(areaText(12.3456789, { lengthUnit: "mm" }, true)).toBe("12.346 mm²");
    expect(volumeText(123456, { lengthUnit: "mm" }, 0)).toBe("123460 mm³ = 123.46 ml");
    expect(volumeText(2, { lengthUnit: "" }, 0)).toBe("2 unit³");
    expect(lengthWithBound(1.5, { lengthUnit: "mm" }, 0)).toBe("1.5 mm");
  });

  test("RoundToTheirBound", () => {
    expect(lengthWithBound(12.3456, { lengthUnit: "mm" }, 0.046)).toBe("12.35 ± 0.06 mm");
    expect(lengthWithBound(12.3456, { lengthUnit: "mm" }, 0.0149)).toBe("12.346 ± 0.016 mm");
    expect(volumeText(123456, { lengthUnit: "mm" }, 250)).toBe("123460 ± 260 mm³ = 123.46 ± 0.26 ml");
    expect(areaText(12.3456789, { lengthUnit: "mm" }, false)).toBe("about 12 mm²");
    for (const [value, bound] of [
      [Math.PI, 0.3],
      [1e-7, 3e-9],
      [98765, 4321],
      [0.5, 7],
    ]) {
      const [shown, off] = withBound(value, bound).split(" ± ").map(Number);
      expect(Math.abs(shown - value) + bound).toBeLessThanOrEqual(off * (1 + 1e-9));
      expect(off).toBeLessThan(2.4 * bound);
    }
  });

  test("RoundWithoutABound", () => {
    expect(lengthWithBound(12.3456, { lengthUnit: "mm" }, null)).toBe("about 12 mm");
    expect(volumeText(123.456, { lengthUnit: "" }, null)).toBe("about 120 unit³");
  });
});

describe("Axes", () => {
  test("TicksAreRoundNumbers", () => {
    expect(values(0, 128, 4)).toEqual([0, 50, 100]);
    expect(values(-0.1, 0.3, 4)).toEqual([-0.1, 0, 0.1, 0.2, 0.3]);
    expect(values(1500, 1733, 5)).toEqual([1500, 1550, 1600, 1650, 1700]);
    expect(ticks(3, 3, 5)).toEqual([]);
    expect(ticks(0, Infinity, 5)).toEqual([]);
  });

  test("HaveAnatomicalNames", () => {
    const letters = (space: WorldSpace) =>
      axisNames({ space })
        .map(({ letter }) => letter)
        .join(" ");
    expect(letters(WorldSpace.LPS)).toBe("L R P A S I");
    expect(letters(WorldSpace.RAS)).toBe("R L A P S I");
    expect(letters(WorldSpace.UNSPECIFIED)).toBe("x −x y −y z −z");
    expect(axisNames({ space: WorldSpace.RAS })[3].direction).toEqual([0, -1, 0]);
  });
});

describe("MeasuredParts", () => {
  test("SuggestHowToNarrowTheBound", () => {
    expect(volumeHint(170, 40, false)).toMatch(/Exact/);
    expect([volumeHint(170, 1, false), volumeHint(170, 40, true)]).toEqual(["", ""]);
    expect(volumeHint(170, null, false)).toMatch(/Exact/);
    expect(volumeHint(null, 40, false)).toMatch(/--pad-value VALUE --pad 1/);
  });
});

describe("RoundedWithin", () => {
  test("DistinguishesEndsOfNarrowRanges", () => {
    expect([101111.6, 101300.4, 101547.4].map((value) => roundedWithin(value, 435.8))).toEqual([101112, 101300, 101547]);
    expect(roundedWithin(-20.123456, 0.05)).toBe(-20.1235);
  });

  test("KeepsFourDigitsOfWideRanges", () => {
    expect([-784.57, 3071, 0, 12345678].map((value) => roundedWithin(value, 1e9))).toEqual([-784.6, 3071, 0, 12350000]);
    expect(roundedWithin(1.23456, 0)).toBe(1.235);
  });
});
