import type { DatasetInfo } from "../../../client/web/src/protocol/messages";
import { labelRanges, labelsOfRanges, parseLabels } from "../../../client/web/src/state/label_ranges";
import {
  absentSegmentation,
  changeFromWritten,
  imageBeside,
  initialSelection,
  segmentationsBeside,
  settingsOfEntry,
  withImage,
  withLabelChanges,
  withSegmentation,
  withShortLabels,
} from "../../../client/web/src/state/label_surfaces";
import { entriesOf, nameOfLabel, withLabelName } from "../../../client/web/src/state/series";
import { defaults, type Settings } from "../../../client/web/src/state/settings";
import { withAddedSurface, withAllSurfaces, withoutSurface, withSurface } from "../../../client/web/src/state/surfaces";
import { fromAddress, toAddress } from "../../../client/web/src/state/url_state";
import { member, plain } from "./made_datasets";
import { settingsFrom, surface } from "./made_settings";

const values = Array.from({ length: 322 }, (_, i) => i + 1);
const list = values.map((value) => member(`cells.label${value}`, "cells", { label: { value, name: `cell ${value}` } }));
const all: Settings = { ...defaults, ...settingsOfEntry(entriesOf(list)[0], defaults) };

// The settings of a page that opens the address.
function opened(address: string): Settings {
  const settings = settingsFrom(fromAddress(address));
  return { ...settings, ...initialSelection(list, settings)!.changes };
}

describe("LabelRanges", () => {
  test("AreShort", () => {
    const without = (...hidden: number[]) => labelRanges(values, new Set(values.filter((value) => !hidden.includes(value))));
    expect([without(), without(17), without(17, 18, 40)]).toEqual(["1-322", "1-322,-17", "1-322,-17-18,-40"]);
    expect(labelRanges(values, new Set([1, 2, 3, 7]))).toBe("1-3,7");
    expect(labelRanges([2, 5, 9], new Set([2, 5, 9]))).toBe("2-9"); // No label is in between.
    expect(labelRanges(values, new Set())).toBe("none");
    expect(labelRanges([-7, 3], new Set([3]))).toBeNull();
  });

  test("ParseToTheSameLabels", () => {
    const gaps = values.filter((value) => value % 3 > 0 || value > 200);
    for (const every of [2, 3, 5, 40]) {
      const shown = new Set(gaps.filter((value) => value % every > 0));
      expect(labelsOfRanges(labelRanges(gaps, shown)!, gaps)).toEqual(shown);
    }
    expect(labelsOfRanges("-17", [16, 17, 18])).toEqual(new Set([16, 18]));
    expect(labelsOfRanges("5-2,99,none", [2, 3, 5])).toEqual(new Set());
    for (const malformed of ["1-3,x", "", "1-", "--1", "1,,2", ":1-3", ":"]) expect(parseLabels(malformed)).toBeNull();
    expect(parseLabels("a:b:1-3,-2")).toEqual({ series: "a:b", ranges: "1-3,-2" });
  });
});

describe("AddressesOfLabels", () => {
  test("RestoreTheSettings", () => {
    const shown = { ...all, ...withAllSurfaces(all, (_, at) => ({ visible: at !== 16 })) };
    expect(toAddress(withShortLabels(list, shown))).toBe("dataset=cells.label1&labels=1-322,-17");
    const changed = { ...shown, ...withSurface(shown, 4, { color: "#ff0000", opacity: 0.5 }) };
    const first = { ...changed, ...withSurface(changed, 0, { minComponent: 3 }) };
    for (const settings of [all, shown, changed, first, { ...all, ...withAllSurfaces(all, () => ({ visible: false })) }]) {
      const address = toAddress(withShortLabels(list, settings));
      expect(address.length).toBeLessThan(160);
      expect(opened(address)).toEqual(settings);
    }
  });

  test("KeepSurfacesThatAreNotLabels", () => {
    const some = { ...all, surfaces: all.surfaces.slice(0, 5) };
    expect(withShortLabels(list, some)).toBe(some);
    expect(withShortLabels([], all)).toBe(all);
    expect(opened("dataset=cells.label3&labels=2-4")).toMatchObject({ dataset: "cells.label1", labels: "" });
    expect(opened("dataset=cells.label3&labels=2-4").surfaces[0].visible).toBe(false);
    const plainDataset = member("head", "", {});
    expect(initialSelection([plainDataset], { ...defaults, labels: "1-3" })!.changes).toEqual({ labels: "" });
  });

  test("ContainLabelNames", () => {
    const names = withLabelName(withLabelName([], 7, "a; b 50 %"), 3, "liver");
    expect(toAddress({ ...defaults, labelNames: names })).toMatch(/^label_names=3:liver/);
    expect(fromAddress(toAddress({ ...defaults, labelNames: names })).labelNames).toEqual(names);
    const label = list[2].member!.label!;
    expect(nameOfLabel(label, { ...defaults, labelNames: names })).toBe("liver");
    expect(nameOfLabel(label, defaults)).toBe("cell 3");
    expect(withLabelName(names, 3, "")).toEqual([{ label: 7, name: "a; b 50 %" }]);
    expect(["x:liver", "3", "3:", "3:a;4"].map((text) => fromAddress(`label_names=${text}`))).toEqual([{}, {}, {}, {}]);
  });
});

