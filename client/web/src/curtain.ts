// Surfaces of one view, at one time: where the time changes, all that are seen change together, from one
// frame to the next, and never is there one of this time beside one of that.
export interface Moment {
  scene: string; // What is looked at: a family, or a dataset of its own.
  time: number | null;
}

interface Waiting {
  moment: Moment;
  show: () => void;
}

export class Curtain<Member> {
  private shown: Moment | null = null; // Nothing else is drawn.
  private readonly waiting = new Map<Member, Waiting>();
  private readonly has = new Map<Member, Moment>(); // What each has shown last, drawn or not.

  // `seen`: those that are to be seen now; `risen`: another moment is shown from now.
  constructor(private readonly seen: () => readonly Member[], private readonly risen: () => void) {}

  // Whether what the member has may be drawn.
  isOpenTo(member: Member): boolean {
    const moment = this.has.get(member);
    return !moment || !this.shown || isSame(moment, this.shown);
  }

  // The member has something to show: now, when all that are seen have, or never, if it offers something else
  // before. Another scene is shown as it comes, and what is left of the one before is not.
  offer(member: Member, moment: Moment, show: () => void): void {
    const isOtherScene = this.shown?.scene !== moment.scene;
    if (isOtherScene) {
      this.shown = moment;
      this.waiting.clear();
    }
    const isSeen = this.seen().includes(member);
    if (isSeen && !isSame(moment, this.shown!)) this.waiting.set(member, { moment, show });
    else this.show(member, { moment, show });
    if (isOtherScene) this.risen();
    this.look();
  }

  // What the member offered is gone.
  withdraw(member: Member): void {
    this.waiting.delete(member);
  }

  leave(member: Member): void {
    this.waiting.delete(member);
    this.has.delete(member);
  }

  // Others may be seen than before.
  look(): void {
    const seen = this.seen();
    const next = seen.length > 0 ? this.commonOf(seen) : this.latest();
    if (!next || isSame(next, this.shown!)) return;
    this.shown = next;
    for (const [member, one] of [...this.waiting]) if (isSame(one.moment, next)) this.show(member, one);
    this.risen();
  }

  private show(member: Member, { moment, show }: Waiting): void {
    this.waiting.delete(member);
    this.has.delete(member); // The latest is the last.
    this.has.set(member, moment);
    show();
  }

  // A moment of which all have something, and one of them waits.
  private commonOf(seen: readonly Member[]): Moment | null {
    const first = seen.map((member) => this.waiting.get(member)).find((one) => one !== undefined)?.moment;
    const hasIt = (member: Member) => {
      const moment = this.waiting.get(member)?.moment ?? this.has.get(member);
      return moment !== undefined && isSame(moment, first!);
    };
    return first && seen.every(hasIt) ? first : null;
  }

  // Where nothing is seen, nothing has to wait.
  private latest(): Moment | null {
    return [...this.has.values()].at(-1) ?? null;
  }
}

function isSame(a: Moment, b: Moment): boolean {
  return a.scene === b.scene && a.time === b.time;
}
