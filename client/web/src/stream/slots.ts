// A few connections for many that need one now and then. Who has one keeps it, also when idle, until
// somebody else needs it.
export interface SlotHolder {
  readonly isBusy: boolean; // Its connection cannot be taken away now.
  granted: () => void;
  revoked: () => void;
}

export class Slots {
  private readonly holders = new Set<SlotHolder>(); // Who was idle for longest first, about.
  private readonly queue: SlotHolder[] = [];

  constructor(private readonly most: number) {}

  want(one: SlotHolder): void {
    if (this.holders.has(one) || this.queue.includes(one)) return;
    this.queue.push(one);
    this.deal();
  }

  // It needs none any more.
  leave(one: SlotHolder): void {
    this.holders.delete(one);
    const at = this.queue.indexOf(one);
    if (at >= 0) this.queue.splice(at, 1);
    this.deal();
  }

  // A holder may have become idle.
  deal(): void {
    while (this.queue.length > 0) {
      if (this.holders.size >= this.most) {
        const idle = [...this.holders].find(({ isBusy }) => !isBusy);
        if (!idle) return;
        this.holders.delete(idle);
        idle.revoked();
      }
      const next = this.queue.shift()!;
      this.holders.add(next);
      next.granted();
    }
  }
}
