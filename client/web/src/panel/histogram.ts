// The histogram of values, with a line at each isovalue that can be dragged or moved with arrow keys.
import type { DatasetInfo } from "../protocol/messages";
import { h } from "../shared/elements";
import { roundedWithin } from "../shared/quantities";

export interface HistogramEvents {
  // Called while dragging, and once with `isDragging` false at the end. `surface`: 0 for the first.
  moved: (surface: number, isovalue: number, isDragging: boolean) => void;
}

export type ValueRange = Pick<DatasetInfo, "min" | "max">;

export interface Isoline {
  surface: number; // 0 for the first. Surfaces of other datasets have no line.
  isovalue: number;
  color: string; // The surface's color.
}

const integerTypes = 4; // U8, I8, U16 and I16 precede the floats.
const steps: Record<string, number> = {
  ArrowLeft: -1,
  ArrowDown: -1,
  ArrowRight: 1,
  ArrowUp: 1,
  PageDown: -10,
  PageUp: 10,
};

export class HistogramView {
  readonly element: HTMLElement;
  private readonly canvas = h("canvas", { "aria-hidden": "true" });
  private readonly marks = h("div", { class: "isomarks", "aria-hidden": "true" });
  private readonly plot = h("div", {
    class: "histogram-plot",
    "data-tip": "How often each value occurs in the data. Drag a line to change the isovalue: its surface passes through all " + "places that have this value.",
  });
  private readonly handles: HTMLElement[] = []; // One per line.
  private readonly low = h("span");
  private readonly high = h("span");
  private readonly pointed = h("output", { class: "histogram-value", hidden: true, "aria-hidden": "true" }); // The value under the pointer.
  private info: DatasetInfo | null = null;
  private range = { min: 0, max: 1 }; // From left to right.
  private lines: readonly Isoline[] = [];
  private dragged = 0; // The surface whose line moved last.
  private isLog = true;
  private settle = 0;

  constructor(private readonly events: HistogramEvents) {
    this.plot.append(this.canvas, this.marks, this.pointed);
    this.element = h("div", { class: "histogram" }, this.plot, h("div", { class: "histogram-ends" }, this.low, this.high));
    this.listen();
    new ResizeObserver(() => this.redraw()).observe(this.plot);
  }

  // `range`: the values from left to right; for a series those of all times, so that lines do not move.
  show(info: DatasetInfo, lines: readonly Isoline[], isLog: boolean, range: ValueRange): void {
    const isNew = info !== this.info || isLog !== this.isLog || range.min !== this.range.min || range.max !== this.range.max;
    this.info = info;
    this.range = range;
    this.lines = lines;
    this.isLog = isLog;
    if (isNew) {
      this.redraw();
      this.marks.replaceChildren(...info.suggestedIsovalues.slice(0, 5).map((value) => h("span", { style: `left: ${this.percent(value)}` })));
    }
    this.low.textContent = valueText(range.min, range);
    this.high.textContent = valueText(range.max, range);
    for (const handle of this.handles.splice(lines.length)) handle.remove();
    lines.forEach((line, at) => this.showLine(line, at));
  }

  // Highlights the first line until a line was dragged.
  invite(isInviting: boolean): void {
    this.handles[0]?.classList.toggle("is-inviting", isInviting);
  }

  private showLine({ surface, isovalue, color }: Isoline, at: number): void {
    const { min, max } = this.range;
    const handle = (this.handles[at] ??= this.handle(at));
    handle.style.left = this.percent(isovalue);
    // A single surface uses the page's accent color.
    handle.style.setProperty("--line-color", this.lines.length > 1 ? color : "");
    handle.setAttribute("aria-label", this.lines.length > 1 ? `Isovalue of surface ${surface + 1}` : "Isovalue");
    handle.setAttribute("aria-valuemin", String(min));
    handle.setAttribute("aria-valuemax", String(max));
    handle.setAttribute("aria-valuenow", String(isovalue));
  }

  private handle(at: number): HTMLElement {
    const handle = h("div", { class: "isoline", role: "slider", tabindex: "0" }, h("span", { class: "isoline-grip" }));
    handle.addEventListener("keydown", (event) => {
      if (!this.info || !steps[event.key]) return;
      event.preventDefault();
      event.stopPropagation();
      const { min, max } = this.range;
      const step = Math.max((max - min) / 200, isInteger(this.info) ? 1 : 0);
      const { surface, isovalue: before } = this.lines[at];
      const isovalue = rounded(Math.min(max, Math.max(min, before + steps[event.key] * step)), this.info, this.range);
      this.events.moved(surface, isovalue, true);
      clearTimeout(this.settle);
      this.settle = window.setTimeout(() => this.events.moved(surface, isovalue, false), 250);
    });
    this.plot.append(handle);
    return handle;
  }

  private percent(value: number): string {
    return `${100 * this.share(value)}%`;
  }

  private share(value: number): number {
    const { min, max } = this.range;
    return Math.min(1, Math.max(0, (value - min) / (max - min || 1)));
  }

