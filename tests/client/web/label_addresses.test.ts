import { isLabelRanges, labelRanges, labelsOfRanges } from "../../../client/web/src/state/label_ranges";
import { nameOfLabel, settingsOfEntry, entriesOf, withShortLabels, initialSelection, withLabelChanges, withLabelName } from "../../../client/web/src/state/series";
import { defaults, type Settings } from "../../../client/web/src/state/settings";
import { withAllSurfaces, withSurface } from "../../../client/web/src/state/surfaces";
import { fromAddress, toAddress } from "../../../client/web/src/state/url_state";
import { member, plain } from "./made_datasets";

const values = Array.from({ length: 322 }, (_, i) => i + 1);
const list = values.map((value) => member(`cells.label${value}`, "cells", { label: { value, name: `cell ${value}` } }));
const all: Settings = { ...defaults, ...settingsOfEntry(entriesOf(list)[0]) };

// The settings of a page that opens the address.
function opened(address: string): Settings {
  const settings = { ...defaults, ...fromAddress(address) };
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
    expect(["1-3,x", "", "1-", "--1", "1,,2"].map(isLabelRanges)).toEqual([false, false, false, false, false]);
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
    expect(opened("dataset=cells.label3&labels=2-4")).toMatchObject({ dataset: "cells.label1", visible: false, labels: "" });
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
    const other = { ...defaults, dataset: "fuel", isovalue: 7, color: "#ff0000", surfaces: all.surfaces.slice(3, 5) };
    for (const [from, shown, change] of [[all, cell, {}], [all, cell, { dataset: "cells" }], [other, fuel, { dataset: "cells" }]] as const) {
      const now = changed(from, { ...change, labels: "2,4" }, shown);
      expect(now).toEqual({ ...all, ...withAllSurfaces(all, (_, at) => ({ visible: at === 1 || at === 3 })) });
    }
    expect(changed(other, { labels: "2" }, fuel)).toEqual(other); // It has no labels.
  });

  test("LeaveNothingForOtherDatasets", () => {
    expect(changed({ ...all, visible: false }, { dataset: "fuel" })).toEqual({ ...defaults, dataset: "fuel" });
    expect(changed(all, { dataset: "fuel", isovalue: 3, color: "#ff0000" })).toMatchObject({ isovalue: 3, color: "#ff0000", surfaces: [] });
    expect(changed(all, { dataset: "cells.label3" }).surfaces).toBe(all.surfaces);
  });
});
