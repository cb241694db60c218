import {
  create,
  ErrorCode,
  type OpenStream,
  Priority,
  SeriesMemberSchema,
  type ServerKind,
  type StepBegin,
  StepPolicy,
} from "../../../client/web/src/protocol/messages";
import { Conversation, type Effect } from "../../../client/web/src/stream/conversation";
import { dataset, messages, request } from "./golden_stream";

const [welcome, list, begin] = messages();

function sent(effects: Effect[]): string[] {
  return effects.flatMap((effect) => (effect.kind === "send" ? [String(effect.message.case)] : []));
}

function opened(effects: Effect[]) {
  const open = effects.find((e) => e.kind === "send" && e.message.case === "openStream");
  return (open as { message: { value: OpenStream } } | undefined)?.message.value;
}

function connected(held: string[] = []) {
  const conversation = new Conversation({ part: "test", token: () => "secret", cachedTiles: () => held });
  conversation.opened();
  conversation.received(welcome);
  conversation.received(list);
  return conversation;
}

describe("Conversation", () => {
  test("SendsHelloThenListDatasets", () => {
    const conversation = new Conversation({ part: "test", token: () => "", cachedTiles: () => [] });
    expect(sent(conversation.opened())).toEqual(["hello"]);
    expect(sent(conversation.received(welcome))).toEqual(["listDatasets"]);
    expect(conversation.received(list)).toMatchObject([{ kind: "datasets" }]);
  });

  test("ReadsAListInPages", () => {
    const conversation = new Conversation({ part: "test", token: () => "", cachedTiles: () => [] });
    conversation.opened();
    conversation.received(welcome);
    const page = (name: string, next: string) => ({ ...list, value: { ...list.value, datasets: [{ ...dataset(), name }], next } }) as ServerKind;
    const [following] = conversation.received(page("head", "head"));
    expect(following).toMatchObject({ kind: "send", message: { case: "listDatasets", value: { inPages: true, after: "head" } } });
    const [listed] = conversation.received(page("tooth", ""));
    expect(listed).toMatchObject({ kind: "datasets", datasets: [{ name: "head" }, { name: "tooth" }] });
    expect(conversation.received(page("head", "other"))).toMatchObject([{ kind: "failure", code: ErrorCode.DAMAGED_DATA }]);
  });

  test("RequestIdsIncrease", () => {
    const conversation = connected();
    const first = opened(conversation.request({ info: dataset(), isosurface: request() }))!;
    const second = opened(conversation.request({ info: dataset(), isosurface: request() }))!;
    expect(second.requestId > first.requestId).toBe(true);
  });

  test("ContinuesOnAHandedOverConnection", () => {
    const before = connected();
    const stream = { info: dataset(), isosurface: request() };
    const last = opened(before.request(stream))!.requestId;
    expect(before.handOver()).toBeNull(); // The stream is running.
    before.cancel();
    expect(before.handOver()).toBe(last);
    expect(before.handOver()).toBeNull(); // It has been handed over.
    const after = new Conversation({ part: "test", token: () => "secret", cachedTiles: () => [] });
    expect(after.handOver()).toBeNull();
    expect(after.request(stream)).toEqual([]); // It is not connected.
    const effects = after.adopted(last);
    expect(sent(effects)).toEqual(["openStream"]); // Without Hello.
    expect(opened(effects)!.requestId).toBe(last + 1n);
    expect(after.received({ ...begin, value: { ...begin.value, requestId: last } } as ServerKind)).toEqual([]); // A late message of the previous stream.
  });

  test("ChecksReceivedTilesAfterHandingOver", () => {
    const conversation = connected();
    conversation.request({ info: dataset(), isosurface: request() });
    const effects = messages()
      .slice(2)
      .map((message) => conversation.received(message));
    const decode = effects.flat().filter((one) => one.kind === "stream" && one.effect.kind === "decode");
    expect([decode.length > 0, conversation.isReceived]).toEqual([true, true]);
    expect(conversation.handOver()).not.toBeNull();
    const keys = decode.map((one) => (one as unknown as { effect: { tile: { key: string } } }).effect.tile.key);
    const after = keys.flatMap((key) => conversation.decoded(1, key));
    expect(after).toMatchObject([{ kind: "stream", effect: { kind: "check" } }]);
    conversation.request({ info: dataset(), isosurface: request() }); // Replaces the previous request.
    expect(conversation.decoded(1, keys[0])).toEqual([]);
  });

  test("RequestsACoarsePreviewOfALabel", () => {
    const openFor = (box: number[]) => {
      const info = { ...dataset(), member: create(SeriesMemberSchema, { series: "cells", label: { value: 3, box } }) };
      return opened(connected().request({ info, isosurface: request(), steps: "coarse" }))!;
    };
    expect(openFor([10, 10, 10, 29, 41, 26])).toMatchObject({
      // 17 samples along the shortest side.
      steps: StepPolicy.PREVIEWS_ONLY,
      resumedPreviews: [{ finestSpacing: 4, isUnsimplified: true }],
    });
    expect(openFor([0, 0, 0, 99, 99, 0]).resumedPreviews).toMatchObject([{ finestSpacing: 1 }]); // A thin box.
    expect(openFor([])).toMatchObject({ steps: StepPolicy.PREVIEWS_ONLY, resumedPreviews: [] }); // The box is unknown.
  });

  test("SendsTheMeasuredSpeed", () => {
    let trianglesPerSecond = 3e5;
    const conversation = new Conversation({
      part: "test",
      token: () => "",
      cachedTiles: () => [],
      trianglesPerSecond: () => trianglesPerSecond,
    });
    conversation.opened();
    conversation.received(welcome);
    conversation.received(list);
    const stream = () => ({ info: dataset(), isosurface: request() });
    expect(opened(conversation.request(stream()))!.trianglesPerSecond).toBe(3e5);
    trianglesPerSecond = 2e6;
    expect(opened(conversation.request(stream()))!.trianglesPerSecond).toBe(2e6);
    expect(opened(connected().request(stream()))!.trianglesPerSecond).toBe(0);
  });

  test("RepeatsUnfinishedStreamsWithCachedTiles", () => {
    const key = "00112233445566778899aabbccddeeff";
    const conversation = connected([key]);
    conversation.request({ info: dataset(), isosurface: request() });
    conversation.received(begin);
    expect(conversation.closed()).toMatchObject([{ phase: "lost", retryInMilliseconds: 500 }]);
    conversation.opened();
    conversation.received(welcome);
    const again = opened(conversation.received(list))!;
    expect(again.requestId).toBe(1n);
    const hexadecimal = Buffer.from(again.cachedTileDigests).toString("hex");
    expect(hexadecimal).toBe("7766554433221100" + "ffeeddccbbaa9988");
  });

  test("RepeatsExactlyTheBegunPreviews", () => {
    const golden = (begin as { value: StepBegin }).value;
    const repeated = (isFinal: boolean) => {
      const conversation = connected();
      conversation.request({ info: dataset(), isosurface: request() });
      conversation.received({ case: "stepBegin", value: { ...golden, isFinal } });
      conversation.closed();
      conversation.opened();
      conversation.received(welcome);
      const { resumedPreviews: begun, steps } = opened(conversation.received(list))!;
      return { steps, begun: begun.map(({ finestSpacing }) => finestSpacing) };
    };
    expect(repeated(false)).toEqual({ steps: StepPolicy.PROGRESSIVE, begun: [golden.finestSpacing] });
    expect(repeated(true)).toEqual({ steps: StepPolicy.FINAL_ONLY, begun: [] });
  });

  test("SendsBackgroundPriority", () => {
    const conversation = new Conversation({
      part: "test",
      token: () => "",
      cachedTiles: () => [],
      priority: Priority.BACKGROUND,
    });
    conversation.opened();
    conversation.received(welcome);
    conversation.received(list);
    const open = opened(conversation.request({ info: dataset(), isosurface: request() }))!;
    expect(open.priority).toBe(Priority.BACKGROUND);
  });

  test("RepeatsNoFinishedStream", () => {
    const conversation = connected();
    conversation.closed();
    conversation.opened();
    conversation.received(welcome);
    expect(opened(conversation.received(list))).toBeUndefined();
  });

  test("DoublesTheRetryDelayUpToALimit", () => {
    const conversation = new Conversation({ part: "test", token: () => "", cachedTiles: () => [] });
    const waits = Array.from({ length: 8 }, () => {
      const [effect] = conversation.closed();
      return effect.kind === "phase" ? effect.retryInMilliseconds! : NaN;
    });
    expect(waits).toEqual([500, 1000, 2000, 4000, 8000, 15000, 15000, 15000]);
  });

  test("QueriesOneSizeAtATimeThenTheLatest", () => {
    const conversation = connected();
    const stream = (isovalue: number) => ({ info: dataset(), isosurface: { ...request(), isovalue } });
    const query = (effects: Effect[]) => effects.flatMap((e) => (e.kind === "send" && e.message.case === "estimate" ? [e.message.value] : []))[0];
    const reply = (requestId: bigint) => ({
      case: "estimateReply",
      value: { requestId, triangles: 12n, bytes: 34n, errorBoundWorld: 0.5 },
    });
    const first = query(conversation.requestSize(stream(0.1)));
    expect(conversation.requestSize(stream(0.2))).toEqual([]);
    expect(conversation.requestSize(stream(0.3))).toEqual([]);
    const effects = conversation.received(reply(first.requestId) as ServerKind);
    expect(effects[0]).toMatchObject({ kind: "size", triangles: 12, bytes: 34, errorWorld: 0.5 });
    expect(query(effects).request!.isovalue).toBe(0.3);
    expect(conversation.received(reply(first.requestId) as ServerKind)).toEqual([]);
  });

  test("RefusedSizesDoNotEndTheStream", () => {
    const conversation = connected();
    const stream = opened(conversation.request({ info: dataset(), isosurface: request() }))!;
    const [query] = conversation.requestSize({ info: dataset(), isosurface: request() });
    const { requestId } = (query as { message: { value: { requestId: bigint } } }).message.value;
    expect(requestId > stream.requestId).toBe(true);
    const refusal = { case: "error", value: { requestId, code: 8, text: "Too many." } };
    expect(conversation.received(refusal as ServerKind)).toEqual([]);
    expect(conversation.received(begin)).toMatchObject([{ kind: "stream", effect: { kind: "begun" } }]);
    expect(conversation.cancel()).toMatchObject([{ message: { value: { requestId: stream.requestId } } }]);
  });

  test("ReportsRefusals", () => {
    const conversation = connected();
    conversation.request({ info: dataset(), isosurface: request() });
    const reply = { case: "error", value: { requestId: 1n, code: 6, text: "No dataset." } };
    expect(conversation.received(reply as ServerKind)).toMatchObject([{ kind: "stream", effect: { kind: "refused", text: "No dataset." } }]);
  });

  test("RepeatsPostponedRequests", () => {
    const conversation = connected();
    conversation.request({ info: dataset(), isosurface: request() });
    const reply = { case: "error", value: { requestId: 1n, code: 8, text: "Too many streams.", retryAfter: 2.5 } };
    expect(conversation.received(reply as ServerKind)).toEqual([{ kind: "postponed", text: "Too many streams.", inMilliseconds: 2500 }]);
    expect(opened(conversation.retryPostponed())).toMatchObject({ requestId: 2n, dataset: dataset().name });
    expect(conversation.retryPostponed()).toEqual([]); // It is running.
    conversation.cancel();
    expect(conversation.retryPostponed()).toEqual([]); // It was cancelled.
  });

  test("ReconnectsAfterTheDelayOfTheServer", () => {
    const conversation = connected();
    const error = (retryAfter: number) => ({ case: "error", value: { requestId: 0n, code: 12, text: "Draining.", retryAfter } });
    conversation.received(error(20) as ServerKind);
    expect(conversation.closed()).toEqual([{ kind: "phase", phase: "lost", retryInMilliseconds: 20_000 }]);
    conversation.received(error(1e300) as ServerKind);
    expect(conversation.closed()).toEqual([{ kind: "phase", phase: "lost", retryInMilliseconds: 600_000 }]);
    expect(conversation.closed()).toEqual([{ kind: "phase", phase: "lost", retryInMilliseconds: 2000 }]);
  });

  test("DoesNotRetryFatalErrors", () => {
    const conversation = connected();
    const reply = { case: "error", value: { requestId: 0n, code: 4, text: "No version." } };
    expect(conversation.received(reply as ServerKind)).toMatchObject([{ kind: "failure", isFatal: true }]);
    expect(conversation.closed()).toEqual([{ kind: "phase", phase: "lost" }]);
  });
});