  private listen(): void {
    const { plot } = this;
    const shareAt = (event: PointerEvent) => {
      const box = plot.getBoundingClientRect();
      return Math.min(1, Math.max(0, (event.clientX - box.left) / box.width));
    };
    const valueAt = (event: PointerEvent) => {
      const { min, max } = this.range;
      return rounded(min + shareAt(event) * (max - min), this.info!, this.range);
    };
    const point = (event: PointerEvent) => {
      this.pointed.hidden = !this.info;
      if (!this.info) return;
      const share = shareAt(event);
      this.pointed.textContent = `${valueText(valueAt(event), this.range)}${this.info.valueUnit ? ` ${this.info.valueUnit}` : ""}`;
      this.pointed.style.insetInline = share < 0.5 ? `${100 * share}% auto` : `auto ${100 * (1 - share)}%`;
    };
    plot.addEventListener("pointerleave", () => (this.pointed.hidden = true));
    plot.addEventListener("pointerdown", (event) => {
      if (!this.info || event.button !== 0) return;
      plot.setPointerCapture(event.pointerId);
      plot.classList.add("is-dragging");
      this.dragged = this.nearest(shareAt(event));
      this.events.moved(this.dragged, valueAt(event), true);
    });
    plot.addEventListener("pointermove", (event) => {
      if (event.pointerType === "mouse") point(event);
      if (plot.hasPointerCapture(event.pointerId)) this.events.moved(this.dragged, valueAt(event), true);
    });
    const end = (event: PointerEvent) => {
      if (!plot.classList.contains("is-dragging")) return;
      plot.classList.remove("is-dragging");
      this.events.moved(this.dragged, valueAt(event), false);
    };
    plot.addEventListener("pointerup", end);
    plot.addEventListener("pointercancel", end);
  }

  private nearest(share: number): number {
    const far = this.lines.map(({ isovalue }) => Math.abs(this.share(isovalue) - share));
    return this.lines[far.indexOf(Math.min(...far))].surface;
  }

  redraw(): void {
    drawHistogram(this.canvas, this.info, this.range, this.isLog);
  }
}

// Draws in the next frame, at the canvas's size on the screen; nothing while it is hidden. At once, the browser would have to lay
// out the page before its surface is requested.
export function drawHistogram(canvas: HTMLCanvasElement, info: DatasetInfo | null, range: ValueRange, isLog: boolean): void {
  requestAnimationFrame(() => drawNow(canvas, info, range, isLog));
}

function drawNow(canvas: HTMLCanvasElement, info: DatasetInfo | null, range: ValueRange, isLog: boolean): void {
  const width = canvas.clientWidth;
  const height = canvas.clientHeight;
  if (!info || width === 0) return;
  const ratio = window.devicePixelRatio;
  canvas.width = Math.round(width * ratio);
  canvas.height = Math.round(height * ratio);
  // Draws on the CPU: a GPU busy with surfaces would block the page.
  const context = canvas.getContext("2d", { willReadFrequently: true })!;
  context.fillStyle = getComputedStyle(canvas).color;
  const heights = columns(info, range, canvas.width, isLog);
  context.beginPath();
  context.moveTo(0, canvas.height);
  heights.forEach((value, x) => {
    context.lineTo(x, canvas.height * (1 - 0.94 * value));
    context.lineTo(x + 1, canvas.height * (1 - 0.94 * value));
  });
  context.lineTo(canvas.width, canvas.height);
  context.fill();
}

function isInteger(info: DatasetInfo): boolean {
  return info.type <= integerTypes;
}

// Rounds between integers for integer data, so that no sample lies on the surface.
function rounded(value: number, info: DatasetInfo, { min, max }: ValueRange): number {
  if (isInteger(info)) return Math.min(max, Math.floor(value) + 0.5);
  return roundedWithin(value, (max - min) / 10);
}

function valueText(value: number, { min, max }: ValueRange): string {
  return String(roundedWithin(value, max - min));
}

// Returns a height from 0 to 1 for each pixel column. On a linear scale a bin that contains nearly all samples (air)
// would flatten the others, so it is cut off.
export function columns(info: Pick<DatasetInfo, "histogram">, { min, max }: ValueRange, width: number, isLog: boolean): number[] {
  const { counts, low, high } = info.histogram ?? { counts: [], low: 0, high: 1 };
  if (counts.length === 0) return [];
  const numbers = counts.map(Number);
  const sorted = [...numbers].sort((a, b) => b - a);
  const largest = isLog ? sorted[0] : Math.max(1, 1.15 * sorted[Math.min(3, sorted.length - 1)]);
  const scale = (n: number) => (isLog ? Math.log1p(n) / Math.log1p(largest || 1) : Math.min(1.1, n / (largest || 1)));
  // Columns outside the bins are empty, as when other times have other values.
  const binAt = (x: number) => {
    const value = min + (x / width) * (max - min);
    return Math.floor(((value - low) / (high - low || 1)) * counts.length);
  };
  return Array.from({ length: width }, (_, x) => {
    // The mean of the bins in the column.
    const first = binAt(x);
    const last = Math.max(first + 1, binAt(x + 1));
    const sum = numbers.slice(Math.max(0, first), Math.max(0, last)).reduce((total, count) => total + count, 0);
    return scale(sum / (last - first));
  });
}
