// Sends and receives messages through a channel, and connects again.
import { type ClientKind, decoded, encoded, type ServerKind } from "../protocol/messages";
import { type Channel, openChannel } from "./channel";

export interface LinkEvents {
  opened: () => void;
  received: (message: ServerKind) => void;
  progress?: (share: number) => void; // See Channel.onprogress.
  closed: () => void;
  // Called if this address cannot be connected to: it is not a WebSocket address, or the page may not use it.
  blocked: () => void;
}

export class Link {
  private channel: Channel | null = null;
  private timer = 0;
  private policyListener = new AbortController(); // Aborted with the channel.

  constructor(
    private readonly address: string,
    private readonly events: LinkEvents,
  ) {}

  connect(): void {
    this.close();
    let channel: Channel;
    try {
      channel = openChannel(this.address);
    } catch {
      this.events.blocked();
      return;
    }
    this.watchContentSecurityPolicy();
    channel.binaryType = "arraybuffer";
    const isCurrent = () => this.channel === channel;
    channel.onopen = () => isCurrent() && this.events.opened();
    channel.onclose = () => {
      if (!isCurrent()) return;
      this.channel = null;
      this.events.closed();
    };
    channel.onprogress = (share) => isCurrent() && this.events.progress?.(share);
    channel.onmessage = ({ data }) => {
      if (!isCurrent()) return;
      let message: ServerKind;
      try {
        if (!(data instanceof ArrayBuffer)) throw new Error("a text frame");
        message = decoded(new Uint8Array(data));
      } catch {
        channel.close(4000, "not a message of multitetra.v1");
        return;
      }
      this.events.received(message);
    };
    this.channel = channel;
  }

  connectIn(milliseconds: number): void {
    clearTimeout(this.timer);
    this.timer = window.setTimeout(() => this.connect(), milliseconds);
  }

  send(message: ClientKind): void {
    if (this.channel?.readyState === WebSocket.OPEN) {
      this.channel.send(encoded(message) as Uint8Array<ArrayBuffer>);
    }
  }

  // Closes the connection, if any.
  close(): void {
    clearTimeout(this.timer);
    const channel = this.channel;
    this.channel = null;
    this.policyListener.abort();
    channel?.close();
  }

  // A connection forbidden by the page's Content-Security-Policy looks like an unreachable server.
  private watchContentSecurityPolicy(): void {
    this.policyListener = new AbortController();
    const { signal } = this.policyListener;
    document.addEventListener(
      "securitypolicyviolation",
      ({ effectiveDirective }) => {
        if (effectiveDirective !== "connect-src") return;
        this.close();
        this.events.blocked();
      },
      { signal },
    );
  }
}
