// A connection that has said hello to the server, and reconnects after longer and longer waits while somebody uses it.
import { type ClientKind, create, ErrorCode, type ErrorReply, HelloSchema, PayloadCodec, type ServerKind } from "../protocol/messages";
import { type ConnectionState, type Failure, noConnection } from "../state/progress";
import { Store } from "../state/store";
import { Link } from "./link";

export interface ConnectionUser {
  ready: (connection: ServerConnection) => void; // Also after each reconnection.
  received: (message: ServerKind) => void; // Anything about requests.
  lost: (failure: Failure | null) => void; // Also after an attempt to connect.
  read?: (share: number) => void; // See Channel.onprogress.
}

const protocolVersion = 1;
const viewer = "multitetra-viewer/0.1"; // The version is that of package.json.
const codecs = [PayloadCodec.SAMPLE_SHELL, PayloadCodec.DRACO_LATTICE];
const firstRetry = 500; // Milliseconds.
const maxRetry = 15_000;
const maxWait = 600_000; // The longest accepted delay of a server.

export class ServerConnection {
  readonly state = new Store<ConnectionState>(noConnection);
  private readonly link: Link;
  private retry = firstRetry;
  private lastRequestId = 0n;
  private user: ConnectionUser | null = null;
  private isClosed = true; // Neither connected nor trying to.

  // `part` names a part of the viewer in the server's log; empty: the surfaces.
  constructor(
    address: string,
    private readonly token: () => string,
    private readonly part: string,
  ) {
    this.link = new Link(address, {
      opened: () => this.greet(),
      received: (message) => this.receive(message),
      progress: (share) => this.user?.read?.(share),
      closed: () => this.lose(firstRetry),
      blocked: () => this.lose(0, { text: `This page cannot connect to "${address}", or is not allowed to.`, isFatal: true, needsToken: false }),
    });
  }

  get isReady(): boolean {
    return !this.isClosed && this.state.get().phase === "ready";
  }

  get isFree(): boolean {
    return this.user === null;
  }

  // Connects unless it is connected or will retry. Null: nobody needs it; it stays open.
  use(user: ConnectionUser | null): void {
    this.user = user;
    if (user && this.isReady) user.ready(this);
    else if (user && this.isClosed) this.connect();
  }

  // Connects now, instead of a connection that there is; also after a refusal.
  connect(): void {
    const isAgain = !this.isClosed;
    this.isClosed = false;
    this.state.set({ phase: "connecting", retryAt: 0, failure: null });
    if (isAgain) this.user?.lost(null);
    this.link.connect();
  }

  nextRequestId(): bigint {
    return ++this.lastRequestId;
  }

  send(message: ClientKind): void {
    this.link.send(message);
  }

  close(): void {
    this.isClosed = true;
    this.link.close();
  }

  private greet(): void {
    this.lastRequestId = 0n;
    this.state.set({ phase: "greeting" });
    const agent = this.part ? `${viewer} ${this.part}` : viewer;
    const value = create(HelloSchema, { minVersion: protocolVersion, maxVersion: protocolVersion, codecs, token: this.token(), agent });
    this.send({ case: "hello", value });
  }

  private receive(message: ServerKind): void {
    if (message.case === "error" && message.value.requestId === 0n) return this.refuse(message.value);
    if (message.case !== "welcome") return this.user?.received(message);
    this.retry = firstRetry;
    // The server omits sample shells from the codecs where it permits surfaces only.
    const permitsSamples = message.value.codecs.includes(PayloadCodec.SAMPLE_SHELL);
    this.state.set({ phase: "ready", retryAt: 0, failure: null, permitsSamples });
    this.user?.ready(this);
  }

  // Only some reasons are temporary.
  private refuse({ code, text, retryAfter }: ErrorReply): void {
    const isFatal = code !== ErrorCode.UNAVAILABLE && code !== ErrorCode.LIMIT_EXCEEDED;
    this.link.close();
    this.lose(delayOf(retryAfter), { text, isFatal, needsToken: code === ErrorCode.UNAUTHENTICATED });
  }

  // Retries after `wait` milliseconds, or longer after several failures.
  private lose(wait: number, failure: Failure | null = null): void {
    const isRetrying = this.user !== null && !failure?.isFatal;
    const delay = Math.max(this.retry, wait);
    this.retry = Math.min(maxRetry, 2 * this.retry);
    this.isClosed = !isRetrying;
    if (isRetrying) this.link.connectIn(delay);
    this.state.set({ phase: "lost", retryAt: isRetrying ? performance.now() + delay : 0, failure });
    this.user?.lost(failure);
  }
}

// Converts the server's delay in seconds to milliseconds.
export function delayOf(seconds: number): number {
  return seconds > 0 ? Math.min(maxWait, Math.max(firstRetry, 1000 * seconds)) : 0;
}
