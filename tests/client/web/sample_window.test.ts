import { nextIsovalue } from "../../../client/web/src/panel/surfaces_section";
import { airBelow, defaultWindow, isCt, sampleWindows, tissueAtValue, type WindowedDataset } from "../../../client/web/src/shared/sample_window";
import type { SurfaceSettings, WrittenSettings } from "../../../client/web/src/state/settings";
import { withAddedSurface } from "../../../client/web/src/state/surfaces";
import { settingsFrom } from "./made_settings";

// A histogram with these counts in bins of width 1, from 0 on.
function dataset(counts: number[], overrides: Partial<WindowedDataset> = {}): WindowedDataset {
  const histogram = { low: 0, high: counts.length, counts: counts.map(BigInt) } as WindowedDataset["histogram"];
  return { min: 0, max: counts.length, valueUnit: "", histogram, ...overrides };
}

// A dark background, and few values far above all others.
const scan = dataset([900, 60, 8, ...Array<number>(40).fill(100), ...Array<number>(200).fill(0), 1]);
const ct = dataset([1], { min: -1024, max: 3071, valueUnit: "HU" });

describe("DefaultWindow", () => {
  test("OmitsBackgroundAndOutliers", () => {
    const { level, width } = defaultWindow(scan);
    expect(level - width / 2).toBeGreaterThan(2.9);
    expect(level + width / 2).toBeLessThan(43.1);
    expect(width).toBeGreaterThan(38);
  });

  test("IsSoftTissueForCt", () => {
    expect(defaultWindow(ct)).toMatchObject({ level: 40, width: 400 });
    expect(sampleWindows(ct).map(({ name }) => name)).toEqual(["Soft tissue", "Bone", "Lung", "Brain", "All values"]);
  });

  test("IsThatOfTheSource", () => {
    const displayWindow = { low: 100, high: 700 } as WindowedDataset["displayWindow"];
    expect(defaultWindow({ ...scan, displayWindow })).toEqual({ level: 400, width: 600 });
    expect(sampleWindows({ ...scan, displayWindow }).map(({ name }) => name)).toEqual(["From the file", "Most values", "All values"]);
    expect(defaultWindow({ ...ct, displayWindow })).toEqual({ level: 400, width: 600 });
  });

  test("IsAllValuesWithoutAHistogram", () => {
    expect(defaultWindow({ min: -1, max: 3, valueUnit: "", histogram: undefined })).toEqual({ level: 1, width: 4 });
    expect(defaultWindow(dataset([], { min: 5, max: 5 }))).toEqual({ level: 5, width: 0 });
  });

  test("IsAllValuesWithoutBackground", () => {
    const { level, width } = defaultWindow(dataset(Array<number>(100).fill(10)));
    expect([level, width].map(Math.round)).toEqual([50, 99]);
    expect(airBelow(dataset(Array<number>(100).fill(10)), 0)).toBe(-Infinity);
  });
});

describe("Air", () => {
  test("IsBackgroundOrBelowFatForCt", () => {
    expect(airBelow(scan, 0)).toBe(3);
    expect(airBelow(ct, -160)).toBe(-500);
  });

  test("IsShownWhereItIsNearlyAll", () => {
    const fluorescence = dataset([97000, 600, 80, ...Array<number>(40).fill(50)]);
    expect(airBelow(fluorescence, 0)).toBe(-Infinity);
  });
});

describe("AirInALungWindow", () => {
  test("BeginsAtTheWindow", () => {
    const { level, width } = sampleWindows(ct).find(({ name }) => name === "Lung")!;
    expect(airBelow(ct, level - width / 2)).toBe(-1350);
    expect(airBelow(scan, -1350)).toBe(3);
  });
});

describe("ComputedTomography", () => {
  test("RecognizesCtByUnitOrValues", () => {
    expect(isCt({ ...ct, valueUnit: "" })).toBe(true);
    expect(isCt({ ...ct, valueUnit: "K" })).toBe(false);
    expect(isCt({ min: 0, max: 4095, valueUnit: "", histogram: undefined })).toBe(false);
  });

  test("NamesTheTissueAtAnIsovalue", () => {
    expect([-300.5, 0.5, 400.5, 2500].map((value) => tissueAtValue(value, ct))).toEqual(["skin", "soft tissue", "bone", "enamel, metal"]);
    expect([-784, -500.5].map((value) => tissueAtValue(value, ct))).toEqual(["", ""]);
    expect(tissueAtValue(400.5, scan)).toBe("");
  });
});

describe("AnotherSurface", () => {
  test("HasTheFarthestSuggestedIsovalue", () => {
    const info = { ...dataset([]), suggestedIsovalues: [100, 120, 400, 90], max: 500 };
    expect(nextIsovalue([100], info)).toBe(400);
    expect(nextIsovalue([100, 400], info)).toBe(120);
    expect(nextIsovalue([90, 100, 120, 400], info)).toBe(450);
  });

  test("IsSkinOrBoneRatherThanAir", () => {
    const info = { ...dataset([]), min: -1024, max: 3071, suggestedIsovalues: [300.5, -784.5, -250.5, 20.5, 2500.5] };
    expect(nextIsovalue([300.5], info)).toBe(-250.5);
    expect(nextIsovalue([-250.5], info)).toBe(300.5);
    expect(nextIsovalue([300.5, -250.5], info)).toBe(2500.5);
    const bones = { ...info, suggestedIsovalues: [-250.5, 300.5, 1042.5] };
    expect(nextIsovalue([-250.5], bones)).toBe(300.5); // Its first suggestion.
    expect(nextIsovalue([300.5, -250.5, 2500.5, 20.5], info)).toBe(-784.5);
  });

  test("MakesTheOuterOneTranslucent", () => {
    const opacities = (first: Partial<SurfaceSettings>, isovalue: number, suggested: number) =>
      withAddedSurface(settingsFrom(first as Partial<WrittenSettings>), isovalue, suggested).surfaces!.map(({ opacity }) => opacity);
    expect(opacities({}, 400, 100)).toEqual([0.35, 1]);
    expect(opacities({ isovalue: 100 }, 50, 7)).toEqual([1, 0.35]);
    expect(opacities({ opacity: 0.8 }, 400, 100)).toEqual([0.8, 1]);
  });
});
