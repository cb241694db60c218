import { readFileSync } from "node:fs";

import { parseSettings } from "../../../client/web/src/state/parse_settings";
import { writtenDefaults as defaults } from "../../../client/web/src/state/settings";
import { surface } from "./made_settings";

describe("parseSettings", () => {
  test("MatchesAddresses", () => {
    const overrides = {
      isovalue: 500.5,
      error: 0.25,
      region: { kind: "ball", center: [1, 2, 3], radius: 4, error: 0.5 },
      eye: [1, 2, 3],
      surfaces: [surface({ isovalue: 3, color: "#d9775f", opacity: 0.5 })],
      clip: "x",
      wireframe: true,
    };
    expect(parseSettings(overrides)).toEqual({ settings: overrides, ignored: [] });
  });

  test("AcceptsDefaults", () => {
    expect(parseSettings({ ...defaults })).toEqual({ settings: defaults, ignored: [] });
  });

  test("FillsInDefaultsOfSurfaces", () => {
    expect(parseSettings({ surfaces: [{ isovalue: 3 }, { isovalue: 4, opacity: 0.5, minComponent: "largest" }] })).toEqual({
      ignored: [],
      settings: {
        surfaces: [surface({ isovalue: 3, color: "#d9775f" }), surface({ isovalue: 4, color: "#7fb3d5", opacity: 0.5, minComponent: "largest" })],
      },
    });
  });

  test("ReportsIgnoredFieldsOfSurfaces", () => {
    const surfaces = [{ isovalue: 3, opacity: 2, visible: "no", colour: "#ffffff" }, { color: "#ffffff" }, { isovalue: NaN }, null];
    expect(parseSettings({ surfaces })).toEqual({
      settings: { surfaces: [surface({ isovalue: 3, color: "#d9775f" })] },
      ignored: ["surfaces[0].opacity", "surfaces[0].visible", "surfaces[0].colour", "surfaces[1].isovalue", "surfaces[2].isovalue", "surfaces[3].isovalue"],
    });
  });

  test("GuideListsAllSettings", () => {
    const guide = readFileSync(new URL("../../../client/web/EMBEDDING.md", import.meta.url), "utf8");
    const fields = guide.slice(guide.indexOf("Fields of `state`"), guide.indexOf("## As a module"));
    expect(Object.keys(defaults).filter((name) => !new RegExp(`\\b${name}\\b`).test(fields))).toEqual([]);
  });

  test("ReportsIgnoredSettingsByName", () => {
    const overrides = JSON.parse('{"isovlaue":1,"error":-1,"region":7,"surfaces":"x","eye":[1,2],"clip":"w","__proto__":{"a":1},"theme":{}}');
    const { settings, ignored } = parseSettings(overrides);
    expect(settings).toEqual({});
    expect(ignored.sort()).toEqual(["__proto__", "clip", "error", "eye", "isovlaue", "region", "surfaces", "theme"]);
    for (const value of [NaN, Infinity]) expect(parseSettings({ isovalue: value, eye: value })).toEqual({ settings: {}, ignored: ["isovalue", "eye"] });
    for (const nothing of [null, 7, "isovalue", undefined]) expect(parseSettings(nothing)).toEqual({ settings: {}, ignored: [] });
  });
});
