// The time controls over the scene: play, slider, current time, speed and loop.

import { button, h } from "../shared/elements";
import { inDigits } from "../shared/quantities";
import { timeText } from "../state/series";
import type { Settings } from "../state/settings";
import type { PlaybackRate } from "../viewer/time_player";

export interface ShownTimes {
  all: readonly number[];
  now: number;
  unit: string;
}

const speeds = [1, 2, 5, 10, 20, 30];

export class TimeBar {
  readonly element = h("div", { class: "times", role: "group", "aria-label": "Time", hidden: true });
  private readonly play = button("", () => this.turn({ playing: !this.settings?.playing }, false), { class: "play", "data-tip": "Plays the times (space)." });
  private readonly slider = h("input", {
    type: "range",
    min: "0",
    step: "1",
    "aria-label": "Time",
    input: () => this.scrub(true),
    change: () => this.scrub(false),
  });
  private readonly time = h("output", { class: "time" });
  private readonly pace = h("span", { class: "pace", "data-tip": "Displayed and requested time steps per second." });
  private readonly speed = h("select", { "aria-label": "Time steps per second", change: () => this.turn({ speed: Number(this.speed.value) }, false) });
  private readonly loop = button("↻", () => this.turn({ loop: !this.settings?.loop }, false), {
    class: "loop",
    "aria-label": "Begin again",
    "data-tip": "Repeats the series.",
  });
  private times: ShownTimes | null = null;
  private settings: Settings | null = null;

  constructor(private readonly turn: (changes: Partial<Settings>, isDragging: boolean) => void) {
    this.element.append(this.play, this.slider, this.time, this.pace, this.speed, this.loop);
  }

  private scrub(isDragging: boolean): void {
    const t = this.times?.all[Number(this.slider.value)];
    if (t !== undefined) this.turn({ t, playing: false }, isDragging);
  }

  // Null: there are no times.
  show(settings: Settings, times: ShownTimes | null): void {
    this.settings = settings;
    this.times = times;
    this.element.hidden = times === null;
    if (!times) return;
    const { all, now, unit } = times;
    const at = all.indexOf(now);
    this.slider.max = String(all.length - 1);
    this.slider.value = String(at);
    this.slider.style.setProperty("--share", `${(100 * at) / (all.length - 1)}%`);
    const text = timeText(now, unit, all);
    this.slider.setAttribute("aria-valuetext", text);
    this.time.textContent = text;
    // The width of the longest text, so that nothing moves during playback.
    this.time.style.minWidth = `${Math.max(...all.map((time) => timeText(time, unit, all).length))}ch`;
    this.play.textContent = settings.playing ? "❚❚" : "▶";
    this.play.setAttribute("aria-label", settings.playing ? "Pause" : "Play");
    this.loop.setAttribute("aria-pressed", String(settings.loop));
    this.showSpeeds(settings.speed);
  }

  showPace({ rate, isWaiting }: PlaybackRate): void {
    const text = isWaiting ? "loading…" : rate === null ? "" : `${inDigits(rate, rate < 10 ? 2 : 3)} of`;
    if (this.pace.textContent !== text) this.pace.textContent = text;
  }

  private showSpeeds(speed: number): void {
    const all = [...new Set([...speeds, speed])].sort((a, b) => a - b);
    if (this.speed.options.length !== all.length) {
      this.speed.replaceChildren(...all.map((one) => h("option", { value: String(one) }, `${one} /s`)));
    }
    this.speed.value = String(speed);
  }
}
