// A value whose listeners are called on every change.
export class Store<T extends object> {
  private readonly listeners = new Set<(now: T, before: T) => void>();

  constructor(private value: T) {}

  get(): Readonly<T> {
    return this.value;
  }

  set(change: Partial<T>): void {
    const before = this.value;
    const isSame = (Object.keys(change) as (keyof T)[]).every((key) => change[key] === before[key]);
    if (isSame) return;
    this.value = { ...before, ...change };
    for (const listener of this.listeners) listener(this.value, before);
  }

  // Also calls the listener immediately.
  watch(listener: (now: T, before: T) => void): void {
    this.listeners.add(listener);
    listener(this.value, this.value);
  }
}
