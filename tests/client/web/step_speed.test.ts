import { StepSpeed } from "../../../client/web/src/stream/step_speed";

describe("StepSpeed", () => {
  test("FollowsMeasuredSteps", () => {
    const speed = new StepSpeed();
    expect(speed.trianglesPerSecond).toBeGreaterThan(0);
    for (let i = 0; i < 20; ++i) speed.record(100_000, 50);
    expect(speed.trianglesPerSecond).toBeCloseTo(2_000_000, -4);
    for (let i = 0; i < 20; ++i) speed.record(100_000, 1000);
    expect(speed.trianglesPerSecond).toBeCloseTo(100_000, -4);
  });

  test("IgnoresSmallSteps", () => {
    const speed = new StepSpeed();
    const atFirst = speed.trianglesPerSecond;
    speed.record(100, 1000);
    speed.record(100_000, 0);
    speed.record(100_000, NaN);
    expect(speed.trianglesPerSecond).toBe(atFirst);
  });
});
