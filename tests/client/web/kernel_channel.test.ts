// The viewer's connection through the kernel of a notebook.
import { KernelChannels, type WidgetModel } from "../../../client/web/src/notebook/kernel_channel";

vi.stubGlobal("WebSocket", { CONNECTING: 0, OPEN: 1, CLOSED: 3 });
vi.stubGlobal("CloseEvent", Event);

interface Sent {
  content: { channel: number; kind: string; bytes?: number };
  bytes: number[];
}

function notebook() {
  const sent: Sent[] = [];
  let hear: (content: unknown, buffers: unknown[]) => void = () => {};
  const model = {
    on: (_: string, listener: typeof hear) => (hear = listener),
    send: (content: Sent["content"], _: unknown, buffers: ArrayBuffer[]) =>
      sent.push({ content, bytes: [...new Uint8Array(buffers[0] ?? new ArrayBuffer(0))] }),
  };
  const channels = new KernelChannels(model as unknown as WidgetModel);
  return { channels, sent, hear: (content: unknown, buffers: unknown[] = []) => hear(content, buffers) };
}

test("KernelChannels.SendBytesAndAcknowledgeWhatTheyTake", async () => {
  const { channels, sent, hear } = notebook();
  const channel = channels.channel();
  const received: number[][] = [];
  channel.onmessage = ({ data }) => received.push([...new Uint8Array(data as ArrayBuffer)]);
  await new Promise<void>((resolve) => (channel.onopen = () => resolve()));
  channel.send(new Uint8Array([0, 1, 2, 3]).subarray(1, 3) as Uint8Array<ArrayBuffer>);
  hear({ channel: 1, kind: "message" }, [new DataView(new Uint8Array([9, 8, 7, 6]).buffer, 1, 2)]);
  hear({ channel: 1, kind: "message" }, [new Uint8Array([5]).buffer]);
  hear({ channel: 2, kind: "message" }, [new ArrayBuffer(1)]); // Of a channel that was closed.
  expect(received).toEqual([[8, 7], [5]]);
  expect(sent.map(({ content }) => [content.kind, content.bytes])).toEqual([
    ["open", undefined],
    ["message", undefined],
    ["taken", 2],
    ["taken", 1],
  ]);
  expect(sent[1]!.bytes).toEqual([1, 2]);
});

test("KernelChannels.CloseOnceFromEitherEnd", async () => {
  const { channels, sent, hear } = notebook();
  for (const end of ["page", "kernel"]) {
    sent.length = 0;
    const channel = channels.channel();
    let closed = 0;
    channel.onclose = () => ++closed;
    await new Promise<void>((resolve) => (channel.onopen = () => resolve()));
    if (end === "page") channel.close();
    else hear({ channel: sent[0]!.content.channel, kind: "closed" });
    channel.close();
    expect(closed).toBe(1);
    expect(channel.readyState).toBe(WebSocket.CLOSED);
    expect(sent.filter(({ content }) => content.kind === "close").length).toBe(end === "page" ? 1 : 0);
  }
});
