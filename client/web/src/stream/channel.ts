// What a link exchanges messages through: the WebSocket of a server, or a worker of this page that reads files.
import { subprotocol } from "../protocol/messages";
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

// Throws if it is not an address, or if the page may not connect to it.
export function openChannel(address: string): Channel {
  return isOfFiles(address) ? new FileChannel(address) : new WebSocket(address, subprotocol);
}
