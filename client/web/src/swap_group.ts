// Swaps the surfaces of one view together: when the time changes, all visible surfaces are swapped between two frames,
// so that surfaces of different times are never drawn together.
export interface Moment {
  scene: string; // A series, or a single dataset.
  time: number | null;
}

interface Waiting {
  moment: Moment;
  show: () => void;
}

export class SwapGroup<Member> {
  private shown: Moment | null = null; // Only this moment is drawn.
  private readonly waiting = new Map<Member, Waiting>();
  private readonly current = new Map<Member, Moment>(); // The last moment of each member, drawn or not.

  // `visible`: the currently visible members; `swapped` is called when another moment is shown.
  constructor(private readonly visible: () => readonly Member[], private readonly swapped: () => void) {}

  // Returns whether the member's surface may be drawn: it belongs to the shown moment.
  isDrawable(member: Member): boolean {
    const moment = this.current.get(member);
    return !moment || !this.shown || isSame(moment, this.shown);
  }

  // Offers a surface of a moment. `show` is called when all visible members have one of that moment, or never if the
  // member offers another one before. Another scene is shown immediately, and the rest of the former scene is dropped.
  offer(member: Member, moment: Moment, show: () => void): void {
    const isOtherScene = this.shown?.scene !== moment.scene;
    if (isOtherScene) {
      this.shown = moment;
      this.waiting.clear();
    }
    if (!isSame(moment, this.shown!) && this.visible().includes(member)) this.waiting.set(member, { moment, show });
    else this.show(member, { moment, show });
    if (isOtherScene) this.swapped();
    this.update();
  }

  // Drops the member's offer.
  withdraw(member: Member): void {
    this.waiting.delete(member);
  }

  remove(member: Member): void {
    this.waiting.delete(member);
    this.current.delete(member);
  }

  // Swaps if the currently visible members are ready.
  update(): void {
    if (this.waiting.size === 0 && this.shown && [...this.current.values()].every((one) => isSame(one, this.shown!))) return;
    const visible = this.visible();
    const next = visible.length > 0 ? this.commonMoment(visible) : this.latest();
    if (!next || isSame(next, this.shown!)) return;
    this.shown = next;
    for (const [member, one] of [...this.waiting]) if (isSame(one.moment, next)) this.show(member, one);
    this.swapped();
  }

  private show(member: Member, { moment, show }: Waiting): void {
    this.waiting.delete(member);
    this.current.delete(member); // Moves it to the end of the map.
    this.current.set(member, moment);
    show();
  }

  // Returns a moment that all members have and one of them is waiting for.
  private commonMoment(visible: readonly Member[]): Moment | null {
    const first = visible.map((member) => this.waiting.get(member)).find((one) => one !== undefined)?.moment;
    const hasIt = (member: Member) => {
      const moment = this.waiting.get(member)?.moment ?? this.current.get(member);
      return moment !== undefined && isSame(moment, first!);
    };
    return first && visible.every(hasIt) ? first : null;
  }

  // If nothing is visible, nothing has to wait.
  private latest(): Moment | null {
    return [...this.current.values()].at(-1) ?? null;
  }
}

function isSame(a: Moment, b: Moment): boolean {
  return a.scene === b.scene && a.time === b.time;
}
