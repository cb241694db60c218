import { readFileSync } from "node:fs";
import { defaults, type WrittenSettings, writtenDefaults } from "../../../client/web/src/state/settings";
import { addressOf, afterEdit, fromAddress, ignoredParts, toAddress } from "../../../client/web/src/state/url_state";
import { settingsFrom, surface } from "./made_settings";

describe("Address", () => {
  test("OmitsDefaults", () => {
    expect(toAddress(defaults)).toBe("");
    expect(fromAddress("")).toEqual({});
  });

  test("EmbeddingGuideListsEverySetting", () => {
    const page = readFileSync(new URL("../../../client/web/EMBEDDING.md", import.meta.url), "utf8");
    const missing = Object.keys(writtenDefaults).filter((name) => !new RegExp(`\`${name}\`|\\b${name}: `).test(page));
    expect(missing).toEqual([]);
  });

  test("RestoresEverySetting", () => {
    const settings: WrittenSettings = {
      volume: "maximum",
      opacities: [
        { value: -150.5, opacity: 0 },
        { value: 300, opacity: 0.25 },
      ],
      volumeShading: false,
      volumeLabels: "only",
      dataset: "a head & more",
      t: 0.25,
      isovalue: -300.5,
      error: 0.5,
      bound: "paper",
      topologyRule: "paper",
      topologyTolerance: 2,
      region: { kind: "box", low: [1, 2, 3], high: [4, 5, 6.5], error: 0 },
      followView: false,
      pixels: 2,
      maxTriangles: 100000,
      drawableTriangles: 40_000_000,
      simplify: false,
      shading: "facets",
      wireframe: true,
      coloring: "steps",
      clip: "oblique",
      clipAt: 0.25,
      clipNormal: [0.6, 0, -0.8],
      clipFlipped: true,
      crop: { low: [-1, 2, 3], high: [4, 5, 6.5] },
      filled: false,
      slice: "z",
      samplesOf: "ct, & more",
      sliceAt: 0.75,
      layout: "four",
      cross: [1, -2.5, 3],
      sliceColors: "viridis",
      level: 40,
      colorBy: "a dose",
      colors: "coolwarm",
      fieldLevel: -1,
      fieldWindow: 2.5,
      fieldLog: true,
      noValueColor: "#102030",
      samplesLog: true,
      windowWidth: 400,
      axes: false,
      logScale: false,
      theme: "light",
      gestures: "all",
      playing: true,
      speed: 24,
      loop: false,
      surfaces: [
        surface({ isovalue: 400.5, color: "#f0e6d2" }),
        {
          dataset: "a, b; 100 %",
          isovalue: -1e-7,
          error: 0.5,
          color: "#00ff7f",
          opacity: 0.25,
          visible: false,
          minComponent: 30,
          material: "matcap",
          hiddenParts: [
            [1, 2, -3],
            [0.5, 0, 0],
          ],
        },
        surface({ isovalue: 1, color: "#00ff7f", minComponent: "largest" }),
      ],
      labels: "1-9,-4",
      labelNames: [{ label: 3, name: "liver; left" }],
      color: "#123456",
      material: "skin",
      opacity: 0.5,
      visible: false,
      minComponent: 12.5,
      hiddenParts: [
        [1, -2, 3],
        [4, 5, 6],
      ],
      projection: "orthographic",
      occlusion: false,
      eye: [1, -2, 3.25],
      target: [0, 0, 1],
      transparentAir: false,
      up: [0, -0.6, 0.8],
      places: [
        { world: [1, -2.5, 3], bound: 0.25 },
        { world: [0, 0, 1e-3], bound: null, note: "the tip; 50 %, or so" },
      ],
    };
    expect(fromAddress(`#${addressOf(settings)}`)).toEqual(settings);
    expect(toAddress(settingsFrom({ minComponent: "largest" }))).toBe("min_component=largest");
    expect(fromAddress("min_component=largest")).toEqual({ minComponent: "largest" });
    const ball = { kind: "ball", center: [1, 2, 3], radius: 4, error: 0.5 } as const;
    const overrides = toAddress({ ...defaults, region: { ...ball, center: [1, 2, 3] } });
    expect(overrides).toBe("region=ball:1,2,3,4=0.5");
    expect(fromAddress(overrides).region).toEqual(ball);
    const surfaces = [surface({ isovalue: 3, color: "#d9775f", opacity: 0.5 })];
    expect(toAddress(settingsFrom({ surfaces }))).toBe("surfaces=3,d9775f,0.5");
  });

  test("ParsesUpAsAnAxis", () => {
    expect(fromAddress("#up=-y").up).toEqual([0, -1, 0]);
    expect(fromAddress("#up=x").up).toEqual([1, 0, 0]);
    expect(fromAddress("#up=0,3,4").up).toEqual([0, 0.6, 0.8]);
  });

  test("IgnoresInvalidValues", () => {
    for (const text of [
      "#error=-1",
      "#error=NaN",
      "#isovalue=",
      "#isovalue=much",
      "#bound=guess",
      "#region=box:1,2=3",
      "#region=ball:1,2,3,-4=1",
      "#region=box:5,0,0,1,1,1=1",
      "#eye=1,2",
      "#clip=w",
      "#crop=5,0,0,1,1,1",
      "#crop=1,2,3",
      "#%%%",
      "#=&&=",
      "#wireframe=perhaps",
      "#max_triangles=1e99",
      "#theme=__proto__",
      "#color=red",
      "#opacity=1.5",
      "#surfaces=much",
      "#surfaces=1,ff0000,2",
      "#surfaces=1,ff0000,1,-1",
      "#surfaces=1,ff0000,1,,seen",
      "#surfaces=1,ff0000;2",
      `#surfaces=${Array(1024).fill("1,ff0000").join(";")}`,
      "#surfaces=1,ff0000,1,,,%25E0",
      "#surfaces=1,ff0000,1,,,,-1",
      "#surfaces=1,ff0000,1,,,,,gold",
      "#surfaces=1,ff0000,1,,,,most",
      "#largest_only=true",
      "#material=gold",
      "#surfaces=1,ff0000,1,,,,many",
      "#min_component=-1",
      "#min_component=2e6",
      "#min_component=dust",
      "#t=soon",
      "#speed=0",
      "#loop=2",
      "#no_value_color=grey",
      "#layout=five",
      "#cross=1,2",
      "#cross=1,2,x",
      "#up=w",
      "#up=0,0,0",
      "#up=1,2",
      "#places=1,2",
      "#places=1,2,3,-1",
      "#places=1,2,3,4,5,6",
      "#places=1,2,3;4,5,6;7,8,9;1,1,1",
    ]) {
      expect(fromAddress(text)).toEqual({});
    }
  });

  test("AcceptsOnlySnakeCaseNames", () => {
    const overrides = { ...defaults, maxTriangles: 5, topologyRule: "paper", topologyTolerance: 2, colorBy: "dose" } as const;
    expect(toAddress(overrides)).toBe("topology_rule=paper&topology_tolerance=2&max_triangles=5&color_by=dose");
    expect(fromAddress("#maxTriangles=5")).toEqual({});
    expect(ignoredParts("#maxTriangles=5")).toEqual(["maxTriangles=5"]);
  });

  test("ParsesQualitiesAsErrors", () => {
    expect(fromAddress("#quality=draft")).toEqual({ error: 2 });
    expect(fromAddress("#quality=exact&simplify=off")).toEqual({ error: 0, simplify: false });
    expect(ignoredParts("#quality=best")).toEqual(["quality=best"]);
  });

  test("ReportsIgnoredSettings", () => {
    expect(ignoredParts("#dataset=head&error=0.5&eye=1,2,3&region=ball:1,2,3,4=1&simplify=true")).toEqual([]);
    expect(ignoredParts("#error=-1&isovalue=2&clip=w&isovlaue=3&__proto__=4&toString=5")).toEqual([
      "error=-1",
      "clip=w",
      "isovlaue=3",
      "__proto__=4",
      "toString=5",
    ]);
    expect(ignoredParts("#token=mt_secret")).toEqual([]);
    expect(ignoredParts("#")).toEqual([]);
  });

  test("AppliesEditsAndKeepsUnreadableSettings", () => {
    const now = { ...writtenDefaults, dataset: "head", isovalue: 500.5, error: 2, clip: "x" as const };
    const overrides = "#dataset=head&isovalue=much&error=0.25&constructor=1";
    expect(afterEdit(now, overrides)).toEqual({ ...writtenDefaults, dataset: "head", isovalue: 500.5, error: 0.25 });
  });
});
