// Plays a series: shows the next time when it is due and completely loaded, and prefetches the following ones.
export interface PlaybackState {
  times: readonly number[]; // Ascending; at least two.
  now: number; // One of them.
  playing: boolean;
  speed: number; // Times per second.
  loop: boolean;
}

export interface PlayerActions {
  isReady: (time: number) => boolean;
  prepare: (times: readonly number[]) => void; // Soonest first; empty: no prefetch.
  show: (time: number) => void;
  stop: () => void; // Called at the end.
}

export interface PlaybackRate {
  rate: number | null; // Times per second shown recently; null: unknown.
  isWaiting: boolean; // For the server.
}

const lately = 2000; // Milliseconds.
const lateEnough = 250; // Milliseconds after which an overdue time is reported as not loaded.

export class TimePlayer {
  private isRunning = false;
  private due = 0; // When the next time is due.
  private shown: number[] = []; // When the last ones were shown.
  private prepared = "";

  // `schedule` runs a callback before the next frame.
  constructor(
    private readonly played: () => PlaybackState | null,
    private readonly actions: PlayerActions,
    private readonly onPace: (pace: PlaybackRate) => void,
    private readonly schedule: (act: () => void) => void = (act) => requestAnimationFrame(act),
    private readonly clock: () => number = () => performance.now(),
  ) {}

  // Call when the settings or the dataset may have changed.
  update(): void {
    const played = this.played();
    if (!played?.playing) return this.stop();
    this.prepared = ""; // The times to prefetch may have changed.
    if (this.isRunning) return;
    this.isRunning = true;
    this.shown = [];
    this.due = this.clock() + 1000 / played.speed;
    this.schedule(() => this.tick());
  }

  stop(): void {
    if (!this.isRunning) return;
    this.isRunning = false;
    this.prepared = "";
    this.actions.prepare([]);
    this.onPace({ rate: null, isWaiting: false });
  }

  private tick(): void {
    const played = this.played();
    if (!this.isRunning) return;
    if (!played?.playing) return this.stop();
    const ahead = timesAhead(played);
    if (ahead.length === 0) {
      this.stop();
      return this.actions.stop();
    }
    this.prepare(ahead);
    const now = this.clock();
    const isReady = this.actions.isReady(ahead[0]);
    if (isReady && now >= this.due) {
      // Delays are not made up for.
      const period = 1000 / played.speed;
      this.due = (now - this.due > period ? now : this.due) + period;
      this.shown = [...this.shown.filter((at) => at > now - lately), now];
      this.actions.show(ahead[0]);
    }
    this.onPace({ rate: this.rate(), isWaiting: !isReady && now > this.due + lateEnough });
    this.schedule(() => this.tick());
  }

  private prepare(ahead: readonly number[]): void {
    const wanted = ahead.join();
    if (wanted === this.prepared) return;
    this.prepared = wanted;
    this.actions.prepare(ahead);
  }

  private rate(): number | null {
    const { shown } = this;
    const span = shown.length > 1 ? shown[shown.length - 1] - shown[0] : 0;
    return span > 0 ? (1000 * (shown.length - 1)) / span : null;
  }
}

// Returns the upcoming times in order; with `loop`, all others.
export function timesAhead({ times, now, loop }: Pick<PlaybackState, "times" | "now" | "loop">): number[] {
  const at = times.indexOf(now);
  return [...times.slice(at + 1), ...(loop ? times.slice(0, Math.max(0, at)) : [])];
}

// Returns the time `steps` later, wrapping around with `loop`.
export function neighboringTime({ times, now, loop }: Pick<PlaybackState, "times" | "now" | "loop">, steps: number): number {
  const to = times.indexOf(now) + steps;
  return times[loop ? (to + times.length) % times.length : Math.min(times.length - 1, Math.max(0, to))];
}
