// What a link exchanges messages through: the WebSocket of a server, a worker of this page that reads files, or what the
// page that embeds the viewer offers, such as the kernel's connection of a notebook.
import { FileChannel, isOfFiles } from "../static/file_channel";

export interface Channel {
  readonly readyState: number;
  binaryType: BinaryType;
  onopen: ((event: Event) => void) | null;
  onclose: ((event: CloseEvent) => void) | null;
  onprogress?: ((share: number) => void) | null; // The part of the next step that is read; of files alone.
  onmessage: ((event: MessageEvent) => void) | null;
  send(bytes: Uint8Array<ArrayBuffer>): void; // The bytes are the channel's.
  close(code?: number, reason?: string): void;
}

const subprotocol = "multitetra.v1";
const ofPage = new Map<string, (address: string) => Channel>();
let early: { address: string; channel: Channel } | null = null;

// Addresses that begin with `scheme`, such as "kernel:", are opened by the page.
export function offerChannels(scheme: string, open: (address: string) => Channel): void {
  ofPage.set(scheme, open);
}

// Opens a channel before it is needed: connecting takes as long as loading the rest of the page. The next openChannel() with
// this address returns it.
export function openEarly(address: string): void {
  early = { address, channel: openChannel(address) };
}

// Throws if it is not an address, or if the page may not connect to it.
export function openChannel(address: string): Channel {
  const channel = early?.address === address ? early.channel : null;
  early = null;
  if (!channel || channel.readyState > WebSocket.OPEN) return newChannel(address);
  if (channel.readyState === WebSocket.OPEN) queueMicrotask(() => channel.onopen?.(new Event("open")));
  return channel;
}

function newChannel(address: string): Channel {
  const open = ofPage.get(address.slice(0, address.indexOf(":") + 1));
  if (open) return open(address);
  return isOfFiles(address) ? new FileChannel(address) : new WebSocket(address, subprotocol);
}
