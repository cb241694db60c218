import { defaults, type Settings } from "../../../client/web/src/state/settings";
import {
  maxSurfaces,
  settingsOf,
  surfacesOf,
  withAddedSurface,
  withMaterial,
  withOtherDataset,
  withoutSurface,
  withSurface,
} from "../../../client/web/src/state/surfaces";
import { reusedMembers, stepsToRequest } from "../../../client/web/src/surfaces/surface_set";

const further = { isovalue: 7, error: null, color: "#112233", opacity: 0.5, visible: true };
const two: Settings = { ...defaults, isovalue: 3, error: 2, surfaces: [further] };
const isovalues = (settings: Settings) => surfacesOf(settings).map(({ isovalue }) => isovalue);

describe("Surfaces", () => {
  test("FromOtherDatasetsAreTranslucent", () => {
    const added = { ...two, opacity: 0.35 }; // The opacity after adding an inner surface.
    const own = { dataset: "cells.actin", isovalue: 9, color: "#00ff00" };
    expect(withOtherDataset(added, 1, own)).toEqual({ surfaces: [{ ...further, ...own, opacity: 0.35 }], opacity: 1 });
    expect(withOtherDataset({ ...two, opacity: 0.8 }, 1, own)).not.toHaveProperty("opacity"); // The user's.
  });

  test("MaterialsBringTheirColors", () => {
    expect(withMaterial({ color: "#d9775f" }, "bone")).toEqual({ material: "bone", color: "#f0e6d2" });
    expect(withMaterial({ color: "#f0e6d2" }, "skin")).toEqual({ material: "skin", color: "#e8b89a" });
    expect(withMaterial({ color: "#123456" }, "bone")).toEqual({ material: "bone" }); // The user's.
    expect(withMaterial({ color: "#d9775f" }, "glossy")).toEqual({ material: "glossy" });
  });

  test("BeginWithTheSettingsOwn", () => {
    expect(isovalues(two)).toEqual([3, 7]);
    expect(withSurface(two, 0, { isovalue: 4, opacity: 0.1 })).toEqual({ isovalue: 4, opacity: 0.1 });
    expect(withSurface(two, 1, { isovalue: 8 })).toEqual({ surfaces: [{ ...further, isovalue: 8 }] });
  });

  test("AreRequestedIndependently", () => {
    expect(settingsOf(two, 1)).toMatchObject({ isovalue: 7, error: 2, opacity: 0.5, surfaces: [] });
    expect(settingsOf({ ...two, surfaces: [{ ...further, error: 0.5 }] }, 1)).toMatchObject({ error: 0.5 });
    expect(settingsOf(two, 2)).toBeNull();
    expect(settingsOf({ ...two, minComponent: 9 }, 1)).toMatchObject({ minComponent: 0 });
    expect(settingsOf({ ...two, surfaces: [{ ...further, minComponent: 4 }] }, 1)).toMatchObject({ minComponent: 4 });
  });

  test("RemovalPromotesTheNext", () => {
    const one = { ...two, ...withoutSurface(two, 0) };
    expect(isovalues(one)).toEqual([7]);
    expect(one.error).toBe(2);
    expect(one.color).toBe("#112233");
    expect(withoutSurface(one, 0)).toEqual({});
    expect(withoutSurface({ ...two, minComponent: 9 }, 0)).toMatchObject({ minComponent: 0 });
    expect(isovalues({ ...two, ...withoutSurface(two, 1) })).toEqual([3]);
  });

  test("KeepTheirDataset", () => {
    const three: Settings = { ...two, dataset: "head", surfaces: [{ ...further, dataset: "dose" }, further] };
    const left = { ...three, ...withoutSurface(three, 0) };
    expect(left.dataset).toBe("dose");
    expect(left.surfaces).toEqual([{ ...further, dataset: "head" }]);
  });

  test("HaveDistinctColorsUpToALimit", () => {
    let all: Settings = defaults;
    for (let i = 0; i < 20; ++i) all = { ...all, ...withAddedSurface(all, i, 0) };
    const list = surfacesOf(all);
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
