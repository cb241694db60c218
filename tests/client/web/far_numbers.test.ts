// Texts over data far from the origin, or with values and times far from zero, tell apart what the data tells apart.

import { positionText } from "../../../client/web/src/panel/cut_section";
import { emptySurfaceText } from "../../../client/web/src/panel/empty_surface";
import { labelTable } from "../../../client/web/src/panel/label_table";
import { nextIsovalue } from "../../../client/web/src/panel/surfaces_section";
import type { DatasetInfo } from "../../../client/web/src/protocol/messages";
import { distanceOf, lengthBetween } from "../../../client/web/src/scene/measures";
import { ticks } from "../../../client/web/src/scene/ticks";
import { inResolution, rounded } from "../../../client/web/src/shared/numbers";
import { roundedWithin } from "../../../client/web/src/shared/quantities";
import { defaultWindow } from "../../../client/web/src/shared/sample_window";
import { noProgress, type StepFacts } from "../../../client/web/src/state/progress";
import { timeText } from "../../../client/web/src/state/series";
import { defaults, type Place, type Settings } from "../../../client/web/src/state/settings";
import { fromAddress, toAddress } from "../../../client/web/src/state/url_state";
import { coordinateResolution, coordinateText, placeText, reservationsOf, valueText } from "../../../client/web/src/stream/dataset";
import type { ShownSurface } from "../../../client/web/src/surfaces/shown_surface";
import { captionOf } from "../../../client/web/src/viewer/picture";
import { withoutPart } from "../../../client/web/src/viewer/surface_parts";
import { member, plain } from "./made_datasets";
import { settingsFrom, surface } from "./made_settings";

const far = 5.4e6;
const info: DatasetInfo = {
  ...plain("hill"),
  dims: [41, 41, 41],
  spacing: [0.5, 0.5, 0.5],
  lengthUnit: "m",
  min: far,
  max: far + 20,
  indexToWorld: [0.5, 0, 0, 0, 0.5, 0, 0, 0, 0.5, 500000, far, 0],
};
const resolution = coordinateResolution(info);

// Places a voxel apart, with more digits than the data has.
const [a, b] = [0, 0.5].map((step): Place => [500001.23456789 + step, far + 2.3456789, 1.2345678]);

