// Keys that work wherever nothing is being typed. panel/help.ts tells them to the user.
import type { Stage } from "../scene/stage";
import type { Colouring, Settings } from "../state/settings";
import type { Store } from "../state/store";

export function installKeyboard(
  stage: Stage,
  settings: Store<Settings>,
  acts: { fit: () => void; reset: () => void; forget: () => void; help: () => void },
): void {
  const turn = 0.09;
  const keys: Record<string, () => void> = {
    ArrowLeft: () => stage.turn(-turn, 0),
    ArrowRight: () => stage.turn(turn, 0),
    ArrowUp: () => stage.turn(0, turn),
    ArrowDown: () => stage.turn(0, -turn),
    "+": () => stage.turn(0, 0, 0.88),
    "-": () => stage.turn(0, 0, 1 / 0.88),
    f: acts.fit,
    r: acts.reset,
    Escape: acts.forget,
    "?": acts.help,
    w: () => settings.set({ wireframe: !settings.get().wireframe }),
    a: () => settings.set({ axes: !settings.get().axes }),
    c: () => settings.set({ colouring: nextColouring(settings.get().colouring) }),
  };
  window.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const target = event.target as Element;
    if (target.closest("dialog")) return;
    if (target.closest("input, select, textarea, [role=slider], [role=radio]")) return;
    const act = keys[event.key] ?? keys[event.key.toLowerCase()];
    if (!act) return;
    event.preventDefault();
    act();
  });
}

function nextColouring(now: Colouring): Colouring {
  const all: Colouring[] = ["plain", "tiles", "steps"];
  return all[(all.indexOf(now) + 1) % all.length];
}
