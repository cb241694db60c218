import { savedFileText } from "../../../client/web/src/panel/downloads_section";
import { columns } from "../../../client/web/src/panel/histogram";
import { labelTable } from "../../../client/web/src/panel/label_table";
import { timeLeft } from "../../../client/web/src/panel/status_bar";
import type { DatasetInfo } from "../../../client/web/src/protocol/messages";
import { create, HistogramSchema, LabelSchema, WorldSpace } from "../../../client/web/src/protocol/messages";
import { type Annotations, annotate } from "../../../client/web/src/scene/annotations";
import { nearestName } from "../../../client/web/src/shared/nearest_name";
import { defaultSurface, defaults } from "../../../client/web/src/state/settings";
import { worldDifference } from "../../../client/web/src/stream/dataset";
import { captionOf, surfaceKeys } from "../../../client/web/src/viewer/picture";
import { plain } from "./made_datasets";
import { settingsFrom, surface } from "./made_settings";

describe("NearestName", () => {
  test("FindsMisspelledNames", () => {
    const names = ["head", "gyroid", "visible-female-head"];
    expect(nearestName("haed", names)).toBe("head");
    expect(nearestName("Gyriod", names)).toBe("gyroid");
    expect(nearestName("visible_female_head", names)).toBe("visible-female-head");
    expect(nearestName("corner_of_the_moon", names)).toBeNull();
    expect(nearestName("head", [])).toBeNull();
  });
});

describe("WorldDifference", () => {
  const at = (name: string, x: number, overrides = {}) => ({ ...plain(name), indexToWorld: [1, 0, 0, 0, 1, 0, 0, 0, 1, x, 0, 0], ...overrides });

  test("ExplainsDifferentWorlds", () => {
    expect(worldDifference(at("a", 0), at("b", 4))).toBeNull();
    expect(worldDifference(at("a", 0), at("b", 8))).toBeNull(); // They touch.
    expect(worldDifference(at("a", 0), at("b", 9))).toMatch(/at another position than "a"/);
    expect(worldDifference(at("a", 0, { lengthUnit: "mm" }), at("b", 0, { lengthUnit: "um" }))).toMatch(/unit of length is um, that of "a" is mm/);
    expect(worldDifference(at("a", 0, { space: WorldSpace.LPS }), at("b", 0, { space: WorldSpace.RAS }))).toMatch(/axes are RAS, those of "a" are LPS/);
    expect(worldDifference(at("a", 0, { space: WorldSpace.LPS, lengthUnit: "mm" }), at("b", 0))).toBeNull();
  });
});

describe("TimeLeft", () => {
  test("ExtrapolatesAfterOneSecond", () => {
    expect(timeLeft(900, 5, 10)).toBe("");
    expect(timeLeft(5000, 0, 10)).toBe("");
    expect(timeLeft(5000, 10, 10)).toBe("");
    expect(timeLeft(4000, 4, 10)).toBe("about 6 s left");
    expect(timeLeft(60000, 1, 6)).toBe("about 5 min left");
  });
});

describe("Histogram", () => {
  const info = { histogram: create(HistogramSchema, { low: 0, high: 4, counts: [1n, 2n, 3n, 4n] }) };

  test("CoversTheRangeOfAllTimes", () => {
    const own = columns(info, { min: 0, max: 4 }, 4, true);
    expect(own.every((height) => height > 0)).toBe(true);
    expect(columns(info, { min: -2, max: 6 }, 8, true)).toEqual([0, 0, ...own, 0, 0]);
  });
});

describe("LabelTable", () => {
  test("ListsVolumesWithBounds", () => {
    const label = (value: number, name: string, samples = 0n) => create(LabelSchema, { value, name, samples });
    const found = { triangles: 12, area: 600.123, volume: 1000.4, isCapped: false, bend: 100, vertices: 8 };
    const rows = labelTable(
      [
        { label: label(1, "liver", 1024n), samplesVolume: 1024.5, found, bound: 0.01, centroid: [1, -2.5, 3] },
        { label: label(2, 'a "b", c'), samplesVolume: 0, found: { ...found, volume: null }, bound: 0.01, centroid: null },
        { label: label(3, ""), samplesVolume: 0, found: null, bound: null, centroid: null },
      ],
      "\u00b5m",
    ).split("\r\n");
    expect(rows).toEqual([
      "label,name,samples,samples_volume_um3,volume_um3,volume_bound_um3,area_about_um2,centroid_x_um,centroid_y_um,centroid_z_um,triangles",
      "1,liver,1024,1024.5,1000.4,6.01,600.123,1,-2.5,3,12",
      '2,"a ""b"", c",,,,,600.123,,,,12',
      "3,,,,,,,,,,",
      "",
    ]);
  });
});

