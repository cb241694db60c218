// Listeners by kind of event.
export class Events<Kinds extends object> {
  private readonly listeners = new Map<keyof Kinds, Set<(what: never) => void>>();

  // Returns a function that removes the listener.
  on<K extends keyof Kinds>(kind: K, listener: (what: Kinds[K]) => void): () => void {
    const all = this.listeners.get(kind) ?? new Set();
    this.listeners.set(kind, all.add(listener));
    return () => void all.delete(listener);
  }

  emit<K extends keyof Kinds>(kind: K, what: Kinds[K]): void {
    for (const listener of this.listeners.get(kind) ?? []) (listener as (what: Kinds[K]) => void)(what);
  }
}
