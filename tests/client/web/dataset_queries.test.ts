import {
  create,
  ErrorCode,
  ErrorReplySchema,
  type ListDatasets,
  PongSchema,
  type ServerKind,
  type Slice,
  SliceReplySchema,
  WelcomeSchema,
} from "../../../client/web/src/protocol/messages";
import { DatasetQueries } from "../../../client/web/src/stream/dataset_queries";
import { dataset, messages, request } from "./golden_stream";
import { link } from "./mocked_link";

vi.mock("../../../client/web/src/stream/link", () => import("./mocked_link"));
vi.stubGlobal("window", globalThis); // Provides its timers.

const grid = { origin: [0, 0, 0] as const, right: [1, 0, 0] as const, down: [0, 1, 0] as const, width: 1, height: 1 };
const send = (message: ServerKind) => link.all.at(-1)!.received(message);
const welcome = () => send({ case: "welcome", value: create(WelcomeSchema, { version: 1 }) });
const fail = (code: ErrorCode) =>
  send({ case: "error", value: create(ErrorReplySchema, { requestId: 0n, code, text: "The first message did not arrive in time." }) });
const slices = () => link.sent.filter((one) => one.case === "slice").map(({ value }) => value as Slice);
const listId = () => (link.sent.filter((one) => one.case === "listDatasets").at(-1)!.value as ListDatasets).requestId;
const page = (requestId: bigint, name: string, next: string) => {
  const [, list] = messages() as { value: object }[];
  send({ ...list, value: { ...list.value, requestId, datasets: [{ ...dataset(), name }], next } } as ServerKind);
};

function withQueries() {
  link.sent.length = link.waits.length = 0;
  const queries = new DatasetQueries("ws://server/v1/stream", () => "");
  queries.connect();
  const slice = queries.slice("head", { ...grid, origin: [...grid.origin], right: [...grid.right], down: [...grid.down] });
  return { queries, slice };
}

describe("DatasetQueries", () => {
  test("AreRepeatedAfterALateHello", async () => {
    const { slice } = withQueries();
    fail(ErrorCode.UNAVAILABLE); // The page was too busy to send it.
    expect(link.waits).toEqual([500]);
    link.all.at(-1)!.opened();
    welcome();
    const [{ requestId }] = slices();
    send({ case: "sliceReply", value: create(SliceReplySchema, { requestId, width: 1, height: 1, sampleSpacing: 1, values: new Uint8Array(4) }) });
    expect((await slice).values).toEqual(new Float32Array([0]));
  });

  test("AreRepeatedAfterLostConnections", () => {
    withQueries();
    welcome();
    expect(slices().length).toBe(1);
    link.all.at(-1)!.closed();
    link.all.at(-1)!.closed();
    welcome();
    expect([slices().length, link.waits]).toEqual([2, [500, 1000]]);
  });

  test("FailIfEachReplyEndsTheConnection", async () => {
    const { slice } = withQueries();
    const failed = expect(slice).rejects.toThrow("connection was lost each time");
    for (let attempt = 0; attempt < 5; ++attempt) {
      welcome();
      link.all.at(-1)!.closed();
    }
    await failed;
    expect(slices().length).toBe(5);
  });

  test("FailIfTheTokenIsRefused", async () => {
    const { slice } = withQueries();
    fail(ErrorCode.UNAUTHENTICATED);
    await expect(slice).rejects.toThrow("first message");
    expect(link.waits).toEqual([]);
  });

  test("ListDatasetsInPages", () => {
    const { queries } = withQueries();
    welcome();
    const first = listId();
    page(first, "head", "head");
    expect(link.sent.at(-1)).toMatchObject({ case: "listDatasets", value: { inPages: true, after: "head" } });
    page(first, "tooth", "");
    expect(queries.datasets.get().list).toMatchObject([{ name: "head" }, { name: "tooth" }]);
    page(first, "head", "other");
    expect(queries.connection.state.get().failure?.text).toContain("does not end");
  });

  test("IgnorePagesOfAListThatHasChangedAgain", () => {
    const { queries } = withQueries();
    welcome();
    const first = listId();
    page(first, "head", "head");
    send({ case: "pong", value: create(PongSchema, { hasNewList: true }) });
    const second = listId();
    page(first, "removed", "");
    expect(queries.datasets.get().list).toBeNull();
    page(second, "head", "");
    expect(queries.datasets.get().list).toMatchObject([{ name: "head" }]);
  });

  test("RequestARefusedListAgain", () => {
    const { queries } = withQueries();
    welcome();
    send({ case: "error", value: create(ErrorReplySchema, { requestId: listId(), code: ErrorCode.UNAVAILABLE, text: "The server is reading its datasets." }) });
    expect(queries.connection.state.get().failure?.text).toBe("The server is reading its datasets.");
    queries.checkList();
    page(listId(), "head", "");
    expect([queries.connection.state.get().failure, queries.datasets.get().list?.length]).toEqual([null, 1]);
  });

  test("EstimateSizes", async () => {
    const { queries } = withQueries();
    welcome();
    const size = queries.estimate("head", request());
    const { requestId } = link.sent.at(-1)!.value as { requestId: bigint };
    send({ case: "estimateReply", value: { requestId, triangles: 12n, bytes: 34n, errorBoundWorld: 0.5 } } as ServerKind);
    expect(await size).toMatchObject({ triangles: 12n, bytes: 34n, errorBoundWorld: 0.5 });
    const refused = queries.estimate("head", request());
    send({ case: "error", value: create(ErrorReplySchema, { requestId: requestId + 1n, text: "Too many." }) });
    await expect(refused).rejects.toThrow("Too many.");
  });
});
