// A channel over the messages of a widget (of Jupyter, in anywidget's form): the kernel passes them on to a server.
//
//   page -> kernel   { channel, kind: "open" | "message" | "close" | "taken", bytes }     a message's content is its buffer
//   kernel -> page   { channel, kind: "message" | "closed" }
//
// The kernel stops sending while too many bytes were not "taken", as a socket would.
import type { Channel } from "../stream/channel";

export interface WidgetModel {
  get(name: string): unknown;
  set(name: string, value: unknown): void;
  save_changes(): void;
  on(event: string, listener: (...values: never[]) => void): void;
  send(content: unknown, callbacks?: unknown, buffers?: ArrayBuffer[]): void;
}

interface FromKernel {
  channel: number;
  kind: "message" | "closed";
}

export class KernelChannels {
  private readonly open = new Map<number, KernelChannel>();
  private last = 0;

  constructor(private readonly model: WidgetModel) {
    model.on("msg:custom", (content: FromKernel, buffers: (ArrayBuffer | DataView)[]) => {
      const channel = this.open.get(content.channel);
      if (!channel) return;
      if (content.kind === "closed") return this.end(content.channel);
      const [first] = buffers;
      const bytes = first instanceof ArrayBuffer ? first : first!.buffer.slice(first!.byteOffset, first!.byteOffset + first!.byteLength);
      channel.onmessage?.(new MessageEvent("message", { data: bytes }));
      this.send(content.channel, { kind: "taken", bytes: (bytes as ArrayBuffer).byteLength });
    });
  }

  channel(): Channel {
    const number = ++this.last;
    const channel = new KernelChannel(
      (bytes) => this.send(number, { kind: "message" }, [bytes]),
      () => {
        this.send(number, { kind: "close" });
        this.end(number);
      },
    );
    this.open.set(number, channel);
    this.send(number, { kind: "open" });
    queueMicrotask(() => channel.begin());
    return channel;
  }

  private end(number: number): void {
    const channel = this.open.get(number);
    this.open.delete(number);
    channel?.end();
  }

  private send(channel: number, content: object, buffers: ArrayBuffer[] = []): void {
    this.model.send({ channel, ...content }, undefined, buffers);
  }
}

class KernelChannel implements Channel {
  readyState: number = WebSocket.CONNECTING;
  binaryType: BinaryType = "arraybuffer";
  onopen: Channel["onopen"] = null;
  onclose: Channel["onclose"] = null;
  onmessage: Channel["onmessage"] = null;

  constructor(
    private readonly sendBytes: (bytes: ArrayBuffer) => void,
    private readonly requestEnd: () => void,
  ) {}

  begin(): void {
    if (this.readyState !== WebSocket.CONNECTING) return;
    this.readyState = WebSocket.OPEN;
    this.onopen?.(new Event("open"));
  }

  send(bytes: Uint8Array<ArrayBuffer>): void {
    this.sendBytes(bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.byteLength));
  }

  close(): void {
    if (this.readyState !== WebSocket.CLOSED) this.requestEnd();
  }

  end(): void {
    if (this.readyState === WebSocket.CLOSED) return;
    this.readyState = WebSocket.CLOSED;
    this.onclose?.(new CloseEvent("close"));
  }
}
