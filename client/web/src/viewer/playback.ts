// The times of a series in a view: the bar that shows them, steps and playback.
import { type ShownTimes, TimeBar } from "../panel/time_bar";
import type { DatasetInfo } from "../protocol/messages";
import { atTime, timeOf, timesOf } from "../state/series";
import type { Settings } from "../state/settings";
import type { View } from "../stream/request";
import { type Scene, sceneOf } from "../surfaces/scene_at";
import type { SurfaceSet } from "../surfaces/surface_set";
import { neighboringTime, type PlaybackState, TimePlayer } from "./time_player";

export interface PlayedView {
  surfaces: SurfaceSet;
  info: () => DatasetInfo | null; // The current dataset.
  list: () => readonly DatasetInfo[];
  settings: () => Settings;
  view: () => View | null; // For requests.
  set: (changes: Partial<Settings>, isDragging: boolean) => void;
}

export class Playback {
  readonly bar: TimeBar;
  private readonly player: TimePlayer;

  constructor(private readonly played: PlayedView) {
    const { surfaces, settings, view, set } = played;
    this.bar = new TimeBar(set);
    this.player = new TimePlayer(
      () => this.state,
      {
        isReady: (time) => surfaces.isPrepared(this.sceneAt(time), settings(), view()),
        prepare: (times) => {
          const scenes = times.map((time) => this.sceneAt(time));
          surfaces.prepare(scenes, settings(), view());
        },
        show: (time) => set({ t: time }, false),
        stop: () => set({ playing: false }, false),
      },
      (pace) => this.bar.showPace(pace),
    );
  }

  // The current time and all times; null: there are no times to choose.
  get times(): ShownTimes | null {
    const info = this.played.info();
    const all = info ? timesOf(this.played.list(), info) : [];
    return info && all.length > 1 ? { all, now: timeOf(info)!, unit: info.member!.timeUnit } : null;
  }

  // Call when the settings or the dataset may have changed.
  update(): void {
    this.bar.show(this.played.settings(), this.times);
    this.player.update();
  }

  // Steps to a later or earlier time.
  step(steps: number): void {
    const { state } = this;
    if (state) this.played.set({ t: neighboringTime(state, steps), playing: false }, false);
  }

  stop(): void {
    this.player.stop();
  }

  private get state(): PlaybackState | null {
    const { times } = this;
    const { playing, speed, loop } = this.played.settings();
    return times && { times: times.all, now: times.now, playing, speed, loop };
  }

  private sceneAt(time: number): Scene {
    const list = this.played.list();
    return sceneOf(list, this.played.settings(), atTime(list, this.played.info()!, time));
  }
}
