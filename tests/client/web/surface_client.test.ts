import { Frames } from "../../../client/web/src/frames";
import { SurfaceClient } from "../../../client/web/src/surface_client";
import type { ClientKind, ServerKind } from "../../../client/web/src/protocol/messages";
import { defaults } from "../../../client/web/src/state/settings";
import type { Surface } from "../../../client/web/src/scene/surface";
import { Slots } from "../../../client/web/src/stream/slots";
import type { LinkEvents } from "../../../client/web/src/stream/link";
import type { TilePool } from "../../../client/web/src/workers/tile_pool";
import { dataset, messages } from "./golden_stream";

const [welcome, list, begin] = messages();

// A link whose other end is the test.
const link = vi.hoisted(() => ({ events: null as LinkEvents | null, sent: [] as ClientKind[], attempts: 0 }));
vi.mock("../../../client/web/src/stream/link", () => ({
  Link: class {
    constructor(_address: string, events: LinkEvents) {
      link.events = events;
    }
    connect() {
      ++link.attempts;
    }
    connectIn() {}
    send(message: ClientKind) {
      link.sent.push(message);
    }
  },
}));

function clientOf(token = "") {
  const nothing = () => {};
  const surface = { ids: () => [], dropUnused: nothing, use: nothing, release: nothing } as unknown as Surface;
  const pool = { forget: nothing } as unknown as TilePool;
  const frames = new Frames(() => true);
  const parts = { number: 1, address: "ws://server/v1/stream", token: () => token, pool, surface, frames, slots: new Slots(2) };
  const client = new SurfaceClient(parts, { offer: nothing, withdraw: nothing, shown: nothing, settled: nothing });
  client.lead();
  return client;
}

// The server takes the connection and tells what it has; what the client then says.
function accept(): string[] {
  link.sent.length = 0;
  link.events!.opened();
  link.events!.received(welcome);
  link.events!.received(list);
  return link.sent.map(({ case: kind }) => String(kind));
}

function streaming() {
  const client = clientOf();
  client.connect();
  accept();
  client.want(dataset(), { ...defaults, isovalue: 0.1, error: 0.5 }, null, { moment: { scene: "gyroid", time: null } });
  link.events!.received(begin);
  return client;
}

describe("SurfaceClient", () => {
  test("SaysThatNothingComesAnyMoreWhenTheServerIsLost", () => {
    const client = streaming();
    expect(client.progress.get()).toMatchObject({ phase: "ready", isStreaming: true });
    link.events!.closed();
    expect(client.progress.get()).toMatchObject({ phase: "lost", isStreaming: false });
    expect(client.progress.get().retryAt).toBeGreaterThan(performance.now());
  });

  test("RepeatsALostStreamAndAsksAgainHowLargeItWillBe", () => {
    const client = streaming();
    link.events!.closed();
    expect(accept()).toEqual(["hello", "listDatasets", "openStream", "estimate"]);
    expect(client.progress.get()).toMatchObject({ phase: "ready", isStreaming: true });
  });

  test("RepeatsItsStreamAlsoWhenTheUserConnectsAnew", () => {
    const client = streaming();
    client.connect();
    expect(client.progress.get()).toMatchObject({ phase: "connecting", isStreaming: false });
    expect(accept()).toContain("openStream");
  });

  test("ConnectsAnewAfterARefusalOnlyWhenTheUserSaysSo", () => {
    const client = clientOf("mt_wrong");
    client.connect();
    link.events!.opened();
    const refusal = { requestId: 0n, code: 13, text: "The token is none that this server knows." };
    link.events!.received({ case: "error", value: refusal } as ServerKind);
    link.events!.closed();
    const refused = client.progress.get();
    expect(refused.trouble).toEqual({ text: refusal.text, isFatal: true, needsToken: true });
    expect(refused.retryAt).toBe(0);
    const { attempts } = link;
    client.connect();
    expect(link.attempts).toBe(attempts + 1);
    expect(client.progress.get()).toMatchObject({ phase: "connecting", trouble: null });
  });
});
