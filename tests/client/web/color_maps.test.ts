import { readFileSync } from "node:fs";
import { scaleOf } from "../../../client/web/src/samples/slices";
import { type ColorMap, colorAt, colorMaps, endsOf, fractionOf } from "../../../client/web/src/shared/color_maps";

// tests/golden/colors.txt, also used by the C++ tests: map, lin or log, low, high, value, color.
const golden = readFileSync(new URL("../../golden/colors.txt", import.meta.url), "utf8")
  .split("\n")
  .filter((line) => line && !line.startsWith("#"))
  .map((line) => line.split(" "));

describe("ColorScale", () => {
  test("MatchesTheColorsOfPictures", () => {
    expect(golden.length).toBeGreaterThan(400);
    for (const [name, kind, low, high, value, color] of golden) {
      const scale = { low: Number(low), high: Number(high), isLog: kind === "log" };
      const map = name as ColorMap;
      const rgb = colorAt(map, fractionOf(Number(value), scale));
      expect(rgb.map((v) => v.toString(16).padStart(2, "0")).join(""), `${name} ${kind} ${value}`).toBe(color);
    }
    expect(new Set(golden.map(([name]) => name)).size).toBe(colorMaps.length);
  });

  test("ShaderEndsDifferInSinglePrecision", () => {
    expect(endsOf({ low: 2, high: 2, isLog: false })[1]).toBeGreaterThan(2);
    expect(endsOf({ low: 1, high: Math.E, isLog: true })).toEqual([0, 1]);
  });

  test("LogarithmicScalesRequirePositiveValues", () => {
    const range = { min: 0, max: 1000 };
    expect(scaleOf(null, null, true, range)).toEqual({ low: 1, high: 1000, isLog: true });
    expect(scaleOf(null, null, true, { min: 5, max: 50 })).toEqual({ low: 5, high: 50, isLog: true });
    expect(scaleOf(-100, 50, true, range)).toEqual({ low: -125, high: -75, isLog: false });
    expect(scaleOf(30, 40, true, range)).toEqual({ low: 10, high: 50, isLog: true });
  });
});
