import { SampleType } from "../../../client/web/src/protocol/messages";
import { BlockRanges, levelsOf, nextLevel, samplesOf, slabsOf } from "../../../client/web/src/scene/volume/levels";
import { extinctionTable, isVisible, opacityAt, tableLength, volumePresets } from "../../../client/web/src/scene/volume/opacities";
import { halfOf, madeSlab } from "../../../client/web/src/scene/volume/slab";
import { VolumePass } from "../../../client/web/src/scene/volume/volume_pass";
import { blockTexture, texelRange, type VolumeTexture } from "../../../client/web/src/scene/volume/volume_texture";
import { fromAddress } from "../../../client/web/src/state/url_state";
import type { Vec3 } from "../../../client/web/src/stream/dataset";
import { plain as named } from "./made_datasets";

const plain = named("head");

const points = (...pairs: [number, number][]) => pairs.map(([value, opacity]) => ({ value, opacity }));

describe("Opacities", () => {
  test("AreLinearBetweenPointsAndConstantBeyond", () => {
    const ramp = points([100, 0.2], [200, 0.6]);
    expect([0, 100, 150, 200, 999].map((value) => opacityAt(ramp, value))).toEqual([0.2, 0.2, 0.4, 0.6, 0.6]);
  });

  test("StepAtOneValue", () => {
    const step = points([100, 0], [100, 1]);
    expect([99.9, 100, 101].map((value) => opacityAt(step, value))).toEqual([0, 1, 1]);
    const table = extinctionTable(step);
    expect(table[0]).toBeCloseTo(0, 9);
    expect(table[2]).toBeGreaterThan(9);
    expect(table[2 * tableLength - 1]).toBeCloseTo(table[2], 2); // The integral of a constant.
  });

  test("IntegrateExtinctions", () => {
    const table = extinctionTable(points([0, 0], [10, 0.5]));
    expect(table[2 * tableLength - 2]).toBeCloseTo(Math.LN2, 5);
    expect(table[2 * tableLength - 1]).toBeCloseTo(1 - Math.LN2, 5); // The integral of -log(1 - x / 2) from 0 to 1.
  });

  test("AreVisibleWherePointsBetweenTheEndsAre", () => {
    const peak = points([0, 0], [10, 0], [11, 0.5], [12, 0], [20, 0]);
    expect(isVisible(peak, 0, 10)).toBe(false);
    expect(isVisible(peak, 2, 18)).toBe(true);
    expect(isVisible(peak, 10.5, 10.6)).toBe(true);
    expect(isVisible(peak, 12, 30)).toBe(false);
    expect(isVisible(points([0, 1]), Infinity, -Infinity)).toBe(false); // A block without values.
  });

  test("PresetsAreByUnit", () => {
    const names = (info: typeof plain) => volumePresets(info).map(({ name }) => name);
    expect(names({ ...plain, min: -1024, max: 3000, valueUnit: "HU" })).toEqual(["CT bone", "CT soft tissue", "Maximum"]);
    expect(names({ ...plain, valueUnit: "" })).toEqual(["MR", "Fluorescence", "Maximum"]);
    for (const { changes } of volumePresets(plain)) {
      const values = changes.opacities.map(({ value }) => value);
      expect(values).toEqual([...values].sort((a, b) => a - b));
    }
  });

  test("AreRejectedOutOfOrderOrRange", () => {
    expect(fromAddress("volume=on&opacities=-5:0,5:0.5,5:1").opacities).toEqual(points([-5, 0], [5, 0.5], [5, 1]));
    for (const bad of ["5:0,4:1", "1:2", "1", "1:x,2:0", "a:0.5", Array(17).fill("1:0").join()]) {
      expect(fromAddress(`opacities=${bad}`).opacities).toBeUndefined();
    }
  });
});

