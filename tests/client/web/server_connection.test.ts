import { create, ErrorReplySchema, type ServerKind, WelcomeSchema } from "../../../client/web/src/protocol/messages";
import { ConnectionPool } from "../../../client/web/src/stream/connection_pool";
import { type ConnectionUser, ServerConnection } from "../../../client/web/src/stream/server_connection";
import { link } from "./mocked_link";

vi.mock("../../../client/web/src/stream/link", () => import("./mocked_link"));

const welcome: ServerKind = { case: "welcome", value: create(WelcomeSchema, { version: 1 }) };
const error = (code: number, retryAfter = 0): ServerKind => ({ case: "error", value: create(ErrorReplySchema, { code, text: "No.", retryAfter }) });
const user = (): ConnectionUser => ({ ready: vi.fn(), received: vi.fn(), lost: vi.fn() });

function used() {
  link.sent.length = link.waits.length = link.attempts = 0;
  const connection = new ServerConnection("ws://server/v1/stream", () => "secret", "test");
  connection.use(user());
  const events = link.all.at(-1)!;
  events.opened();
  return { connection, events };
}

describe("ServerConnection", () => {
  test("GreetsAndIsReady", () => {
    const { connection, events } = used();
    expect(link.sent).toMatchObject([{ case: "hello", value: { token: "secret" } }]);
    expect(connection.isReady).toBe(false);
    events.received(welcome);
    expect(connection.state.get()).toMatchObject({ phase: "ready", failure: null });
  });

  test("DoublesTheRetryDelayUpToALimit", () => {
    const { events } = used();
    for (let i = 0; i < 8; ++i) events.closed();
    expect(link.waits).toEqual([500, 1000, 2000, 4000, 8000, 15000, 15000, 15000]);
  });

  test("ReconnectsAfterTheDelayOfTheServer", () => {
    const { events } = used();
    events.received(error(12, 20));
    events.received(error(12, 1e300));
    events.closed();
    expect(link.waits).toEqual([20_000, 600_000, 2000]);
  });

  test("DoesNotRetryFatalErrorsByItself", () => {
    const { connection, events } = used();
    events.received(error(13));
    expect(connection.state.get()).toMatchObject({ phase: "lost", retryAt: 0, failure: { text: "No.", isFatal: true, needsToken: true } });
    expect(link.waits).toEqual([]);
    connection.connect();
    expect([link.attempts, connection.state.get().failure]).toEqual([2, null]);
  });
});

describe("ConnectionPool", () => {
  test("SharesAFewConnections", () => {
    link.sent.length = 0;
    const pool = new ConnectionPool(() => new ServerConnection("ws://server/v1/stream", () => "", ""), 2);
    const [one, two, three] = [user(), user(), user()];
    const before = link.all.length;
    for (const each of [one, two, three]) pool.request(each);
    expect(link.all.length).toBe(before + 2);
    for (const events of link.all.slice(before)) events.received(welcome);
    expect([one, two, three].map(({ ready }) => vi.mocked(ready).mock.calls.length)).toEqual([1, 1, 0]);
    pool.release(two);
    expect(vi.mocked(three.ready).mock.calls).toEqual(vi.mocked(two.ready).mock.calls); // The same connection, open as it is.
    link.all[before].closed();
    link.all[before].received(welcome);
    expect([vi.mocked(one.lost).mock.calls.length, vi.mocked(one.ready).mock.calls.length]).toEqual([1, 2]);
  });

  test("ConnectsForTheFirstUser", () => {
    const pool = new ConnectionPool(() => new ServerConnection("ws://server/v1/stream", () => "", ""), 2);
    const before = link.attempts;
    pool.connect();
    link.all.at(-1)!.received(welcome);
    const one = user();
    pool.request(one);
    expect([link.attempts - before, vi.mocked(one.ready).mock.calls.length]).toEqual([1, 1]);
  });
});
