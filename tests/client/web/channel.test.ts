import { openChannel, openEarly } from "../../../client/web/src/stream/channel";

class Socket {
  static readonly OPEN = 1;
  static made: Socket[] = [];
  readyState = 0;
  onopen: (() => void) | null = null;

  constructor(
    readonly address: string,
    readonly protocol: string,
  ) {
    Socket.made.push(this);
  }
}

vi.stubGlobal("WebSocket", Socket);
beforeEach(() => (Socket.made = []));

describe("Channel", () => {
  test("OpenedEarlyIsTheNextOneOfItsAddress", async () => {
    openEarly("ws://server/v1/stream");
    const [early] = Socket.made;
    early.readyState = 1;
    const channel = openChannel("ws://server/v1/stream");
    expect(channel).toBe(early);
    const opened = vi.fn();
    channel.onopen = opened; // After it was opened.
    await Promise.resolve();
    expect(opened).toHaveBeenCalledOnce();
    expect(openChannel("ws://server/v1/stream")).not.toBe(early);
  });

  test("OpenedEarlyIsNotUsedForOthersOrWhenClosed", () => {
    openEarly("ws://server/v1/stream");
    expect(openChannel("ws://other/v1/stream")).not.toBe(Socket.made[0]);
    openEarly("ws://server/v1/stream");
    Socket.made[2].readyState = 3;
    expect(openChannel("ws://server/v1/stream")).toBe(Socket.made[3]);
    expect(Socket.made[3].protocol).toBe("multitetra.v1");
  });
});
