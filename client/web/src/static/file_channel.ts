// A channel to this page's own worker, which reads prepared files of a web server: "static:" and the address of a file or
// an index.
import type { Channel } from "../stream/channel";

const scheme = "static:";

export interface ChannelRequest {
  address: string;
  port: MessagePort;
}

// What the worker begins with: its name says so, since messages wait until the page has time.
export interface FirstRead {
  address: string;
  dataset: string; // That the page will request, as far as its address says; empty: the first one.
}

let worker: Worker | null = null;
const open = new Set<FileChannel>();

export function isOfFiles(address: string): boolean {
  return address.startsWith(scheme);
}

export function addressOfFiles(file: string): string {
  return scheme + new URL(file, location.href).href;
}

export class FileChannel implements Channel {
  readyState: number = WebSocket.CONNECTING;
  binaryType: BinaryType = "arraybuffer";
  onopen: Channel["onopen"] = null;
  onclose: Channel["onclose"] = null;
  onmessage: Channel["onmessage"] = null;
  onprogress: Channel["onprogress"] = null;
  private readonly port: MessagePort;

  // Throws if it is no address.
  constructor(address: string) {
    const { port1, port2 } = new MessageChannel();
    const request: ChannelRequest = { address: new URL(address.slice(scheme.length)).href, port: port2 };
    startedWorker(request.address).postMessage(request, [port2]);
    this.port = port1;
    this.port.onmessage = (event: MessageEvent) => (typeof event.data === "number" ? this.onprogress?.(event.data) : this.onmessage?.(event));
    open.add(this);
    queueMicrotask(() => {
      if (this.readyState !== WebSocket.CONNECTING) return;
      this.readyState = WebSocket.OPEN;
      this.onopen?.(new Event("open"));
    });
  }

  send(bytes: Uint8Array<ArrayBuffer>): void {
    this.port.postMessage(bytes.buffer, [bytes.buffer]);
  }

  close(): void {
    if (this.readyState === WebSocket.CLOSED) return;
    this.readyState = WebSocket.CLOSED;
    open.delete(this);
    this.port.postMessage(null);
    this.onclose?.(new CloseEvent("close"));
  }
}

// The worker ends with an error when there is no memory; then all channels are lost.
function startedWorker(address: string): Worker {
  if (worker) return worker;
  const first: FirstRead = { address, dataset: new URLSearchParams(location.hash.slice(1)).get("dataset") ?? "" };
  worker = new Worker(new URL("./file_worker.ts", import.meta.url), { type: "module", name: JSON.stringify(first) });
  worker.onerror = () => {
    worker?.terminate();
    worker = null;
    for (const channel of [...open]) channel.close();
  };
  return worker;
}