describe("ExportedPictures", () => {
  test("HaveACaption", () => {
    const info = {
      name: "jet.p.t1",
      valueUnit: "K",
      suggestedIsovalues: [4],
      member: { series: "jet", field: "temperature", time: 0.25, timeUnit: "s" },
    } as unknown as DatasetInfo;
    expect(captionOf(settingsFrom({ isovalue: 300.5 }), info, [])).toBe("jet, temperature, isovalue 300.5 K, 0.25 s");
    const surfaces = [surface({ dataset: "jet.q", isovalue: 2, color: "#ffffff" })];
    expect(captionOf(settingsFrom({ isovalue: 300.5, surfaces }), info, [])).toBe("jet, temperature, isovalue 300.5 K, jet.q 2, 0.25 s");
    const list = [{ name: "organs.label3", member: { series: "organs", label: { value: 3, name: "liver" } } }] as unknown as DatasetInfo[];
    const labels = [3, 3].map(() => ({ ...surfaces[0], dataset: "organs.label3", color: "#00ff00" }));
    expect(captionOf(settingsFrom({ isovalue: 300.5, surfaces: labels }), info, list)).toBe("jet, temperature, isovalue 300.5 K, labels of organs, 0.25 s");
    expect(surfaceKeys(settingsFrom({ surfaces: [surfaces[0], labels[0]] }), info, list)).toEqual([
      { color: defaultSurface.color, text: "4 K" },
      { color: "#ffffff", text: "jet.q 2 K" },
      { color: "#00ff00", text: "liver" },
    ]);
    expect(surfaceKeys(settingsFrom({ surfaces: Array(20).fill(labels[0]) }), info, list).at(-1)).toEqual({ color: "", text: "and 9 more" });
    expect(surfaceKeys(defaults, info, list)).toEqual([]);
    expect(captionOf(settingsFrom({ visible: false }), info, [])).toBe("jet, temperature, 0.25 s");
    expect(captionOf(settingsFrom({ isovalue: 7 }), { ...info, name: "head", valueUnit: "", member: undefined }, [])).toBe("head, isovalue 7");
  });

  const nothing: Annotations = { scale: null, numbers: [], axes: [], legends: [], points: [], words: [], surfaces: [] };
  const legend = { map: "gray" as const, name: "samples of head", low: "-160", high: "240 HU" };

  // Returns the texts with their positions, and the path's corners.
  function drawn(annotations: Annotations, [width, height] = [800, 600], ratio = 1) {
    const written: [string, number, number][] = [];
    const corners: [number, number][] = [];
    const recorders: Record<string, unknown> = {
      canvas: { width, height },
      fillText: (...words: [string, number, number]) => written.push(words),
      moveTo: (...corner: [number, number]) => corners.push(corner),
      lineTo: (...corner: [number, number]) => corners.push(corner),
      createLinearGradient: () => ({ addColorStop: () => {} }),
    };
    const context = new Proxy(recorders, { get: (target, name) => target[name as string] ?? (() => {}) });
    annotate(context as unknown as CanvasRenderingContext2D, annotations, ratio, "#fff", "#000");
    return { written, corners };
  }

  test("ContainMeasurementsScaleAndLegends", () => {
    const points = [
      { x: 100, y: 50, note: "" },
      { x: 300, y: 90, note: "a saddle" },
    ];
    const words = ["head, isovalue 500.5 HU", "A to B: 44.72 mm"];
    const { written, corners } = drawn({ ...nothing, points, words, scale: { pixels: 120, text: "50 mm" }, legends: [legend] });
    const texts = written.map(([text]) => text).sort();
    expect(texts).toEqual([...words, "50 mm", "A", "B", "a saddle", "-160", "240 HU", "samples of head"].sort());
    expect(written.find(([text]) => text === "a saddle")).toEqual(["a saddle", 313, 94.5]); // Beside B.
    expect(corners).toEqual(
      expect.arrayContaining([
        [100, 50],
        [300, 90],
        [664, 580],
        [784, 580],
      ]),
    ); // The length's line, the scale bar.
  });

  test("LegendsAndScaleBarDoNotOverlap", () => {
    const heightOf = (width: number, legends: number) =>
      drawn({ ...nothing, scale: { pixels: 120, text: "50 mm" }, legends: Array(legends).fill(legend) }, [width, 600]).written.find(
        ([text]) => text === "50 mm",
      )![2];
    expect([heightOf(400, 2), heightOf(360, 0)]).toEqual([573, 573]); // At the lower right corner,
    expect([heightOf(360, 1), heightOf(360, 2)]).toEqual([521, 469]); // or above the legends.
  });

  test("DrawFrontAxesLast", () => {
    const axes = [
      { letter: "R", axis: 0, x: -1, y: 0, isBehind: true },
      { letter: "S", axis: 2, x: 0, y: -1, isBehind: false },
    ];
    const { written } = drawn({ ...nothing, numbers: [{ text: "20", x: 100, y: 50 }], axes }, [800, 600], 2);
    expect(written.map(([letter]) => letter)).toEqual(["20", "R", "S"]);
    const [number, [, rightX, rightY], [, upX, upY]] = written;
    expect(number.slice(1)).toEqual([100, 54.5]); // The center stays where it is on the screen.
    expect(rightX).toBeLessThan(upX);
    expect(upY).toBeLessThan(rightY);
    expect([rightX > 0, rightY < 300]).toEqual([true, true]); // At the lower left, in screen units.
  });
});

describe("SavedFileText", () => {
  const expected = { triangles: 59_000, budget: 0, bytes: 0, errorVoxels: 0.5 };
  const words = (change: Partial<Parameters<typeof savedFileText>[0]>) =>
    savedFileText({ triangles: 548_123, isOfSamples: false, isOneOfSeveral: false, expected, ...change }).replaceAll("\u202f", " ");

  test("CountsTriangles", () => {
    expect(words({})).toBe("Saved 548 123 triangles.");
    expect(words({ isOneOfSeveral: true })).toBe("Saved 548 123 triangles, those of the first surface.");
  });

  test("SuggestsTheSimplifiedSurface", () => {
    expect(words({ isOfSamples: true })).toMatch(/from samples and not simplified; "multitetra-client fetch" writes 44 000 to 89 000 triangles/);
    expect(words({ isOfSamples: true, expected: null })).toMatch(/from samples and not simplified\.$/);
    expect(words({ isOfSamples: true, triangles: 900 })).toMatch(/not simplified\.$/);
  });
});
