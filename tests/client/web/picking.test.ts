import { mostVisible } from "../../../client/web/src/scene/picking";

const hit = (place: string, opacity: number) => ({ place, opacity });

describe("MostVisible", () => {
  test("ReturnsTheNearestOpaquePlace", () => {
    expect(mostVisible([hit("near", 1), hit("far", 1)])).toBe("near");
    expect(mostVisible([])).toBeNull();
  });

  test("SkipsNearlyTransparentPlaces", () => {
    expect(mostVisible([hit("glass", 0.17), hit("cell", 0.98)])).toBe("cell");
    expect(mostVisible([hit("glass", 0.17), hit("other glass", 0.17)])).toBe("glass");
    expect(mostVisible([hit("skin", 0.6), hit("bone", 1)])).toBe("skin");
  });
});
