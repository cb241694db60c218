// Keyboard shortcuts, inactive while the user types text. panel/help.ts lists them.
import type { Settings } from "../state/settings";

export interface KeyActions {
  turn: (azimuth: number, elevation: number, factor?: number) => void;
  fit: () => void;
  reset: () => void;
  escape: () => void;
  help: () => void;
  fullScreen: () => void;
  toggleSlices: () => void;
  undo: () => void;
  redo: () => void;
  stepTime: (steps: number) => void;
  roll: (radians: number) => void;
}

export interface SettingsAccess {
  get: () => Settings;
  set: (change: Partial<Settings>) => void;
}

export function installKeyboard(settings: SettingsAccess, actions: KeyActions): void {
  const turn = 0.09;
  const keys: Record<string, () => void> = {
    ArrowLeft: () => actions.turn(-turn, 0),
    ArrowRight: () => actions.turn(turn, 0),
    ArrowUp: () => actions.turn(0, turn),
    ArrowDown: () => actions.turn(0, -turn),
    "+": () => actions.turn(0, 0, 0.88),
    "-": () => actions.turn(0, 0, 1 / 0.88),
    "[": () => actions.roll(-turn),
    "]": () => actions.roll(turn),
    u: () => actions.roll(Math.PI),
    f: actions.fit,
    r: actions.reset,
    Escape: actions.escape,
    "?": actions.help,
    z: actions.fullScreen,
    v: actions.toggleSlices,
    p: () => settings.set({ projection: settings.get().projection === "perspective" ? "orthographic" : "perspective" }),
    o: () => settings.set({ occlusion: !settings.get().occlusion }),
    x: () => settings.set({ clip: nextOf(["off", "x", "y", "z", "oblique"], settings.get().clip) }),
    " ": () => settings.set({ playing: !settings.get().playing }),
    ",": () => actions.stepTime(-1),
    ".": () => actions.stepTime(1),
    w: () => settings.set({ wireframe: !settings.get().wireframe }),
    a: () => settings.set({ axes: !settings.get().axes }),
    c: () => settings.set({ coloring: nextOf(["plain", "tiles", "steps"], settings.get().coloring) }),
  };
  window.addEventListener("keydown", (event) => {
    const target = event.target as Element;
    if (target.closest("dialog")) return;
    if (target.closest("input:not([type=range]):not([type=checkbox]), textarea")) return;
    if ((event.ctrlKey || event.metaKey) && !event.altKey) return undoOrRedo(event, actions);
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    if (target.closest("input, select, [role=slider], [role=radio]")) return;
    if (event.key === " " && target.closest("button, summary, a")) return; // Activates them.
    const act = keys[event.key] ?? keys[event.key.toLowerCase()];
    if (!act) return;
    event.preventDefault();
    act();
  });
}

function undoOrRedo(event: KeyboardEvent, actions: KeyActions): void {
  const key = event.key.toLowerCase();
  if (key !== "z" && key !== "y") return;
  event.preventDefault();
  if (key === "y" || event.shiftKey) actions.redo();
  else actions.undo();
}

function nextOf<T>(all: readonly T[], now: T): T {
  return all[(all.indexOf(now) + 1) % all.length];
}
