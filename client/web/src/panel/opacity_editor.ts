// The opacities of a volume as a line over the histogram of values. Its points are dragged; a click elsewhere adds one, and
// a double click or Delete removes it.
import type { DatasetInfo } from "../protocol/messages";
import { opacityAt } from "../scene/volume/opacities";
import { h } from "../shared/elements";
import { inDigits, roundedWithin } from "../shared/quantities";
import { maxOpacityPoints, type OpacityPoint } from "../state/settings";
import { drawHistogram } from "./histogram";

type Points = readonly OpacityPoint[];

const steps: Record<string, [number, number]> = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowDown: [0, -1], ArrowUp: [0, 1] };
const curveSteps = 100; // Of the line, which is bent because small opacities have more space.
const reach = 14; // CSS pixels around a point that belong to it.

export class OpacityEditor {
  readonly element: HTMLElement;
  private readonly canvas = h("canvas", { "aria-hidden": "true" });
  private readonly line = document.createElementNS("http://www.w3.org/2000/svg", "svg");
  private readonly polyline = this.line.appendChild(document.createElementNS("http://www.w3.org/2000/svg", "polyline"));
  private readonly handles: HTMLElement[] = []; // One per point.
  private readonly plot = h("div", {
    class: "opacities",
    "data-tip": "The opacity of each value: drag the points; a click adds one, and a double click removes it. Small opacities have more space.",
  });
  private readonly low = h("span");
  private readonly high = h("span");
  private info: DatasetInfo | null = null;
  private points: Points = [];
  private dragged = -1;

  constructor(private readonly changed: (points: Points, isDragging: boolean) => void) {
    this.line.setAttribute("viewBox", "0 0 100 100");
    this.line.setAttribute("preserveAspectRatio", "none");
    this.polyline.setAttribute("vector-effect", "non-scaling-stroke");
    this.plot.append(this.canvas, this.line);
    this.element = h("div", { class: "histogram", role: "group", "aria-label": "Opacities by value" }, this.plot);
    this.element.append(h("div", { class: "histogram-ends" }, this.low, this.high));
    this.listen();
    new ResizeObserver(() => this.draw()).observe(this.plot);
  }

  show(info: DatasetInfo, points: Points): void {
    const isOther = info !== this.info;
    this.info = info;
    this.points = points;
    if (isOther) this.draw();
    this.low.textContent = this.text(info.min);
    this.high.textContent = this.text(info.max);
    for (const handle of this.handles.splice(points.length)) handle.remove();
    points.forEach((point, at) => this.showPoint(point, at));
    const between = Array.from({ length: curveSteps + 1 }, (_, i) => info.min + (i / curveSteps) * (info.max - info.min));
    const curve = [...points, ...between.map((value) => ({ value, opacity: opacityAt(points, value) }))].sort((a, b) => a.value - b.value);
    const places = curve.map(({ value, opacity }) => `${100 * this.share(value)},${100 * (1 - heightOf(opacity))}`);
    this.polyline.setAttribute("points", places.join(" "));
  }

  private draw(): void {
    if (this.info) drawHistogram(this.canvas, this.info, this.info, true);
  }

  private showPoint({ value, opacity }: OpacityPoint, at: number): void {
    const handle = (this.handles[at] ??= this.handle(at));
    handle.style.left = `${100 * this.share(value)}%`;
    handle.style.top = `${100 * (1 - heightOf(opacity))}%`;
    handle.setAttribute("aria-valuenow", String(opacity));
    handle.setAttribute("aria-valuetext", `opacity ${inDigits(opacity, 2)} at ${this.text(value)}`);
  }

  private handle(at: number): HTMLElement {
    const label = `Opacity point ${at + 1}`;
    const handle = h("div", { class: "opacity-point", role: "slider", tabindex: "0", "aria-label": label, "aria-valuemin": "0", "aria-valuemax": "1" });
    handle.addEventListener("keydown", (event) => {
      const step = steps[event.key];
      if (!step && event.key !== "Delete") return;
      event.preventDefault();
      event.stopPropagation();
      if (!step) return this.remove(at);
      const { value, opacity } = this.points[at];
      const { min, max } = this.info!;
      this.move(at, value + (step[0] * (max - min)) / 200, opacityOf(heightOf(opacity) + 0.02 * step[1]), false);
    });
    handle.addEventListener("dblclick", () => this.remove(at));
    this.plot.append(handle);
    return handle;
  }

  private remove(at: number): void {
    if (this.points.length > 1)
      this.changed(
        this.points.filter((_, other) => other !== at),
        false,
      );
  }

  // Points stay in order.
  private move(at: number, value: number, opacity: number, isDragging: boolean): void {
    const { min, max } = this.info!;
    const [low, high] = [this.points[at - 1]?.value ?? min, this.points[at + 1]?.value ?? max];
    const moved = { value: Math.min(high, Math.max(low, roundedWithin(value, (max - min) / 10))), opacity: Number(opacity.toPrecision(3)) };
    this.points = this.points.map((point, other) => (other === at ? moved : point));
    this.changed(this.points, isDragging);
  }

  private listen(): void {
    const { plot } = this;
    const placeOf = (event: PointerEvent) => {
      const box = plot.getBoundingClientRect();
      const within = (part: number) => Math.min(1, Math.max(0, part));
      const { min, max } = this.info!;
      const value = min + within((event.clientX - box.left) / box.width) * (max - min);
      return { value, opacity: opacityOf(within((box.bottom - event.clientY) / box.height)), box };
    };
    plot.addEventListener("pointerdown", (event) => {
      if (!this.info || event.button !== 0) return;
      plot.setPointerCapture(event.pointerId);
      const { value, opacity, box } = placeOf(event);
      const far = this.points.map((point) =>
        Math.hypot((this.share(point.value) - this.share(value)) * box.width, (heightOf(point.opacity) - heightOf(opacity)) * box.height),
      );
      this.dragged = far.indexOf(Math.min(...far));
      if (far[this.dragged] <= reach) return this.handles[this.dragged].focus({ preventScroll: true });
      if (this.points.length >= maxOpacityPoints) return void (this.dragged = -1);
      const next = this.points.findIndex((point) => point.value > value);
      this.dragged = next < 0 ? this.points.length : next;
      this.points = [...this.points.slice(0, this.dragged), { value, opacity: opacityAt(this.points, value) }, ...this.points.slice(this.dragged)];
      this.move(this.dragged, value, opacity, true);
    });
    plot.addEventListener("pointermove", (event) => {
      if (this.dragged < 0 || !plot.hasPointerCapture(event.pointerId)) return;
      const { value, opacity } = placeOf(event);
      this.move(this.dragged, value, opacity, true);
    });
    const end = () => {
      if (this.dragged >= 0) this.changed(this.points, false);
      this.dragged = -1;
    };
    plot.addEventListener("pointerup", end);
    plot.addEventListener("pointercancel", end);
  }

  private share(value: number): number {
    const { min, max } = this.info!;
    return Math.min(1, Math.max(0, (value - min) / (max - min || 1)));
  }

  private text(value: number): string {
    const { min, max } = this.info!;
    return String(roundedWithin(value, max - min));
  }
}

// Small opacities matter most: thousands of samples may lie behind each other.
function heightOf(opacity: number): number {
  return opacity ** (1 / 3);
}
function opacityOf(height: number): number {
  return Math.min(1, Math.max(0, height)) ** 3;
}
