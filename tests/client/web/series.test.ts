import type { DatasetInfo } from "../../../client/web/src/protocol/messages";
import { labelColor } from "../../../client/web/src/state/label_colors";
import { changeFromWritten, initialSelection, labelIsovalue, settingsOfEntry, withLabelChanges } from "../../../client/web/src/state/label_surfaces";
import {
  atTime,
  channelColor,
  entriesOf,
  findByName,
  isSameData,
  memberOfField,
  rangeOf,
  seriesOf,
  timeOf,
  timesOf,
  timeText,
  withLabelsBeside,
  withTimeOfDataset,
} from "../../../client/web/src/state/series";
import { defaults, type Settings } from "../../../client/web/src/state/settings";
import { sampledOf, sceneOf, sceneRefusal } from "../../../client/web/src/surfaces/scene_at";
import { member, plain } from "./made_datasets";
import { settingsFrom, surface } from "./made_settings";

const flow = [0.5, 0, 0.25].flatMap((time) => ["speed", "heat"].map((field) => member(`flow.${field}.t${time}`, "flow", { field, time, timeUnit: "s" })));
const labels = [9, 1, 4].map((value) => member(`seg.label${value}`, "seg", { label: { value, name: "" } }));
const list = [plain("head"), ...flow, plain("fuel"), ...labels];
const names = (all: readonly DatasetInfo[]) => all.map(({ name }) => name);

describe("Series", () => {
  test("HaveOneEntry", () => {
    expect(entriesOf(list).map(({ name, info }) => [name, info.name])).toEqual([
      ["head", "head"],
      ["flow", "flow.speed.t0"],
      ["fuel", "fuel"],
      ["seg", "seg.label1"],
    ]);
    expect(seriesOf(list, flow[0])).toMatchObject({ times: [0, 0.25, 0.5], timeUnit: "s", fields: ["speed", "heat"], labels: [] });
    expect(names(seriesOf(list, labels[0])!.labels)).toEqual(["seg.label1", "seg.label4", "seg.label9"]);
  });

  test("StayTheSameWhenTheirErrorsAreComputed", () => {
    const before = { ...plain("head"), contentId: 1n, missing: "errors" };
    const now = { ...plain("head"), contentId: 2n };
    expect(isSameData(before, now)).toBe(true);
    expect(isSameData(before, { ...now, max: now.max + 1 })).toBe(false);
    expect(isSameData(now, before)).toBe(false);
    expect(isSameData({ ...before, missing: "" }, now)).toBe(false);
  });

  test("HaveAllLabelsInATable", () => {
    expect(names(withLabelsBeside(list, [labels[2]]))).toEqual(["seg.label1", "seg.label4", "seg.label9"]);
    const moving = [0, 1].flatMap((time) => [1, 2].map((value) => member(`m.label${value}.t${time}`, "m", { label: { value, name: "" }, time })));
    expect(names(withLabelsBeside(moving, [moving[3]]))).toEqual(["m.label1.t1", "m.label2.t1"]);
    const alone = member("a.label1", "a", { label: { value: 1, name: "" } });
    expect(withLabelsBeside([alone], [alone])).toEqual([alone]);
  });

  test("ChannelsHaveTheColorsOfTheirSource", () => {
    const image = [0x00ff00, 0, undefined].map((color, at) => member(`cells.c${at}`, "cells", { field: `c${at}`, color }));
    expect(image.map(channelColor)).toEqual([{ color: "#00ff00" }, {}, {}]); // Black would be invisible.
    expect(initialSelection(image, defaults)!.changes).toEqual({ surfaces: [surface({ color: "#00ff00" })] });
    expect(initialSelection(image, settingsFrom({ color: "#123456" }))!.changes).toBeNull();
    expect(settingsOfEntry(entriesOf(image)[0], defaults)).toEqual({ dataset: "cells.c0", surfaces: [surface({ color: "#00ff00" })] });
  });

  test("WithFieldsAndLabelsSwitchBetweenBoth", () => {
    const image = ["nuclei", "membrane"].map((field) => member(`cells.${field}`, "cells", { field }));
    const parts = [2, 1].map((value) => member(`cells.label${value}`, "cells", { label: { value, name: "" } }));
    const all = [...image, ...parts];
    const series = seriesOf(all, image[0])!;
    expect([series.fields, names(series.labels)]).toEqual([
      ["nuclei", "membrane"],
      ["cells.label1", "cells.label2"],
    ]);
    expect(memberOfField(series, parts[0], "membrane")).toBe(image[1]);
    const ofLabels = { ...defaults, ...settingsOfEntry({ name: "cells", info: image[0], series }, defaults) };
    expect([ofLabels.dataset, ofLabels.surfaces.length]).toEqual(["cells.label1", 2]);
    // The look of labels goes with them.
    for (const given of [{ dataset: "cells.nuclei" }, { dataset: "cells.nuclei", isovalue: null }]) {
      const change = withLabelChanges(all, parts[1], ofLabels, changeFromWritten(all, parts[1], ofLabels, given));
      expect({ ...ofLabels, ...change }).toEqual({ ...defaults, dataset: "cells.nuclei" });
    }
  });

  test("SingleMembersAreDatasets", () => {
    const alone = member("a.t0", "a", { time: 0 });
    expect(entriesOf([alone])).toEqual([{ name: "a.t0", info: alone, series: null }]);
  });

  test("SelectTheNearestTimeOfTheSameField", () => {
    expect(atTime(list, flow[0], 0.3).name).toBe("flow.speed.t0.25");
    expect(atTime(list, flow[1], -7).name).toBe("flow.heat.t0");
    expect(atTime(list, flow[0], null)).toBe(flow[0]);
    expect(atTime(list, list[0], 0.3)).toBe(list[0]);
    expect(timesOf(list, flow[1])).toEqual([0, 0.25, 0.5]);
    expect(timesOf(list, labels[0])).toEqual([]);
  });

  test("IgnoreInvalidTimes", () => {
    const broken = [NaN, 1, 2].map((time) => member(`b.t${time}`, "b", { time }));
    expect(seriesOf(broken, broken[0])!.times).toEqual([1, 2]);
    expect(timesOf(broken, broken[1])).toEqual([1, 2]);
    expect(atTime(broken, broken[0], 1)).toBe(broken[0]);
  });

  test("SelectAnotherFieldAtTheSameTime", () => {
    const series = seriesOf(list, flow[0])!;
    expect(memberOfField(series, flow[4], "heat")!.name).toBe("flow.heat.t0.25");
    expect(memberOfField(series, flow[4], "salt")).toBeNull();
  });

  test("ChangesOfTheDatasetDoNotKeepATimeOfAnother", () => {
    const now: Settings = { ...defaults, dataset: "flow", t: 0.25 };
    const changed = (change: Partial<Settings>, from = now) => withTimeOfDataset(list, flow[4], from, change).t;
    expect(changed({ dataset: "flow.speed.t0.5" })).toBe(0.5);
    expect([changed({ dataset: "head" }), changed({ dataset: "seg" }), changed({ dataset: "unknown" })]).toEqual([null, null, null]);
    expect([changed({ dataset: "flow" }), changed({ error: 3 }), changed({ dataset: "head" }, { ...now, t: null })]).toEqual([undefined, undefined, undefined]);
    expect(changed({ dataset: "head", t: 0 })).toBe(0);
  });

  test("HaveUniqueNames", () => {
    expect(findByName(list, "flow")!.name).toBe("flow.speed.t0");
    expect(findByName([...list, plain("flow")], "flow")!.member).toBeUndefined();
    expect(findByName(list, "head.t0")).toBeNull();
  });

  test("HaveOneRangeOverAllTimes", () => {
    const series = [0, 1, 2].map((time) => ({ ...member(`s.t${time}`, "s", { time }), min: -time, max: 10 * time }));
    expect(rangeOf(series, series[1])).toEqual({ min: -2, max: 20 });
  });

  test("ShowTimesWithTheirUnit", () => {
    expect(timeText(0.1 + 0.2, "s", [])).toBe("0.3 s");
    expect(timeText(12, "", [12, 13])).toBe("time 12");
  });
});