describe("Levels", () => {
  const ct = { dims: [512, 512, 134] };
  const steps = (samples: number, side = 2048) => levelsOf(ct, { samples, side }).map(({ step }) => step);

  test("EndAtTheBudget", () => {
    expect(steps(1 << 28)).toEqual([8, 4, 2, 1]);
    expect(steps(5_000_000)).toEqual([8, 4, 2]);
    expect(steps(1 << 28, 256)).toEqual([8, 4, 2]);
    expect(steps(20_000)).toEqual([16]);
  });

  test("BeginFinerWhereThatIsSmall", () => {
    expect(levelsOf({ dims: [33, 33, 33] }, { samples: 1 << 28, side: 2048 })).toEqual([{ step: 1, counts: [33, 33, 33] }]);
  });

  test("AreSkippedWhereTheLastFollowsSoon", () => {
    const levels = levelsOf(ct, { samples: 1 << 28, side: 2048 });
    const next = (at: number, milliseconds: number) => levels[nextLevel(levels, at, milliseconds)]?.step;
    expect([next(0, 10), next(1, 10), next(1, 1000), next(2, 10)]).toEqual([4, 1, 2, 1]);
    expect(next(3, 10)).toBeUndefined();
  });

  test("SlabsCoverALevelOnce", () => {
    const wide = { step: 2, counts: [1500, 1400, 3] as Vec3 };
    for (const level of [wide, ...levelsOf(ct, { samples: 1 << 28, side: 2048 })]) {
      const slabs = slabsOf(level);
      expect(slabs.reduce((sum, { counts }) => sum + samplesOf(counts), 0)).toBe(samplesOf(level.counts));
      const last = slabs[slabs.length - 1];
      expect(Math.max(...slabs.map(({ counts }) => samplesOf(counts)))).toBeLessThanOrEqual(1 << 21); // The server's limit.
      expect(last.first[1] + (last.counts[1] - 1) * level.step).toBe((level.counts[1] - 1) * level.step);
      expect(last.first[2] + (last.counts[2] - 1) * level.step).toBe((level.counts[2] - 1) * level.step);
    }
  });
});

describe("BlockRanges", () => {
  // The values of layers of a grid, added in parts.
  function rangesOf(counts: Vec3, values: Float32Array, layersAtOnce: number): BlockRanges {
    const ranges = new BlockRanges(counts);
    const layer = counts[0] * counts[1];
    for (let z = 0; z < counts[2]; z += layersAtOnce) ranges.add(z * counts[1], values.subarray(z * layer, (z + layersAtOnce) * layer));
    return ranges;
  }

  test("HoldTheSamplesAtBothEndsOfTheirCells", () => {
    const counts: Vec3 = [19, 9, 17];
    const values = Float32Array.from({ length: samplesOf(counts) }, (_, i) => Math.sin(i * 12.9898) * 100);
    for (const layersAtOnce of [1, 3, 17]) {
      const { blocks, low, high } = rangesOf(counts, values, layersAtOnce);
      expect(blocks).toEqual([3, 1, 2]);
      for (let block = 0; block < samplesOf(blocks); ++block) {
        const at = [block % 3, 0, Math.floor(block / 3)];
        let [least, greatest] = [Infinity, -Infinity];
        for (let i = 0; i < values.length; ++i) {
          const place = [i % 19, Math.floor(i / 19) % 9, Math.floor(i / 171)];
          if (!place.every((p, axis) => p >= 8 * at[axis] && p <= 8 * at[axis] + 8)) continue;
          [least, greatest] = [Math.min(least, values[i]), Math.max(greatest, values[i])];
        }
        expect([low[block], high[block]]).toEqual([least, greatest]);
      }
    }
  });

  test("AreInvisibleWithoutValues", () => {
    const ranges = rangesOf([9, 9, 9], new Float32Array(729).fill(NaN), 9);
    const { image } = blockTexture({ ranges, rules: { range: [0, 1], isOfBytes: false, isOfIntegers: false } }, (low, high) => high >= low);
    expect([...(image.data as unknown as Uint8Array)]).toEqual([0, 0]);
  });
});

