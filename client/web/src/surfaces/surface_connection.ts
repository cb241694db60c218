// The connection of one surface: its own for the first surface of a view and for prefetches, otherwise one of a pool.

import type { ClientKind, ServerKind } from "../protocol/messages";
import { noFailure, type Progress } from "../state/progress";
import type { Store } from "../state/store";
import type { ConnectionPool, IdleConnection, PoolClient } from "../stream/connection_pool";
import type { Conversation, Effect } from "../stream/conversation";
import { Link } from "../stream/link";

export interface SurfaceConnectionParts {
  address: string;
  pool: ConnectionPool;
  conversation: Conversation;
  progress: Store<Progress>;
  isActive: () => boolean; // Whether the surface has a stream or waits for one.
  perform: (effects: Effect[]) => void;
}

export class SurfaceConnection implements PoolClient {
  private readonly link: Link;
  private isHeld = false; // Connected or connecting.

  // `isOwn`: whether the connection is not one of the pool.
  constructor(
    private readonly parts: SurfaceConnectionParts,
    private isOwn: boolean,
  ) {
    const { address, pool, conversation, progress, perform } = parts;
    this.link = new Link(address, {
      opened: () => perform(conversation.opened()),
      closed: () => perform(conversation.closed()),
      received: (message: ServerKind) => {
        perform(conversation.received(message));
        if (conversation.isReceived) pool.distribute();
      },
      progress: (shareRead) => progress.set({ shareRead }),
      blocked: () => {
        const text = `This page cannot connect to "${address}", or is not allowed to.`;
        progress.set({ phase: "lost", retryAt: 0, failure: { ...noFailure, text, isFatal: true } });
      },
    });
  }

  // Whether it is needed: not while received data is decoded and checked.
  get isBusy(): boolean {
    return this.parts.isActive() && !this.parts.conversation.isReceived;
  }

  // Uses a connection outside of the pool from now on.
  makeOwn(): void {
    this.isOwn = true;
    this.parts.pool.release(this);
  }

  // Connects, or requests a connection from the pool, unless there is one.
  ensure(): void {
    if (this.isHeld) return;
    if (this.isOwn) this.grantConnection();
    else this.parts.pool.request(this);
  }

  // Replaces the connection, if any.
  reconnect(): void {
    if (this.isHeld) this.grantConnection();
  }

  reconnectIn(milliseconds: number): void {
    this.link.connectIn(milliseconds);
  }

  send(message: ClientKind): void {
    this.link.send(message);
  }

  close(): void {
    this.link.close();
    this.parts.pool.release(this);
  }

  grantConnection(connection: IdleConnection | null = null): void {
    const { conversation, perform, progress } = this.parts;
    this.isHeld = true;
    perform(conversation.connecting());
    progress.set({ failure: null, isStreaming: false });
    if (!connection) return this.link.connect();
    this.link.adopt(connection.channel);
    perform(conversation.adopted(connection.lastRequestId));
  }

  revokeConnection(): IdleConnection | null {
    const { conversation, perform, progress } = this.parts;
    this.isHeld = false;
    const lastRequestId = conversation.handOver();
    const channel = lastRequestId === null ? null : this.link.handOver();
    this.link.close();
    if (!channel) perform(conversation.connecting());
    progress.set({ phase: "connecting" });
    return channel && { channel, lastRequestId: lastRequestId! };
  }
}
