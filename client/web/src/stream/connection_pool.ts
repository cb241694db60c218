// A few connections shared by many surfaces, so that not each of a thousand labels has to connect. They stay open while
// no surface uses them.
import type { ConnectionUser, ServerConnection } from "./server_connection";

export class ConnectionPool {
  private readonly connections: ServerConnection[] = [];
  private readonly users = new Map<ConnectionUser, ServerConnection | null>(); // In order of their requests; null: waiting.

  constructor(
    private readonly create: () => ServerConnection,
    private readonly maxConnections: number,
  ) {}

  // Calls the user's ready() as soon as there is a connection for it, until release().
  request(user: ConnectionUser): void {
    if (this.users.has(user)) return;
    this.users.set(user, null);
    this.distribute();
  }

  release(user: ConnectionUser): void {
    const connection = this.users.get(user);
    this.users.delete(user);
    connection?.use(null);
    this.distribute();
  }

  // Connects now, at least once: the first user need not wait for it.
  connect(): void {
    if (this.connections.length === 0) this.connections.push(this.create());
    for (const connection of this.connections) connection.connect();
  }

  close(): void {
    this.users.clear();
    for (const connection of this.connections) connection.close();
  }

  private distribute(): void {
    for (const [user, connection] of this.users) {
      if (connection) continue;
      const next = this.free();
      if (!next) return;
      this.users.set(user, next);
      next.use(user);
    }
  }

  private free(): ServerConnection | null {
    const free = this.connections.filter(({ isFree }) => isFree);
    const found = free.find(({ isReady }) => isReady) ?? free[0];
    if (found || this.connections.length >= this.maxConnections) return found ?? null;
    const created = this.create();
    this.connections.push(created);
    return created;
  }
}
