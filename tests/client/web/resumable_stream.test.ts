import { create, type OpenStream, Priority, SeriesMemberSchema, type ServerKind, type StepBegin, StepPolicy } from "../../../client/web/src/protocol/messages";
import { ResumableStream, type StreamEffect } from "../../../client/web/src/stream/resumable_stream";
import { dataset, messages, request } from "./golden_stream";

const [, , begin] = messages();
const wanted = () => ({ info: dataset(), isosurface: request() });

function opened(effects: StreamEffect[]): OpenStream {
  const [open] = effects;
  return (open as unknown as { message: { value: OpenStream } }).message.value;
}

// A stream with the request id 1.
function running(cached: string[] = []) {
  const stream = new ResumableStream({ cachedTiles: () => cached });
  stream.request(wanted());
  stream.open(1n);
  return stream;
}

describe("ResumableStream", () => {
  test("IgnoresLateMessagesOfThePreviousOne", () => {
    const stream = running();
    stream.request(wanted());
    expect(opened(stream.open(2n)).requestId).toBe(2n);
    expect(stream.received(begin)).toEqual([]);
    expect(stream.received({ ...begin, value: { ...begin.value, requestId: 2n } } as ServerKind)).toMatchObject([{ kind: "begun" }]);
  });

  test("NeedsNoConnectionWhenReceived", () => {
    const stream = running();
    expect([stream.isRunning, stream.isReceived, stream.isWaiting]).toEqual([true, false, false]);
    const effects = messages()
      .slice(2)
      .map((message) => stream.received(message));
    expect([stream.isRunning, stream.isReceived, stream.isWaiting]).toEqual([false, true, false]);
    const keys = effects.flat().flatMap((effect) => (effect.kind === "decode" ? [effect.tile.key] : []));
    expect(keys.length).toBeGreaterThan(0);
    const { number } = stream;
    expect(keys.flatMap((key) => stream.decoded(number, key))).toMatchObject([{ kind: "check" }]);
    stream.request(wanted()); // Replaces the previous request.
    expect([stream.isWaiting, stream.decoded(number, keys[0])]).toEqual([true, []]);
  });

  test("RequestsACoarsePreviewOfALabel", () => {
    const openFor = (box: number[]) => {
      const info = { ...dataset(), member: create(SeriesMemberSchema, { series: "cells", label: { value: 3, box } }) };
      const stream = new ResumableStream({ cachedTiles: () => [] });
      stream.request({ info, isosurface: request(), steps: "coarse" });
      return opened(stream.open(1n));
    };
    expect(openFor([10, 10, 10, 29, 41, 26])).toMatchObject({
      // 17 samples along the shortest side.
      steps: StepPolicy.PREVIEWS_ONLY,
      resumedPreviews: [{ finestSpacing: 4, isUnsimplified: true }],
    });
    expect(openFor([0, 0, 0, 99, 99, 0]).resumedPreviews).toMatchObject([{ finestSpacing: 1 }]); // A thin box.
    expect(openFor([])).toMatchObject({ steps: StepPolicy.PREVIEWS_ONLY, resumedPreviews: [] }); // The box is unknown.
  });

  test("SendsTheMeasuredSpeedAndItsPriority", () => {
    let trianglesPerSecond = 3e5;
    const stream = new ResumableStream({ cachedTiles: () => [], trianglesPerSecond: () => trianglesPerSecond, priority: Priority.BACKGROUND });
    stream.request(wanted());
    expect(opened(stream.open(1n))).toMatchObject({ trianglesPerSecond: 3e5, priority: Priority.BACKGROUND });
    trianglesPerSecond = 2e6;
    expect(opened(stream.open(2n)).trianglesPerSecond).toBe(2e6);
  });

  test("IsRepeatedWithCachedTiles", () => {
    const stream = running(["00112233445566778899aabbccddeeff"]);
    stream.received(begin);
    stream.lost();
    expect(stream.isWaiting).toBe(true);
    const hexadecimal = Buffer.from(opened(stream.open(1n)).cachedTileDigests).toString("hex");
    expect(hexadecimal).toBe("7766554433221100" + "ffeeddccbbaa9988");
  });

  test("RepeatsExactlyTheBegunPreviews", () => {
    const golden = (begin as { value: StepBegin }).value;
    const repeated = (isFinal: boolean) => {
      const stream = running();
      stream.received({ case: "stepBegin", value: { ...golden, isFinal } });
      stream.lost();
      const { resumedPreviews: begun, steps } = opened(stream.open(1n));
      return { steps, begun: begun.map(({ finestSpacing }) => finestSpacing) };
    };
    expect(repeated(false)).toEqual({ steps: StepPolicy.PROGRESSIVE, begun: [golden.finestSpacing] });
    expect(repeated(true)).toEqual({ steps: StepPolicy.FINAL_ONLY, begun: [] });
  });

  test("IsNotRepeatedAfterItsEnd", () => {
    const stream = running();
    const reply = { case: "error", value: { requestId: 1n, code: 6, text: "No dataset." } };
    expect(stream.received(reply as ServerKind)).toMatchObject([{ kind: "refused", text: "No dataset." }]);
    stream.lost();
    expect(stream.isWaiting).toBe(false);
  });

  test("IsRepeatedWhenPostponed", () => {
    const stream = running();
    const reply = { case: "error", value: { requestId: 1n, code: 8, text: "Too many streams.", retryAfter: 2.5 } };
    expect(stream.received(reply as ServerKind)).toEqual([{ kind: "postponed", text: "Too many streams.", inMilliseconds: 2500 }]);
    expect([stream.isWaiting, stream.isReceived]).toEqual([true, false]);
    expect(opened(stream.open(2n))).toMatchObject({ requestId: 2n, dataset: dataset().name });
    expect(stream.isWaiting).toBe(false);
    expect(stream.cancel()).toMatchObject([{ kind: "send", message: { case: "cancel", value: { requestId: 2n } } }]);
    expect(stream.isWaiting).toBe(false);
  });
});
