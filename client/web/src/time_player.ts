// Shows one time after the other: the next when it is due, and not before all of it is here. While it
// plays, the next times are prefetched; as soon as it stops, nothing is.
export interface Played {
  times: readonly number[]; // Ascending; two or more.
  now: number; // One of them.
  playing: boolean;
  speed: number; // Times a second.
  loop: boolean;
}

export interface PlayerActions {
  isReady: (time: number) => boolean;
  prepare: (times: readonly number[]) => void; // The soonest first; none: no prefetch.
  show: (time: number) => void;
  stop: () => void; // The end is reached.
}

export interface Pace {
  rate: number | null; // Times a second that were shown lately; null: not known.
  isWaiting: boolean; // For the server.
}

const lately = 2000; // Milliseconds.
const lateEnough = 250; // The next time is due and not loaded: that is reported.

export class TimePlayer {
  private isRunning = false;
  private due = 0; // When the next time is.
  private shown: number[] = []; // When the last ones were.
  private prepared = "";

  // `soon` calls back before the next frame is drawn.
  constructor(
    private readonly played: () => Played | null,
    private readonly acts: PlayerActions,
    private readonly onPace: (pace: Pace) => void,
    private readonly soon: (act: () => void) => void = (act) => requestAnimationFrame(act),
    private readonly clock: () => number = () => performance.now(),
  ) {}

  // Settings, or what is looked at, may have changed.
  update(): void {
    const played = this.played();
    if (!played?.playing) return this.stop();
    this.prepared = ""; // The times to prefetch may have changed.
    if (this.isRunning) return;
    this.isRunning = true;
    this.shown = [];
    this.due = this.clock() + 1000 / played.speed;
    this.soon(() => this.tick());
  }

  stop(): void {
    if (!this.isRunning) return;
    this.isRunning = false;
    this.prepared = "";
    this.acts.prepare([]);
    this.onPace({ rate: null, isWaiting: false });
  }

  private tick(): void {
    const played = this.played();
    if (!this.isRunning) return;
    if (!played?.playing) return this.stop();
    const ahead = timesAhead(played);
    if (ahead.length === 0) {
      this.stop();
      return this.acts.stop();
    }
    this.prepare(ahead);
    const now = this.clock();
    const isReady = this.acts.isReady(ahead[0]);
    if (isReady && now >= this.due) {
      // What is late is not made up for.
      const period = 1000 / played.speed;
      this.due = (now - this.due > period ? now : this.due) + period;
      this.shown = [...this.shown.filter((at) => at > now - lately), now];
      this.acts.show(ahead[0]);
    }
    this.onPace({ rate: this.rate(), isWaiting: !isReady && now > this.due + lateEnough });
    this.soon(() => this.tick());
  }

  private prepare(ahead: readonly number[]): void {
    const wanted = ahead.join();
    if (wanted === this.prepared) return;
    this.prepared = wanted;
    this.acts.prepare(ahead);
  }

  private rate(): number | null {
    const { shown } = this;
    const span = shown.length > 1 ? shown[shown.length - 1] - shown[0] : 0;
    return span > 0 ? (1000 * (shown.length - 1)) / span : null;
  }
}

// In the order in which they come; all others, where the first follows the last.
export function timesAhead({ times, now, loop }: Pick<Played, "times" | "now" | "loop">): number[] {
  const at = times.indexOf(now);
  return [...times.slice(at + 1), ...(loop ? times.slice(0, Math.max(0, at)) : [])];
}

// `steps` further, around where it loops.
export function timeBeside({ times, now, loop }: Pick<Played, "times" | "now" | "loop">, steps: number): number {
  const to = times.indexOf(now) + steps;
  return times[loop ? (to + times.length) % times.length : Math.min(times.length - 1, Math.max(0, to))];
}
