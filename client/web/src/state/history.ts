// Undo and redo of settings. Rapid changes of the same setting, as when dragging a slider, count as one. Camera, time
// and measurements are excluded.
import { type Settings, settingNames, settingTable } from "./settings";

const maxEntries = 100;
const together = 700; // Milliseconds.

type Undoable = Partial<Settings>;

const undoableNames = settingNames.filter((name) => !settingTable[name].isOfView);

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

function undoable(settings: Settings): Undoable {
  return Object.fromEntries(undoableNames.map((name) => [name, settings[name]]));
}

function changed(now: Settings, before: Settings): string {
  return undoableNames.filter((name) => now[name] !== before[name]).join(" ");
}