describe("Labels", () => {
  test("ShowSurfacesAtTheSameIsovalue", () => {
    const entry = entriesOf(list).find(({ name }) => name === "seg")!;
    const overrides = settingsOfEntry(entry, defaults);
    expect(overrides.dataset).toBe("seg.label1");
    expect(overrides.surfaces!.map(({ dataset, isovalue }) => [dataset, isovalue])).toEqual([
      ["", labelIsovalue],
      ["seg.label4", 0.5],
      ["seg.label9", 0.5],
    ]);
  });

  test("SelectANamedLabel", () => {
    const overrides = settingsOfEntry(entriesOf(labels)[0], defaults, "seg.label4");
    expect(overrides.dataset).toBe("seg.label1");
    expect(overrides.surfaces!.map(({ dataset, visible }) => [dataset, visible])).toEqual([
      ["", false],
      ["seg.label4", true],
      ["seg.label9", false],
    ]);
  });

  test("LimitTheInitiallyVisible", () => {
    const many = Array.from({ length: 100 }, (_, i) => member(`m.label${i + 1}`, "m", { label: { value: i + 1, name: "" } }));
    const overrides = settingsOfEntry(entriesOf(many)[0], defaults);
    expect(overrides.surfaces).toHaveLength(100);
    expect(overrides.surfaces!.filter(({ visible }) => visible)).toHaveLength(24);
  });

  test("HaveTheColorOfTheFileOrAConstantOne", () => {
    expect(labelColor(3, 0x0a8265)).toBe("#0a8265");
    expect([1, 2, 3, 64, 1000].map((value) => labelColor(value))).toEqual(["#5cceb7", "#ac7dc0", "#d0b660", "#10a6ad", "#cd776c"]); // As files.
    expect(labelColor(3, 0x1000000)).toBe(labelColor(3));
    const colors = Array.from({ length: 64 }, (_, i) => labelColor(i + 1));
    expect(new Set(colors).size).toBe(64);
    for (const color of colors) expect(color).toMatch(/^#[0-9a-f]{6}$/);
  });

  test("HaveDistinctColors", () => {
    const parts = (color: string) => [1, 3, 5].map((at) => parseInt(color.slice(at, at + 2), 16));
    for (let value = 1; value < 64; ++value) {
      const [a, b] = [parts(labelColor(value)), parts(labelColor(value + 1))];
      expect(Math.hypot(...a.map((v, i) => v - b[i]))).toBeGreaterThan(60);
    }
  });
});

describe("SceneAt", () => {
  test("SelectsSurfacesAndColorsAtOneTime", () => {
    const settings = settingsFrom({
      dataset: "flow",
      colorBy: "flow.heat.t0",
      surfaces: [surface({ dataset: "" }), surface({ dataset: "flow.heat.t0" }), surface({ dataset: "head" }), surface({ dataset: "gone" })],
    });
    const scene = sceneOf(list, settings, atTime(list, flow[0], 0.25));
    expect(scene.infos.map((info) => info?.name)).toEqual(["flow.speed.t0.25", "flow.speed.t0.25", "flow.heat.t0.25", "head", undefined]);
    expect(scene.time).toEqual({ scene: "flow", time: 0.25 });
    expect(scene.scalars).toEqual({ dataset: "flow.heat.t0.25", low: 0, high: 1 });
    expect(sceneOf(list, { ...defaults, colorBy: "gone" }, list[0]).scalars).toEqual({ dataset: "gone" });
  });

  test("AreFoundByTheNameOfASeriesOrField", () => {
    expect(findByName(list, "flow")?.name).toBe(findByName(list, "flow.speed")?.name);
    expect(timeOf(findByName(list, "flow.heat")!)).toBe(Math.min(...timesOf(list, findByName(list, "flow.heat")!)));
    expect(findByName(list, "flow.hea")).toBeNull();
  });

  test("RefuseColorsOfUnknownDatasets", () => {
    expect(sceneRefusal(list, { ...defaults, colorBy: "fule" }, list[0])).toEqual({
      text: 'No dataset named "fule" is served here. Did you mean "fuel"?',
      change: { colorBy: "" },
    });
  });

  test("RefuseSurfacesOfUnknownDatasets", () => {
    const known = surface({ dataset: "fuel", isovalue: 60 });
    const settings = { ...defaults, surfaces: [{ ...known, dataset: "fule" }, known] };
    expect(sceneRefusal(list, settings, list[0])).toEqual({
      text: 'No dataset named "fule" is served here. Did you mean "fuel"?',
      change: { surfaces: [known] },
    });
    expect(sceneRefusal(list, { ...defaults, surfaces: [known] }, list[0])).toBeNull();
  });

  test("SamplesAreTheImageOfLabelsOrAsChosen", () => {
    const placed = (info: DatasetInfo, x = 0) => ({ ...info, indexToWorld: [1, 0, 0, 0, 1, 0, 0, 0, 1, x, 0, 0] });
    const part = placed(labels[0]);
    const [shifted, ct] = [placed(plain("shifted"), 1), placed(plain("ct"))];
    const channel = placed(member("seg.nuclei", "seg", { field: "nuclei" }));
    expect(sampledOf([part, shifted], defaults, part)).toBe(part);
    expect(sampledOf([shifted, ct, part], defaults, part)).toBe(ct);
    expect(sampledOf([ct, part, channel], defaults, part)).toBe(channel);
    expect(sampledOf([ct, placed(plain("other")), part], defaults, part)).toBe(part); // Which one is unknown.
    expect(sampledOf([shifted, ct], defaults, shifted)).toBe(shifted);
    const fine = { ...ct, name: "fine", dims: ct.dims.map((n) => 2 * n), indexToWorld: [0.5, 0, 0, 0, 0.5, 0, 0, 0, 0.5, -0.25, -0.25, -0.25] };
    expect(sampledOf([fine, part], defaults, part)).toBe(fine); // Another grid of the same place.
    expect(sampledOf([{ ...fine, lengthUnit: "um" }, part], defaults, part)).toBe(part);
    expect(sampledOf([fine, part, placed(plain("far"), 100)], defaults, part)).toBe(part);
    expect(sampledOf([shifted, ct, part], { ...defaults, samplesOf: "shifted" }, part)).toBe(shifted);
    expect(sampledOf(list, { ...defaults, samplesOf: "flow.heat.t0" }, flow[0]).name).toBe("flow.heat.t0.5");
    const far = placed(plain("far"), 100);
    expect(sampledOf([ct, far], { ...defaults, samplesOf: "far" }, ct)).toBe(ct);
    expect(sceneRefusal([ct, far], { ...defaults, samplesOf: "far" }, ct)).toEqual({
      text: 'Slices cannot show "far": it is at another position than "ct": their bounding boxes do not overlap.',
      change: { samplesOf: "" },
    });
    expect(sceneRefusal([ct, far], { ...defaults, samplesOf: "ctt" }, ct)?.text).toBe('No dataset named "ctt" is served here. Did you mean "ct"?');
  });
});
