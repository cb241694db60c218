// Swaps the surfaces of one view together: when the time changes, all visible surfaces are swapped between two frames,
// so that surfaces of different times are never drawn together.
export interface SceneTime {
  scene: string; // A series, or a single dataset.
  time: number | null;
}

interface Waiting {
  time: SceneTime;
  show: () => void;
}

export class SwapGroup<Member> {
  private shown: SceneTime | null = null; // Only this time is drawn.
  private readonly waiting = new Map<Member, Waiting>();
  private readonly current = new Map<Member, SceneTime>(); // The last time of each member, drawn or not.

  // `visible`: the currently visible members; `swapped` is called when another time is shown.
  constructor(
    private readonly visible: () => readonly Member[],
    private readonly swapped: () => void,
  ) {}

  // Returns whether the member's surface may be drawn: it belongs to the shown time.
  isDrawable(member: Member): boolean {
    const time = this.current.get(member);
    return !time || !this.shown || isSame(time, this.shown);
  }

  // Offers a surface of a time. `show` is called when all visible members have one of that time, or never if the
  // member offers another one before. Another scene is shown immediately, and the rest of the former scene is dropped.
  offer(member: Member, time: SceneTime, show: () => void): void {
    const isOtherScene = this.shown?.scene !== time.scene;
    if (isOtherScene) {
      this.shown = time;
      this.waiting.clear();
    }
    if (!isSame(time, this.shown!) && this.visible().includes(member)) this.waiting.set(member, { time, show });
    else this.show(member, { time, show });
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
    for (const [member, one] of [...this.waiting]) if (isSame(one.time, next)) this.show(member, one);
    this.swapped();
  }

  private show(member: Member, { time, show }: Waiting): void {
    this.waiting.delete(member);
    this.current.delete(member); // Moves it to the end of the map.
    this.current.set(member, time);
    show();
  }

  // Returns a time that all members have and one of them is waiting for.
  private commonMoment(visible: readonly Member[]): SceneTime | null {
    const first = visible.map((member) => this.waiting.get(member)).find((one) => one !== undefined)?.time;
    const hasIt = (member: Member) => {
      const time = this.waiting.get(member)?.time ?? this.current.get(member);
      return time !== undefined && isSame(time, first!);
    };
    return first && visible.every(hasIt) ? first : null;
  }

  // If nothing is visible, nothing has to wait.
  private latest(): SceneTime | null {
    return [...this.current.values()].at(-1) ?? null;
  }
}

function isSame(a: SceneTime, b: SceneTime): boolean {
  return a.scene === b.scene && a.time === b.time;
}