describe("ChangesOfLabels", () => {
  const [fuel, cell] = [plain("fuel"), list[0]];
  const changed = (from: Settings, change: Partial<Settings>, shown = cell) => ({ ...from, ...withLabelChanges([fuel, ...list], shown, from, change) });

  test("ReplaceAllSurfaces", () => {
    const other = settingsFrom({ dataset: "fuel", isovalue: 7, color: "#ff0000", surfaces: all.surfaces.slice(3, 5) });
    for (const [from, shown, change] of [
      [all, cell, {}],
      [all, cell, { dataset: "cells" }],
      [other, fuel, { dataset: "cells" }],
    ] as const) {
      const now = changed(from, { ...change, labels: "2,4" }, shown);
      expect(now).toEqual({ ...all, ...withAllSurfaces(all, (_, at) => ({ visible: at === 1 || at === 3 })) });
    }
    expect(changed(other, { labels: "2" }, fuel)).toEqual(other); // It has no labels.
  });

  test("LeaveNothingForOtherDatasets", () => {
    expect(changed({ ...all, ...withSurface(all, 0, { visible: false }) }, { dataset: "fuel" })).toEqual({ ...defaults, dataset: "fuel" });
    const given = { dataset: "fuel", isovalue: 3, color: "#ff0000" };
    expect(changed(all, changeFromWritten([fuel, ...list], cell, all, given))).toEqual(settingsFrom(given));
    expect(changed(all, { dataset: "cells.label3" }).surfaces).toBe(all.surfaces);
  });
});

