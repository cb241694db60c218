// How often values occur, with a line at the isovalue that one drags. Arrow keys move it as well.
import type { DatasetInfo } from "../protocol/messages";
import { h, inDigits } from "./dom";

export interface HistogramEvents {
  // While dragging, and once more with `isDragging` false when it ends.
  moved: (isovalue: number, isDragging: boolean) => void;
}

const integerTypes = 4; // U8, I8, U16, I16 come before the floats.

export class HistogramView {
  readonly element: HTMLElement;
  private readonly canvas = h("canvas", { "aria-hidden": "true" });
  private readonly line = h("div", { class: "isoline" }, h("span", { class: "isoline-grip" }));
  private readonly marks = h("div", { class: "isomarks", "aria-hidden": "true" });
  private readonly low = h("span");
  private readonly high = h("span");
  private info: DatasetInfo | null = null;
  private isovalue = 0;
  private isLog = true;
  private settle = 0;

  constructor(private readonly events: HistogramEvents) {
    const plot = h("div", {
      class: "histogram-plot",
      tabindex: "0",
      role: "slider",
      "aria-label": "Isovalue",
      "data-tip":
        "How often each value occurs in the data. Drag the line: the surface runs through all " +
        "places that have this value.",
    });
    plot.append(this.canvas, this.marks, this.line);
    this.element = h("div", { class: "histogram" }, plot,
      h("div", { class: "histogram-ends" }, this.low, this.high));
    this.listen(plot);
    new ResizeObserver(() => this.draw()).observe(plot);
  }

  show(info: DatasetInfo, isovalue: number, isLog: boolean): void {
    const isNew = info !== this.info || isLog !== this.isLog;
    this.info = info;
    this.isovalue = isovalue;
    this.isLog = isLog;
    if (isNew) {
      this.draw();
      this.marks.replaceChildren(...info.suggestedIsovalues.slice(0, 5).map((value) =>
        h("span", { style: `left: ${this.percent(value)}` })));
    }
    this.low.textContent = inDigits(info.min);
    this.high.textContent = inDigits(info.max);
    this.line.style.left = this.percent(isovalue);
    const plot = this.element.firstElementChild!;
    plot.setAttribute("aria-valuemin", String(info.min));
    plot.setAttribute("aria-valuemax", String(info.max));
    plot.setAttribute("aria-valuenow", String(isovalue));
  }

  redraw(): void {
    this.draw();
  }

  // Draws the eye to the line until it was dragged once.
  invite(isInviting: boolean): void {
    this.line.classList.toggle("is-inviting", isInviting);
  }

  private percent(value: number): string {
    const { min, max } = this.info!;
    return `${100 * Math.min(1, Math.max(0, (value - min) / (max - min || 1)))}%`;
  }

  private listen(plot: HTMLElement): void {
    const valueAt = (event: PointerEvent) => {
      const box = plot.getBoundingClientRect();
      const at = Math.min(1, Math.max(0, (event.clientX - box.left) / box.width));
      const { min, max } = this.info!;
      return rounded(min + at * (max - min), this.info!);
    };
    plot.addEventListener("pointerdown", (event) => {
      if (!this.info || event.button !== 0) return;
      plot.setPointerCapture(event.pointerId);
      plot.classList.add("is-dragging");
      this.events.moved(valueAt(event), true);
    });
    plot.addEventListener("pointermove", (event) => {
      if (plot.hasPointerCapture(event.pointerId)) this.events.moved(valueAt(event), true);
    });
    const end = (event: PointerEvent) => {
      if (!plot.classList.contains("is-dragging")) return;
      plot.classList.remove("is-dragging");
      this.events.moved(valueAt(event), false);
    };
    plot.addEventListener("pointerup", end);
    plot.addEventListener("pointercancel", end);
    plot.addEventListener("keydown", (event) => {
      const steps: Record<string, number> = {
        ArrowLeft: -1, ArrowDown: -1, ArrowRight: 1, ArrowUp: 1, PageDown: -10, PageUp: 10,
      };
      if (!this.info || !steps[event.key]) return;
      event.preventDefault();
      event.stopPropagation();
      const { min, max } = this.info;
      const step = Math.max((max - min) / 200, isInteger(this.info) ? 1 : 0);
      const moved = this.isovalue + steps[event.key] * step;
      const isovalue = rounded(Math.min(max, Math.max(min, moved)), this.info);
      this.events.moved(isovalue, true);
      clearTimeout(this.settle);
      this.settle = window.setTimeout(() => this.events.moved(isovalue, false), 250);
    });
  }

  private draw(): void {
    const { canvas, info } = this;
    const width = canvas.clientWidth;
    const height = canvas.clientHeight;
    if (!info || width === 0) return;
    const ratio = window.devicePixelRatio;
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(height * ratio);
    const context = canvas.getContext("2d")!;
    context.fillStyle = getComputedStyle(canvas).color;
    const heights = columns(info, canvas.width, this.isLog);
    context.beginPath();
    context.moveTo(0, canvas.height);
    heights.forEach((value, x) => {
      context.lineTo(x, canvas.height * (1 - 0.94 * value));
      context.lineTo(x + 1, canvas.height * (1 - 0.94 * value));
    });
    context.lineTo(canvas.width, canvas.height);
    context.fill();
  }
}

function isInteger(info: DatasetInfo): boolean {
  return info.type <= integerTypes;
}

// Between the integers where the data has only those: there no sample lies on the surface.
function rounded(value: number, info: DatasetInfo): number {
  if (isInteger(info)) return Math.min(info.max, Math.floor(value) + 0.5);
  return Number(value.toPrecision(5));
}

// One height for each column of pixels, 0 to 1. One bin that holds nearly everything (air) would
// hide all others on a linear scale: there it runs out of the picture.
function columns(info: DatasetInfo, width: number, isLog: boolean): number[] {
  const { counts, low, high } = info.histogram ?? { counts: [], low: 0, high: 1 };
  if (counts.length === 0) return [];
  const numbers = counts.map(Number);
  const sorted = [...numbers].sort((a, b) => b - a);
  const largest = isLog ? sorted[0] : Math.max(1, 1.15 * sorted[Math.min(3, sorted.length - 1)]);
  const scale = (n: number) =>
    isLog ? Math.log1p(n) / Math.log1p(largest || 1) : Math.min(1.1, n / (largest || 1));
  const binAt = (x: number) => {
    const value = info.min + (x / width) * (info.max - info.min);
    const bin = Math.floor(((value - low) / (high - low || 1)) * counts.length);
    return Math.min(counts.length - 1, Math.max(0, bin));
  };
  return Array.from({ length: width }, (_, x) => {
    // Where bins are narrower than a column: the mean of them.
    const first = binAt(x);
    const last = Math.max(first + 1, binAt(x + 1));
    const sum = numbers.slice(first, last).reduce((total, count) => total + count, 0);
    return scale(sum / (last - first));
  });
}
