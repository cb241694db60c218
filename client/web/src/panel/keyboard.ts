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

export interface Turned {
  get: () => Settings;
  set: (change: Partial<Settings>) => void;
}

export function installKeyboard(settings: Turned, acts: KeyActions): void {
  const turn = 0.09;
  const keys: Record<string, () => void> = {
    ArrowLeft: () => acts.turn(-turn, 0),
    ArrowRight: () => acts.turn(turn, 0),
    ArrowUp: () => acts.turn(0, turn),
    ArrowDown: () => acts.turn(0, -turn),
    "+": () => acts.turn(0, 0, 0.88),
    "-": () => acts.turn(0, 0, 1 / 0.88),
    "[": () => acts.roll(-turn),
    "]": () => acts.roll(turn),
    u: () => acts.roll(Math.PI),
    f: acts.fit,
    r: acts.reset,
    Escape: acts.escape,
    "?": acts.help,
    z: acts.fullScreen,
    v: acts.toggleSlices,
    p: () => settings.set({ projection: settings.get().projection === "perspective" ? "orthographic" : "perspective" }),
    o: () => settings.set({ occlusion: !settings.get().occlusion }),
    x: () => settings.set({ clip: nextOf(["off", "x", "y", "z", "oblique"], settings.get().clip) }),
    " ": () => settings.set({ playing: !settings.get().playing }),
    ",": () => acts.stepTime(-1),
    ".": () => acts.stepTime(1),
    w: () => settings.set({ wireframe: !settings.get().wireframe }),
    a: () => settings.set({ axes: !settings.get().axes }),
    c: () => settings.set({ coloring: nextOf(["plain", "tiles", "steps"], settings.get().coloring) }),
  };
  window.addEventListener("keydown", (event) => {
    const target = event.target as Element;
    if (target.closest("dialog")) return;
    if (target.closest("input:not([type=range]):not([type=checkbox]), textarea")) return;
    if ((event.ctrlKey || event.metaKey) && !event.altKey) return takeBack(event, acts);
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    if (target.closest("input, select, [role=slider], [role=radio]")) return;
    if (event.key === " " && target.closest("button, summary, a")) return; // Activates them.
    const act = keys[event.key] ?? keys[event.key.toLowerCase()];
    if (!act) return;
    event.preventDefault();
    act();
  });
}

function takeBack(event: KeyboardEvent, acts: KeyActions): void {
  const key = event.key.toLowerCase();
  if (key !== "z" && key !== "y") return;
  event.preventDefault();
  if (key === "y" || event.shiftKey) acts.redo();
  else acts.undo();
}

function nextOf<T>(all: readonly T[], now: T): T {
  return all[(all.indexOf(now) + 1) % all.length];
}
