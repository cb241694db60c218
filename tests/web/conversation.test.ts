import { Conversation, type Effect } from "../../client/web/src/stream/conversation";
import type { ServerKind } from "../../client/web/src/protocol/messages";
import { dataset, messages, request } from "./golden_stream";

const [welcome, list, begin] = messages();

function sent(effects: Effect[]): string[] {
  return effects.flatMap((effect) => (effect.kind === "send" ? [String(effect.message.case)] : []));
}

function opened(effects: Effect[]) {
  const open = effects.find((e) => e.kind === "send" && e.message.case === "openStream");
  return (open as { message: { value: { requestId: bigint; held: Uint8Array } } } | undefined)?.message.value;
}

function connected(held: string[] = []) {
  const conversation = new Conversation({ agent: "test", token: () => "secret", held: () => held });
  conversation.opened();
  conversation.received(welcome);
  conversation.received(list);
  return conversation;
}

describe("Conversation", () => {
  test("SaysHelloFirstAndAsksForTheListThen", () => {
    const conversation = new Conversation({ agent: "test", token: () => "", held: () => [] });
    expect(sent(conversation.opened())).toEqual(["hello"]);
    expect(sent(conversation.received(welcome))).toEqual(["listDatasets"]);
    expect(conversation.received(list)).toMatchObject([{ kind: "datasets" }]);
  });

  test("GivesEveryStreamAGreaterId", () => {
    const conversation = connected();
    const first = opened(conversation.want({ info: dataset(), request: request() }))!;
    const second = opened(conversation.want({ info: dataset(), request: request() }))!;
    expect(second.requestId > first.requestId).toBe(true);
  });

  test("RepeatsAnUnfinishedStreamAfterALostConnectionAndNamesWhatItHolds", () => {
    const key = "00112233445566778899aabbccddeeff";
    const conversation = connected([key]);
    conversation.want({ info: dataset(), request: request() });
    conversation.received(begin);
    expect(conversation.closed()).toMatchObject([{ phase: "lost", retryInMilliseconds: 500 }]);
    conversation.opened();
    conversation.received(welcome);
    const again = opened(conversation.received(list))!;
    expect(again.requestId).toBe(1n);
    const hexadecimal = Buffer.from(again.held).toString("hex");
    expect(hexadecimal).toBe("7766554433221100" + "ffeeddccbbaa9988");
  });

  test("AsksForNothingAgainWhenNothingWasUnderWay", () => {
    const conversation = connected();
    conversation.closed();
    conversation.opened();
    conversation.received(welcome);
    expect(opened(conversation.received(list))).toBeUndefined();
  });

  test("WaitsLongerFromAttemptToAttemptButNotForever", () => {
    const conversation = new Conversation({ agent: "test", token: () => "", held: () => [] });
    const waits = Array.from({ length: 8 }, () => {
      const [effect] = conversation.closed();
      return effect.kind === "phase" ? effect.retryInMilliseconds! : NaN;
    });
    expect(waits).toEqual([500, 1000, 2000, 4000, 8000, 15000, 15000, 15000]);
  });

  test("PassesARefusalOn", () => {
    const conversation = connected();
    conversation.want({ info: dataset(), request: request() });
    const reply = { case: "error", value: { requestId: 1n, code: 6, text: "No dataset." } };
    expect(conversation.received(reply as ServerKind)).toMatchObject([
      { kind: "stream", effect: { kind: "refused", text: "No dataset." } },
    ]);
  });

  test("DoesNotInsistWhereTheServerWillNeverAgree", () => {
    const conversation = connected();
    const reply = { case: "error", value: { requestId: 0n, code: 4, text: "No version." } };
    expect(conversation.received(reply as ServerKind)).toMatchObject([{ kind: "trouble", isFatal: true }]);
    expect(conversation.closed()).toEqual([{ kind: "phase", phase: "lost" }]);
  });
});