describe("FarNumbers", () => {
  test("AreRoundedToTheirResolution", () => {
    expect(inResolution(far + 0.123456, 0.005)).toBe("5400000.123");
    expect(inResolution(far + 0.123456, 20)).toBe("5400000");
    expect([rounded(0.1 + 0.2, 1e-3), rounded(-1e-9, 1e-3), rounded(123456, 100), rounded(1.25, 0)]).toEqual([0.3, 0, 123500, 1.25]);
    expect(roundedWithin(far + 7.123, 20)).toBe(far + 7.1);
  });

  test("TellNeighboringVoxelsApart", () => {
    expect(placeText(a, info)).toBe("500001.235, 5400002.346, 1.235");
    expect(coordinateText(a[0], info)).toBe("500001.235 m");
    expect([0.1, 0.125].map((share) => positionText(info, "y", share))).toEqual(["5400002 m", "5400002.5 m"]);
    expect(ticks(far, far + 2, 4).map(({ text }) => text)).toEqual(["5400000", "5400000.5", "5400001", "5400001.5", "5400002"]);
  });

  test("TellNeighboringValuesApart", () => {
    expect([0, 0.01].map((step) => valueText(far + step, info))).toEqual(["5400000", "5400000.01"]);
    const shown = { info, facts: { isovalue: far + 20.25 } } as ShownSurface;
    const progress = { ...noProgress, shown: { isFinal: true, triangles: 0 } as StepFacts };
    expect(emptySurfaceText(shown, progress)).toBe('There is no surface at isovalue 5400020.25: the values of "hill" range from 5400000 to 5400020.');
    expect(captionOf(settingsFrom({ isovalue: far + 0.25 }), info, [])).toBe("hill, isovalue 5400000.25");
    expect(nextIsovalue([far + 1], info)).toBe(far + 10.5);
    const counts = [0n, 0n, 9n, 90n, 90n, 9n, 0n, 0n, 0n];
    const { level, width } = defaultWindow({ ...info, histogram: { counts, low: far, high: far + 20 } as DatasetInfo["histogram"] });
    expect(Math.abs(level - far - 8.9)).toBeLessThan(1);
    expect(width).toBeGreaterThan(1);
  });

  test("TellTimesApart", () => {
    const times = [1700000000, 1700000060, 1700000120];
    expect(times.map((time) => timeText(time, "s", times))).toEqual(["1700000000 s", "1700000060 s", "1700000120 s"]);
    const years = [2026, 2026.0001];
    expect(years.map((time) => timeText(time, "a", years))).toEqual(["2026 a", "2026.0001 a"]);
    const list = times.map((time, i) => member(`e${i}`, "e", { field: "ball", time, timeUnit: "s" }));
    expect(captionOf(defaults, list[1], list)).toMatch(/, 1700000060 s$/);
  });

  test("InAddressesGiveTheSameMeasurement", () => {
    const settings = settingsFrom({
      eye: a,
      target: b,
      cross: a,
      hiddenParts: [a, b],
      crop: { low: a, high: [b[0], b[1], b[2] + 1] },
      region: { kind: "ball", center: a, radius: 1.23456789, error: 0.5 },
      surfaces: [surface({ isovalue: far + 0.123456, hiddenParts: [a] })],
      places: [
        { world: a, bound: 0.1 },
        { world: b, bound: 0.1 },
      ],
    });
    const text = toAddress(settings, resolution);
    expect(text).not.toMatch(/\d{12}/); // Without digits of rounding errors.
    const read = settingsFrom(fromAddress(text));
    const [first, second] = read.surfaces;
    const near = (found: readonly number[], place: readonly number[]) =>
      place.forEach((value, axis) => expect(Math.abs(found[axis] - value)).toBeLessThan(resolution));
    for (const [found, place] of [
      [read.eye!, a],
      [read.target!, b],
      [read.cross!, a],
      [first.hiddenParts[1], b],
      [read.crop!.low, a],
      [second.hiddenParts[0], a],
      [(read.region as { center: Place }).center, a],
    ])
      near(found, place);
    expect(second.isovalue).toBe(far + 0.123456);
    const [from, to] = read.places;
    expect(Math.abs(distanceOf(from.world, to.world) - 0.5)).toBeLessThan(2 * resolution);
    expect(lengthBetween(from, to, info)).toBe(lengthBetween(settings.places[0], settings.places[1], info));
    expect(toAddress(read, resolution)).toBe(text);
    expect(fromAddress(toAddress(settings)).eye).toEqual(a); // Exact where no resolution is known.
  });

  test("SayWhatIsAssumedOrRounded", () => {
    const dubious = { ...info, assumed: "spacing along z", rounding: "up to 0.06, 0.5 % of their range" } as DatasetInfo;
    const [placement, samples] = reservationsOf(dubious);
    expect(placement).toContain("does not state spacing along z");
    expect(samples).toContain("rounded to 32-bit floats (up to 0.06, 0.5 % of their range)");
    expect(reservationsOf({ ...info, assumed: "", rounding: "" } as DatasetInfo)).toEqual([]);
  });

  test("OfHiddenPartsAndLabelsAreOfTheGrid", () => {
    const parts = withoutPart(defaults, 0, a, resolution) as { change: Partial<Settings> };
    expect(parts.change.surfaces![0].hiddenParts).toEqual([[500001.2346, far + 2.3457, 1.2346]]);
    const label = member("l", "s", { label: { value: 1, name: "l" } }).member!.label!;
    expect(labelTable([{ label, samplesVolume: 0, found: null, bound: null, centroid: [500001.2346, far + 2.3457, 1.2346] }], "m")).toMatch(
      /500001\.2346,5400002\.3457,1\.2346/,
    );
  });
});
