// The way that the messages of a Link take: like a WebSocket, the only one so far.
import { subprotocol } from "../protocol/messages";

export type Channel = Pick<WebSocket, "readyState" | "binaryType" | "send" | "close" | "onopen" | "onclose" | "onmessage">;

// Throws if it is not an address, or if the page may not connect to it.
export function openChannel(address: string): Channel {
  return new WebSocket(address, subprotocol);
}
