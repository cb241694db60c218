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
  private shown: Moment | null = null;
  private readonly waiting = new Map<Member, Waiting>();

  // `seen`: those that are to be seen now; `risen`: another moment is shown from now.
  constructor(private readonly seen: () => readonly Member[], private readonly risen: () => void) {}

  // Whether one of this moment may be drawn.
  isOpenTo(moment: Moment | null): boolean {
    return !moment || !this.shown || isSame(moment, this.shown);
  }

  // The member has something to show: now, when all that are seen have, or never, if it has something else first.
  // Another scene is shown as it comes, and what is left of the one before is not.
  offer(member: Member, moment: Moment, show: () => void): void {
    if (this.shown?.scene !== moment.scene) {
      this.shown = moment;
      this.waiting.clear();
      show();
      return this.risen();
    }
    if (isSame(moment, this.shown) || !this.seen().includes(member)) {
      this.waiting.delete(member);
      return show();
    }
    this.waiting.set(member, { moment, show });
    this.look();
  }

  // What the member offered is gone.
  withdraw(member: Member): void {
    this.waiting.delete(member);
  }

  // There may be fewer to wait for.
  look(): void {
    const seen = this.seen();
    const offers = seen.map((member) => this.waiting.get(member));
    const [first] = offers;
    if (!first || !offers.every((one) => one && isSame(one.moment, first.moment))) return;
    this.shown = first.moment;
    for (const member of seen) this.waiting.delete(member);
    for (const one of offers) one!.show();
    this.risen();
  }
}

function isSame(a: Moment, b: Moment): boolean {
  return a.scene === b.scene && a.time === b.time;
}
