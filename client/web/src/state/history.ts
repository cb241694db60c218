// Undo and redo of settings. Rapid changes of the same setting, as when dragging a slider, count as one. Camera, time
// and measurements are excluded.
import type { Settings } from "./settings";

const maxEntries = 100;
const together = 700; // Milliseconds.

type Undoable = Omit<Settings, "eye" | "target" | "up" | "places" | "cross" | "theme" | "t" | "playing">;

export class History {
  private readonly before: Undoable[] = [];
  private readonly after: Undoable[] = [];
  private last = { keys: "", at: -Infinity };
  private isOwn = false;

  // Records a change; `now` in milliseconds of any clock.
  note(settings: Settings, previous: Settings, now: number): void {
    const keys = changed(settings, previous);
    if (this.isOwn || keys === "") return;
    const isSame = keys === this.last.keys && now - this.last.at < together;
    this.last = { keys, at: now };
    this.after.length = 0;
    if (isSame) return;
    this.before.push(undoable(previous));
    if (this.before.length > maxEntries) this.before.shift();
  }

  // Calls `apply` with the previous settings; returns false if there are none.
  undo(settings: Settings, apply: (to: Undoable) => void): boolean {
    return this.step(this.before, this.after, settings, apply);
  }

  redo(settings: Settings, apply: (to: Undoable) => void): boolean {
    return this.step(this.after, this.before, settings, apply);
  }

  private step(from: Undoable[], to: Undoable[], settings: Settings, apply: (to: Undoable) => void): boolean {
    const next = from.pop();
    if (!next) return false;
    to.push(undoable(settings));
    this.last.keys = "";
    this.isOwn = true;
    try {
      apply(next);
    } finally {
      this.isOwn = false;
    }
    return true;
  }
}

function undoable({ eye: _eye, target: _target, up: _up, places: _places, cross: _cross, theme: _theme, t: _t, playing: _playing, ...rest }: Settings): Undoable {
  return rest;
}

function changed(now: Settings, before: Settings): string {
  const names = Object.keys(undoable(now)) as (keyof Undoable)[];
  return names.filter((name) => now[name] !== before[name]).join(" ");
}
