// A few connections shared by many surfaces. A holder keeps its connection, even when idle, until another client needs
// it, so that not each of a thousand labels has to connect.
import type { Channel } from "./channel";

// An idle connection and the last request id used on it.
export interface IdleConnection {
  channel: Channel;
  lastRequestId: bigint;
}

export interface PoolClient {
  readonly isBusy: boolean; // Whether it needs its connection now.
  grantConnection: (connection: IdleConnection | null) => void; // Null: it must connect.
  revokeConnection: () => IdleConnection | null; // Null: the connection is lost or not yet open.
}

export class ConnectionPool {
  private readonly holders = new Set<PoolClient>(); // Roughly by idle time, longest first.
  private readonly queue: PoolClient[] = [];

  constructor(private readonly maxConnections: number) {}

  request(one: PoolClient): void {
    if (this.holders.has(one) || this.queue.includes(one)) return;
    this.queue.push(one);
    this.distribute();
  }

  // Releases the client's connection or request.
  release(one: PoolClient): void {
    this.holders.delete(one);
    const at = this.queue.indexOf(one);
    if (at >= 0) this.queue.splice(at, 1);
    this.distribute();
  }

  // Call when a holder may have become idle.
  distribute(): void {
    while (this.queue.length > 0) {
      let connection: IdleConnection | null = null;
      if (this.holders.size >= this.maxConnections) {
        const idle = [...this.holders].find(({ isBusy }) => !isBusy);
        if (!idle) return;
        this.holders.delete(idle);
        connection = idle.revokeConnection();
      }
      const next = this.queue.shift()!;
      this.holders.add(next);
      next.grantConnection(connection);
    }
  }
}
