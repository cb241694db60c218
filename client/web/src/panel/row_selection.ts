// The selected rows of a table, by the usual rules of mouse and keyboard: a click selects one row, Ctrl adds or removes
// one, Shift selects a range from the row selected last.
export class RowSelection {
  private keys: ReadonlySet<string> = new Set();
  private anchor: string | null = null; // The end of ranges that stays.

  constructor(private readonly changed: () => void) {}

  has(key: string): boolean {
    return this.keys.has(key);
  }

  // Selects this row alone.
  select(key: string): void {
    this.set([key], key);
  }

  // Adds or removes this row.
  toggle(key: string): void {
    this.set(this.has(key) ? [...this.keys].filter((one) => one !== key) : [...this.keys, key], key);
  }

  // Selects the rows between the last selected one, or else `start`, and this one. `order`: the visible rows of the
  // table.
  extend(key: string, order: readonly string[], start = key): void {
    const anchor = this.anchor ?? start;
    const [from, to] = [order.indexOf(anchor), order.indexOf(key)];
    if (from < 0) return this.select(key);
    this.set(order.slice(Math.min(from, to), Math.max(from, to) + 1), anchor);
  }

  // Selects exactly these rows.
  selectAll(keys: readonly string[]): void {
    this.set(keys, this.anchor);
  }

  // Returns false if nothing was selected.
  clear(): boolean {
    if (this.keys.size === 0) return false;
    this.set([], null);
    return true;
  }

  private set(keys: readonly string[], anchor: string | null): void {
    this.keys = new Set(keys);
    this.anchor = anchor;
    this.changed();
  }
}
