import { seenBest } from "../../../client/web/src/scene/picking";

const hit = (place: string, opacity: number) => ({ place, opacity });

describe("SeenBest", () => {
  test("TakesTheNearestOfOpaquePlaces", () => {
    expect(seenBest([hit("near", 1), hit("far", 1)])).toBe("near");
    expect(seenBest([])).toBeNull();
  });

  test("LooksThroughWhatIsHardlySeen", () => {
    expect(seenBest([hit("glass", 0.17), hit("cell", 0.98)])).toBe("cell");
    expect(seenBest([hit("glass", 0.17), hit("other glass", 0.17)])).toBe("glass");
    expect(seenBest([hit("skin", 0.6), hit("bone", 1)])).toBe("skin");
  });
});
