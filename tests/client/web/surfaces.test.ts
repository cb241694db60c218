import { defaults, type Settings } from "../../../client/web/src/state/settings";
import { maxSurfaces, settingsOf, withAddedSurface, withMaterial, withOtherDataset, withoutSurface, withSurface } from "../../../client/web/src/state/surfaces";
import { written } from "../../../client/web/src/state/written_settings";
import { reusedMembers, stepsToRequest } from "../../../client/web/src/surfaces/surface_set";
import { settingsFrom, surface } from "./made_settings";

const further = surface({ isovalue: 7, color: "#112233", opacity: 0.5 });
const two = settingsFrom({ isovalue: 3, error: 2, surfaces: [further] });
const [first] = two.surfaces;
const isovalues = (settings: Settings) => settings.surfaces.map(({ isovalue }) => isovalue);

describe("Surfaces", () => {
  test("FromOtherDatasetsAreTranslucent", () => {
    const withFirst = (opacity: number) => ({ ...two, ...withSurface(two, 0, { opacity }) });
    const own = { dataset: "cells.actin", isovalue: 9, color: "#00ff00" };
    expect(withOtherDataset(withFirst(0.35), 1, own).surfaces).toEqual([first, { ...further, ...own, opacity: 0.35 }]); // Added as an inner surface.
    expect(withOtherDataset(withFirst(0.8), 1, own).surfaces[0].opacity).toBe(0.8); // The user's.
  });

  test("MaterialsBringTheirColors", () => {
    expect(withMaterial({ color: "#d9775f" }, "bone")).toEqual({ material: "bone", color: "#f0e6d2" });
    expect(withMaterial({ color: "#f0e6d2" }, "skin")).toEqual({ material: "skin", color: "#e8b89a" });
    expect(withMaterial({ color: "#123456" }, "bone")).toEqual({ material: "bone" }); // The user's.
    expect(withMaterial({ color: "#d9775f" }, "glossy")).toEqual({ material: "glossy" });
  });

  test("BeginWithTheOneWrittenBesideThem", () => {
    expect(isovalues(two)).toEqual([3, 7]);
    expect(withSurface(two, 0, { isovalue: 4, opacity: 0.1 }).surfaces).toEqual([{ ...first, isovalue: 4, opacity: 0.1 }, further]);
    expect(withSurface(two, 1, { isovalue: 8 }).surfaces).toEqual([first, { ...further, isovalue: 8 }]);
    expect(withSurface(two, 1, { isovalue: 7 }).surfaces).toBe(two.surfaces);
  });

  test("AreRequestedIndependently", () => {
    expect(settingsOf(two, 1)).toMatchObject({ isovalue: 7, error: 2, opacity: 0.5 });
    expect(settingsOf({ ...two, surfaces: [{ ...further, error: 0.5 }] }, 0)).toMatchObject({ error: 0.5 });
  });

  test("ShowAllPartsOfAnotherIsovalue", () => {
    const hidden = { ...two, ...withSurface(two, 1, { hiddenParts: [[1, 2, 3]] }) };
    expect(withSurface(hidden, 1, { isovalue: 8 }).surfaces[1].hiddenParts).toEqual([]);
    expect(withSurface(hidden, 1, { isovalue: 7, opacity: 1 }).surfaces[1].hiddenParts).toEqual([[1, 2, 3]]);
  });

  test("AreWrittenWithTheErrorOfTheFirst", () => {
    const fine = { ...two, ...withSurface(two, 0, { error: 0.5 }) };
    expect(written(fine)).toMatchObject({ isovalue: 3, error: 0.5, surfaces: [{ isovalue: 7, error: 2 }] });
    expect(written(two)).toMatchObject({ error: 2, surfaces: [{ error: null }] });
  });

  test("RemovalPromotesTheNext", () => {
    const one = { ...two, ...withoutSurface(two, 0) };
    expect(isovalues(one)).toEqual([7]);
    expect(withoutSurface(one, 0)).toEqual({});
    expect(isovalues({ ...two, ...withoutSurface(two, 1) })).toEqual([3]);
  });

  test("KeepTheirDataset", () => {
    const three = { ...two, dataset: "head", surfaces: [first, { ...further, dataset: "dose" }, further] };
    expect(withoutSurface(three, 0)).toEqual({ dataset: "dose", surfaces: [further, { ...further, dataset: "head" }] });
  });

  test("HaveDistinctColorsUpToALimit", () => {
    let all: Settings = defaults;
    for (let i = 0; i < 20; ++i) all = { ...all, ...withAddedSurface(all, i, 0) };
    const list = all.surfaces;
    expect(list).toHaveLength(maxSurfaces);
    expect(new Set(list.map(({ color }) => color)).size).toBe(maxSurfaces);
  });

  test("RequestCoarsePreviewsIfMany", () => {
    expect([stepsToRequest(1, false), stepsToRequest(24, false), stepsToRequest(24, true)]).toEqual(["all", "previews", "all"]);
    expect([stepsToRequest(25, false), stepsToRequest(1000, true)]).toEqual(["coarse", "coarse"]);
  });

  test("KeepTheirMembersWhenOthersChange", () => {
    expect(reusedMembers([], ["a"])).toEqual([null]);
    expect(reusedMembers(["a", "b", "c"], ["a", "c"])).toEqual([0, 2]);
    expect(reusedMembers(["a", "b", "c"], ["b", "c"])).toEqual([1, 2]);
    expect(reusedMembers(["a", "b"], ["a", "x", "b"])).toEqual([0, null, 1]);
    expect(reusedMembers(["a", "b"], ["x", "b"])).toEqual([0, 1]); // Changed by dragging.
    expect(reusedMembers(["a", "a"], ["a", "a", "a"])).toEqual([0, 1, null]);
  });
});
