// Mouse, touch and keys on a slice view: a click or drag moves the crosshair, the wheel the plane. With Ctrl the wheel
// zooms, as two fingers do; the right or middle button, or Shift, drags the picture. A double click marks a place to
// measure.

// Places are in CSS pixels from the upper left corner of the view.
export interface SliceActions {
  moveCross: (x: number, y: number, isDragging: boolean) => void;
  step: (towards: "right" | "down" | "normal", samples: number) => void;
  zoom: (factor: number, x: number, y: number) => void; // About the place.
  pan: (x: number, y: number) => void; // By so many pixels.
  resetZoom: () => void;
  mark: (place: Place | null) => void; // A place to measure; null: the crosshair.
}

const wheelStep = 60; // Wheel pixels per sample.
const zoomStep = 1.25; // Per key.
const steps: Record<string, Parameters<SliceActions["step"]>> = {
  ArrowRight: ["right", 1],
  ArrowLeft: ["right", -1],
  ArrowDown: ["down", 1],
  ArrowUp: ["down", -1],
  PageUp: ["normal", 1],
  PageDown: ["normal", -1],
};

interface Place {
  x: number;
  y: number;
}

export function listenToSlice(canvas: HTMLCanvasElement, actions: SliceActions): void {
  const pressed = new Map<number, Place>(); // By pointer.
  let kind: "none" | "cross" | "pan" | "pinch" = "none";
  canvas.addEventListener("pointerdown", (event) => {
    if (event.button > 2) return;
    if (event.button === 1) event.preventDefault(); // The browser would scroll.
    canvas.setPointerCapture(event.pointerId);
    for (const { x, y } of pressed.values()) if (kind === "cross") actions.moveCross(x, y, false); // A second finger ends the drag.
    pressed.set(event.pointerId, placeOf(event));
    if (pressed.size > 1) kind = "pinch";
    else kind = event.button > 0 || event.shiftKey ? "pan" : "cross";
    if (kind === "cross") actions.moveCross(event.offsetX, event.offsetY, true);
  });
  canvas.addEventListener("pointermove", (event) => {
    const before = pressed.get(event.pointerId);
    if (!before) return;
    const now = placeOf(event);
    if (kind === "cross") actions.moveCross(now.x, now.y, true);
    if (kind === "pan") actions.pan(now.x - before.x, now.y - before.y);
    if (kind === "pinch") pinch(actions, before, now, [...pressed].find(([id]) => id !== event.pointerId)?.[1]);
    pressed.set(event.pointerId, now);
  });
  const end = (event: PointerEvent) => {
    if (!pressed.delete(event.pointerId)) return;
    if (kind === "cross") actions.moveCross(event.offsetX, event.offsetY, false);
    if (pressed.size === 0) kind = "none";
  };
  canvas.addEventListener("pointerup", end);
  canvas.addEventListener("pointercancel", end);
  canvas.addEventListener("contextmenu", (event) => event.preventDefault());
  canvas.addEventListener("dblclick", (event) => actions.mark(placeOf(event)));
  listenToWheel(canvas, actions);
  listenToKeys(canvas, actions);
}

function placeOf({ offsetX, offsetY }: MouseEvent): Place {
  return { x: offsetX, y: offsetY };
}

// One of two fingers moved: scales about their center, and moves it.
function pinch(actions: SliceActions, before: Place, now: Place, other: Place | undefined): void {
  if (!other) return;
  const distance = (one: Place) => Math.max(1, Math.hypot(one.x - other.x, one.y - other.y));
  actions.pan((now.x - before.x) / 2, (now.y - before.y) / 2);
  actions.zoom(distance(now) / distance(before), (now.x + other.x) / 2, (now.y + other.y) / 2);
}

function listenToWheel(canvas: HTMLCanvasElement, actions: SliceActions): void {
  let scrolled = 0;
  canvas.addEventListener(
    "wheel",
    (event) => {
      event.preventDefault();
      const pixels = event.deltaMode === 0 ? event.deltaY : wheelStep * Math.sign(event.deltaY);
      if (event.ctrlKey || event.metaKey) return actions.zoom(Math.exp(-pixels / 300), event.offsetX, event.offsetY);
      scrolled += pixels;
      const samples = Math.trunc(scrolled / wheelStep);
      scrolled -= samples * wheelStep;
      if (samples !== 0) actions.step("normal", -samples);
    },
    { passive: false },
  );
}

function listenToKeys(canvas: HTMLCanvasElement, actions: SliceActions): void {
  const zoom = (factor: number) => actions.zoom(factor, canvas.clientWidth / 2, canvas.clientHeight / 2);
  const acts: Record<string, () => void> = {
    "+": () => zoom(zoomStep),
    "=": () => zoom(zoomStep),
    "-": () => zoom(1 / zoomStep),
    f: () => actions.resetZoom(),
    m: () => actions.mark(null),
  };
  canvas.addEventListener("keydown", (event) => {
    const step = steps[event.key];
    const act = step ? () => actions.step(...step) : acts[event.key];
    if (!act || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    event.stopPropagation();
    act();
  });
}