describe("LabelsBesideAnImage", () => {
  const [fuel, mask] = [plain("fuel"), member("mask", "", { label: { value: 7, name: "tumor" } })];
  const served = [fuel, ...list, mask];
  const cells = { name: "cells", labels: list };
  const beside = (settings: Settings, chosen: typeof cells | null = cells) => ({ ...settings, ...withSegmentation(served, settings, chosen) });
  const isLabel = ({ dataset = "" }) => dataset.startsWith("cells");
  const ct = settingsFrom({ dataset: "fuel", isovalue: 7 });

  test("AreOfferedInItsWorld", () => {
    expect(segmentationsBeside(served, fuel).map(({ name, labels }) => [name, labels.length])).toEqual([
      ["cells", 322],
      ["mask", 1],
    ]);
    expect(segmentationsBeside(served, list[0])).toEqual([]);
    const at = (one: DatasetInfo, x: number) => ({ ...one, indexToWorld: [1, 0, 0, 0, 1, 0, 0, 0, 1, x, 0, 0] });
    expect([2, 100].map((x) => segmentationsBeside([at(mask, x)], at(fuel, 0)).length)).toEqual([1, 0]);
    expect(imageBeside(served, list[0])).toBe(fuel);
    expect(imageBeside(list, list[0])).toBeNull();
    expect(imageBeside(served, fuel)).toBeNull();
  });

  test("AreNamedWhileTheyAreAbsent", () => {
    const waiting = { ...ct, labels: "organs:1-3" };
    expect(initialSelection(served, waiting)?.changes?.labels).toBeUndefined(); // They stay in the address.
    expect(absentSegmentation(served, waiting)?.words).toBe("organs: not on this server yet");
    expect(absentSegmentation([fuel, ...list], { ...ct, labels: "cells:" })?.words).toBe("cells: in another place");
    expect(absentSegmentation(served, { ...ct, labels: "1-3" })).toBeNull();
    expect(beside(waiting, null).labels).toBe("");
  });

  test("ReplaceOtherLabelsButNoSurfaces", () => {
    const added = { ...ct, ...withAddedSurface(ct, 20, 7) };
    const two = { ...added, ...withSurface(added, 0, { opacity: 1 }) };
    const shown = beside(two);
    expect(shown.surfaces.map(({ dataset }) => dataset)).toEqual(["", "", ...list.map(({ name }) => name)]);
    expect(shown.surfaces.filter(({ visible }) => visible)).toHaveLength(26);
    expect(shown.surfaces[0].opacity).toBe(0.35); // It encloses the labels.
    const other = beside(shown, { name: "mask", labels: [mask] });
    expect(other.surfaces.map(({ dataset }) => dataset)).toEqual(["", "", "mask"]);
    expect(beside(other, null).surfaces).toEqual(added.surfaces);
    expect(beside(beside(ct), null)).toEqual(ct);
    const thin = { ...ct, ...withSurface(ct, 0, { opacity: 0.8 }) };
    expect(beside(beside(thin), null)).toEqual(thin);
  });

  test("StayTheLastSurfaces", () => {
    const shown = beside(ct);
    const added = { ...shown, ...withAddedSurface(shown, 20, 7, isLabel) };
    expect(added.surfaces.map(({ dataset }) => dataset).slice(0, 3)).toEqual(["", "", "cells.label1"]);
    let many = shown;
    for (let i = 0; i < 12; ++i) many = { ...many, ...withAddedSurface(many, 20 + i, 7, isLabel) };
    expect(many.surfaces.filter((one) => !isLabel(one))).toHaveLength(8); // Labels do not count.
    expect(withoutSurface(shown, 0)).toMatchObject({ dataset: "cells.label1" });
  });

  test("HaveShortAddresses", () => {
    const openedBeside = (address: string) => {
      const settings = settingsFrom(fromAddress(address));
      return { ...settings, ...initialSelection(served, settings)!.changes };
    };
    const initial = beside(ct);
    const shown = { ...initial, ...withAllSurfaces(initial, (_, at) => ({ visible: at !== 17 })) };
    expect(toAddress(withShortLabels(served, shown))).toBe("dataset=fuel&labels=cells:1-322,-17&isovalue=7&opacity=0.35");
    const changed = { ...shown, ...withSurface(shown, 5, { color: "#ff0000", opacity: 0.5 }) };
    const added = { ...changed, ...withAddedSurface(changed, 20, 7, isLabel) };
    for (const settings of [initial, shown, changed, added, beside(ct, { name: "mask", labels: [mask] })]) {
      const address = toAddress(withShortLabels(served, settings));
      expect(address.length).toBeLessThan(160);
      expect(openedBeside(address)).toEqual(settings);
    }
    expect(openedBeside("dataset=fuel&isovalue=7&opacity=0.35&labels=cells:")).toEqual(initial);
    // Labels that are not served yet are shown when they are.
    expect(openedBeside("dataset=fuel&labels=organs:1-3")).toEqual({ ...defaults, dataset: "fuel", labels: "organs:1-3" });
    const some = { ...initial, surfaces: initial.surfaces.slice(0, 5) };
    expect(withShortLabels(served, some)).toBe(some);
  });

  test("AreReplacedByNamedLabels", () => {
    const added = { ...ct, ...withAddedSurface(ct, 20, 7) };
    const now = { ...added, ...withLabelChanges(served, fuel, added, { labels: "cells:2,4" }) };
    expect(now.surfaces.filter(({ visible }) => visible).map(({ dataset }) => dataset)).toEqual(["", "", "cells.label2", "cells.label4"]);
    const next = { ...now, ...withLabelChanges(served, fuel, now, { labels: "mask:7" }) };
    expect(next.surfaces.map(({ dataset }) => dataset)).toEqual(["", "", "mask"]);
  });

  test("KeepTheirLookWhenTheImageIsAdded", () => {
    const red = { ...all, ...withSurface(all, 0, { color: "#ff0000", minComponent: 3 }), error: 0.5 };
    const now = { ...red, ...withImage(red, fuel) };
    expect(now).toMatchObject({ dataset: "fuel", error: 0.5 });
    expect(now.surfaces).toHaveLength(323);
    expect(now.surfaces[0]).toEqual(surface({ opacity: 0.35 }));
    expect(now.surfaces[1]).toMatchObject({ dataset: "cells.label1", isovalue: 0.5, color: "#ff0000", minComponent: 3 });
    expect(now.surfaces.slice(2)).toStrictEqual(all.surfaces.slice(1));
    expect({ ...red, ...withLabelChanges(served, list[0], red, withImage(red, fuel)) }).toEqual(now);
  });
});
