import {
  type ClientKind,
  create,
  ErrorCode,
  ErrorReplySchema,
  type ServerKind,
  type Slice,
  SliceReplySchema,
  WelcomeSchema,
} from "../../../client/web/src/protocol/messages";
import { DatasetQueries } from "../../../client/web/src/stream/dataset_queries";
import type { LinkEvents } from "../../../client/web/src/stream/link";

// A link whose other end is the test.
const link = vi.hoisted(() => ({ events: null as LinkEvents | null, sent: [] as ClientKind[], waits: [] as number[] }));
vi.mock("../../../client/web/src/stream/link", () => ({
  Link: class {
    constructor(_address: string, events: LinkEvents) {
      link.events = events;
    }
    connect() {}
    connectIn(milliseconds: number) {
      link.waits.push(milliseconds);
    }
    close() {}
    send(message: ClientKind) {
      link.sent.push(message);
    }
  },
}));

const grid = { origin: [0, 0, 0] as const, right: [1, 0, 0] as const, down: [0, 1, 0] as const, width: 1, height: 1 };
const send = (message: ServerKind) => link.events!.received(message);
const welcome = () => send({ case: "welcome", value: create(WelcomeSchema, { version: 1 }) });
const fail = (code: ErrorCode) =>
  send({ case: "error", value: create(ErrorReplySchema, { requestId: 0n, code, text: "The first message did not arrive in time." }) });
const slices = () => link.sent.filter((one) => one.case === "slice").map(({ value }) => value as Slice);

function withQueries() {
  link.sent.length = link.waits.length = 0;
  const notices: string[] = [];
  const queries = new DatasetQueries(
    "ws://server/v1/stream",
    () => "",
    (text) => notices.push(text),
  );
  const slice = queries.slice("head", { ...grid, origin: [...grid.origin], right: [...grid.right], down: [...grid.down] });
  return { queries, slice, notices };
}

describe("DatasetQueries", () => {
  test("AreRepeatedAfterALateHello", async () => {
    const { slice, notices } = withQueries();
    fail(ErrorCode.UNAVAILABLE); // The page was too busy to send it.
    expect([link.waits, notices]).toEqual([[500], []]);
    link.events!.opened();
    welcome();
    const [{ requestId }] = slices();
    send({ case: "sliceReply", value: create(SliceReplySchema, { requestId, width: 1, height: 1, sampleSpacing: 1, values: new Uint8Array(4) }) });
    expect((await slice).values).toEqual(new Float32Array([0]));
  });

  test("AreRepeatedAfterLostConnectionsAndAnnounced", () => {
    const { notices } = withQueries();
    welcome();
    expect(slices().length).toBe(1);
    link.events!.closed();
    link.events!.closed();
    welcome();
    expect([slices().length, link.waits]).toEqual([2, [500, 1000]]);
    expect(notices).toEqual(["The server did not answer; trying again."]);
  });

  test("FailIfEachReplyEndsTheConnection", async () => {
    const { slice } = withQueries();
    const failed = expect(slice).rejects.toThrow("connection was lost each time");
    for (let attempt = 0; attempt < 5; ++attempt) {
      welcome();
      link.events!.closed();
    }
    await failed;
    expect([slices().length, link.waits.length]).toEqual([5, 4]);
  });

  test("FailIfTheTokenIsRefused", async () => {
    const { slice } = withQueries();
    fail(ErrorCode.UNAUTHENTICATED);
    await expect(slice).rejects.toThrow("first message");
    expect(link.waits).toEqual([]);
  });
});