test("TexelRange.IsThatOfTheTypeForBytes", () => {
  expect(texelRange({ type: SampleType.U8, min: 7, max: 90 })).toEqual([0, 255]);
  expect(texelRange({ type: SampleType.I8, min: 7, max: 90 })).toEqual([-128, 127]);
  expect(texelRange({ type: SampleType.I16, min: -1000, max: 3000 })).toEqual([-1000, 3000]);
});

test("VolumePass.IsDrawnFinerAtRestOnceItIsKnownToBeFast", async () => {
  let [clock, frame] = [0, 20_000]; // Milliseconds.
  vi.spyOn(performance, "now").mockImplementation(() => (clock += frame));
  const renderer = { getContext: () => ({ fenceSync: () => null }) };
  const pass = new VolumePass(renderer as unknown as ConstructorParameters<typeof VolumePass>[0]);
  const camera = { matrixWorld: pass.object.matrixWorld, projectionMatrixInverse: pass.object.matrixWorld }; // Identities.
  const level = { step: 1, counts: [9, 9, 9] as Vec3 };
  const texture = { level, texture: null, rules: { range: [0, 1] }, ranges: new BlockRanges(level.counts) };
  pass.setSamples(texture as unknown as VolumeTexture, named("ct"));
  const scale = { map: "gray", low: 0, high: 1, isLog: false } as const;
  pass.setLook({ points: points([0, 0], [1, 0.5]), scale, isMaximum: false, isShaded: false, clip: [] });
  const draw = async (quality: "moving" | "resting") => {
    pass.begin(camera as Parameters<VolumePass["begin"]>[0], { width: 800, height: 600 }, quality);
    pass.end();
    await pass.measuring;
    return pass.isFinerAtRest;
  };
  await draw("moving");
  expect(await draw("resting")).toBe(false); // It is as slow as expected.
  frame = 10;
  expect(await draw("resting")).toBe(true);
  expect(await draw("resting")).toBe(false);
  vi.restoreAllMocks();
});

describe("Slab", () => {
  const counts: [number, number, number] = [3, 2, 1];
  const make = (values: Float32Array, range: [number, number], isOfIntegers = false) =>
    madeSlab({
      packed: { type: SampleType.UNSPECIFIED, bytes: new Uint8Array(values.buffer) },
      ...{ counts, row: 8, layer: 4, levelCounts: [3, 2, 20], texels: { range, isOfBytes: false, isOfIntegers } },
    });

  test("HasHalfFloatsOverTheRange", async () => {
    const { texels } = await make(Float32Array.of(-2, 0, 2, NaN, -1.9999, 1), [-2, 2]);
    expect([...texels]).toEqual([0, 0x3800, 0x3c00, 0xfbff, 420, 0x3a00]); // 420 / 2^24.
    const shareOf = (half: number) => (half < 0x400 ? half / 2 ** 24 : (1 + (half & 0x3ff) / 1024) * 2 ** ((half >> 10) - 15));
    for (let share = 0; share <= 1; share += 1 / 977) expect(Math.abs(shareOf(halfOf(share)) - share)).toBeLessThanOrEqual(share / 2048 + 2 ** -25);
  });

  test("HasNoValueWhereIntegersHaveNone", async () => {
    const values = Float32Array.of(3, 4, 5, NaN, 3, 5);
    expect([...(await make(values, [3, 5], true)).texels]).toEqual([...(await make(values, [3, 5])).texels]);
  });

  test("HasTheRangesOfItsBlocks", async () => {
    const { ranges } = await make(Float32Array.of(5, 1, 2, 3, 4, NaN), [0, 10]);
    expect(ranges).toEqual({ first: 0, low: Float32Array.of(1), high: Float32Array.of(5) });
    const all = new BlockRanges([3, 2, 20]);
    all.merge(ranges);
    expect([...all.high]).toEqual([5, -Infinity, -Infinity]);
  });
});
