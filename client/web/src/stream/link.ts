// The WebSocket of a conversation: sends and receives messages, reconnects.
import { type ClientKind, decoded, encoded, type ServerKind, subprotocol } from "../protocol/messages";

export interface LinkEvents {
  opened: () => void;
  received: (message: ServerKind) => void;
  closed: () => void;
  // Called if this address cannot be connected to: it is not a WebSocket address, or the page may not use it.
  blocked: () => void;
}

export class Link {
  private socket: WebSocket | null = null;
  private timer = 0;
  private policyListener = new AbortController(); // Aborted with the socket.

  constructor(
    private readonly address: string,
    private readonly events: LinkEvents,
  ) {}

  connect(): void {
    this.close();
    let socket: WebSocket;
    try {
      socket = new WebSocket(this.address, subprotocol);
    } catch {
      this.events.blocked();
      return;
    }
    this.watchContentSecurityPolicy();
    socket.binaryType = "arraybuffer";
    this.use(socket);
  }

  // Takes over an open connection from another link.
  adopt(socket: WebSocket): void {
    this.close();
    this.watchContentSecurityPolicy();
    this.use(socket);
  }

  // Releases the connection without closing it; null if none is open.
  handOver(): WebSocket | null {
    const { socket } = this;
    if (socket?.readyState !== WebSocket.OPEN) return null;
    this.socket = null;
    this.close();
    return socket;
  }

  private use(socket: WebSocket): void {
    const isCurrent = () => this.socket === socket;
    socket.onopen = () => isCurrent() && this.events.opened();
    socket.onclose = () => {
      if (!isCurrent()) return;
      this.socket = null;
      this.events.closed();
    };
    socket.onmessage = ({ data }) => {
      if (!isCurrent()) return;
      let message: ServerKind;
      try {
        if (!(data instanceof ArrayBuffer)) throw new Error("a text frame");
        message = decoded(new Uint8Array(data));
      } catch {
        socket.close(4000, "not a message of multitetra.v1");
        return;
      }
      this.events.received(message);
    };
    this.socket = socket;
  }

  connectIn(milliseconds: number): void {
    clearTimeout(this.timer);
    this.timer = window.setTimeout(() => this.connect(), milliseconds);
  }

  send(message: ClientKind): void {
    if (this.socket?.readyState === WebSocket.OPEN) {
      this.socket.send(encoded(message) as Uint8Array<ArrayBuffer>);
    }
  }

  // Closes the connection, if any.
  close(): void {
    clearTimeout(this.timer);
    const socket = this.socket;
    this.socket = null;
    this.policyListener.abort();
    socket?.close();
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
