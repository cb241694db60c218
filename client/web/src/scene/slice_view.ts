// One of three linked slices: the samples on a plane perpendicular to a world axis, the lines where it cuts the
// surfaces, and a crosshair where the other planes meet it. A click or drag moves the crosshair, the wheel the plane.
import { type DatasetInfo, WorldSpace } from "../protocol/messages";
import { colorRow, type ColorScale, fractionOf } from "../shared/color_maps";
import { h } from "../shared/elements";
import { applied, lengthText, type Vec3, voxelLength, worldBox } from "../stream/dataset";
import type { SliceValues } from "../stream/dataset_queries";
import { axisNames } from "./axis_names";
import type { Direction, PlaneAxes } from "./slice_grid";
import type { CutLines } from "./slice_plane";
import { roundLength } from "./ticks";

const axisColors = ["#ff7a75", "#7fd67f", "#7fb4ff"]; // On gray.
const gap = 9; // CSS pixels around the crosshair's center.
const wheelStep = 60; // Wheel pixels per sample.

// Medical convention: the patient's left on the right, the front on the left or at the top, the head at the top.
// Microscopes: as images, y and z downwards. Otherwise x grows to the right, and y or z upwards.
export function planeAxes({ space, lengthUnit }: Pick<DatasetInfo, "space" | "lengthUnit">, axis: number): PlaneAxes {
  const isRas = space === WorldSpace.RAS;
  const isImage = space === WorldSpace.UNSPECIFIED && (lengthUnit === "µm" || lengthUnit === "nm");
  const x: Direction = { axis: 0, sign: isRas ? -1 : 1 };
  const z: Direction = { axis: 2, sign: isImage ? 1 : -1 };
  if (axis === 2) return { axis, right: x, down: { axis: 1, sign: space === WorldSpace.LPS || isImage ? 1 : -1 } };
  if (axis === 1) return { axis, right: x, down: z };
  return { axis, right: { axis: 1, sign: isRas ? -1 : 1 }, down: z };
}

export function planeName({ space }: Pick<DatasetInfo, "space">, axis: number): string {
  return space === WorldSpace.UNSPECIFIED ? `Across ${"xyz"[axis]}` : ["Sagittal", "Coronal", "Axial"][axis];
}

interface Rectangle {
  x: number;
  y: number;
  width: number;
  height: number;
}

export class SliceView {
  readonly canvas = h("canvas", { class: "slice-view", tabindex: "0", role: "application" });
  private info: DatasetInfo | null = null;
  private sides: PlaneAxes;
  private cross: Vec3 = [0, 0, 0];
  private scale: ColorScale = { map: "gray", low: 0, high: 1, isLog: false };
  private slice: SliceValues | null = null;
  private value = "";
  private lines: readonly CutLines[] = [];
  private readonly picture = h("canvas"); // The colors of the slice, one pixel each.
  private isPainted = false;
  private isDue = false;
  private scrolled = 0;
  private readonly resizing = new ResizeObserver(() => this.invalidate());

  constructor(readonly axis: number, private readonly moved: (cross: Vec3, isDragging: boolean) => void) {
    this.sides = planeAxes({ space: WorldSpace.UNSPECIFIED, lengthUnit: "" }, axis);
    this.resizing.observe(this.canvas);
    this.listen();
  }

  show(info: DatasetInfo, cross: Vec3, scale: ColorScale): void {
    const { map, low, high, isLog } = this.scale;
    if (map !== scale.map || low !== scale.low || high !== scale.high || isLog !== scale.isLog) this.isPainted = false;
    [this.info, this.cross, this.scale] = [info, cross, scale];
    this.sides = planeAxes(info, this.axis);
    this.describe(info);
    this.invalidate();
  }

  private describe(info: DatasetInfo): void {
    this.canvas.setAttribute("aria-label",
      `${planeName(info, this.axis)} slice, ${this.placeText()}. Click to move the crosshair, scroll to change the slice; arrow keys, Page up and Page down do the same.`);
  }

  showSlice(slice: SliceValues | null): void {
    this.slice = slice;
    this.isPainted = false;
    if (!slice) this.lines = [];
    this.invalidate();
  }

  // The value at the crosshair; empty: unknown.
  showValue(value: string): void {
    this.value = value;
    if (this.info) this.describe(this.info);
    this.invalidate();
  }

  showLines(lines: readonly CutLines[]): void {
    this.lines = lines;
    this.invalidate();
  }

  close(): void {
    this.resizing.disconnect();
    this.isDue = true; // Prevents further frames.
  }

  // The data's rectangle in the view, in CSS pixels: as large as fits.
  private get place(): Rectangle {
    const { right, down } = this.sides;
    const { low, high } = worldBox(this.info!);
    const [across, along] = [high[right.axis] - low[right.axis], high[down.axis] - low[down.axis]];
    const { clientWidth, clientHeight } = this.canvas;
    const scale = Math.min(clientWidth / (across || 1), clientHeight / (along || 1));
    const [width, height] = [scale * across, scale * along];
    return { x: (clientWidth - width) / 2, y: (clientHeight - height) / 2, width, height };
  }

  private toScreen(world: readonly number[]): [number, number] {
    const { x, y, width, height } = this.place;
    return [x + width * this.share(world, this.sides.right), y + height * this.share(world, this.sides.down)];
  }

  // 0 to 1 along a side of the box.
  private share(world: readonly number[], { axis, sign }: Direction): number {
    const { low, high } = worldBox(this.info!);
    const share = (world[axis] - low[axis]) / (high[axis] - low[axis] || 1);
    return sign > 0 ? share : 1 - share;
  }

  // Returns the crosshair moved to (x, y), within the data.
  private crossAt(x: number, y: number): Vec3 {
    const { low, high } = worldBox(this.info!);
    const place = this.place;
    const cross: Vec3 = [...this.cross];
    const set = ({ axis, sign }: Direction, part: number) => {
      const share = Math.min(1, Math.max(0, sign > 0 ? part : 1 - part));
      cross[axis] = low[axis] + share * (high[axis] - low[axis]);
    };
    set(this.sides.right, (x - place.x) / (place.width || 1));
    set(this.sides.down, (y - place.y) / (place.height || 1));
    return cross;
  }

  private step(axis: number, voxels: number, isDragging: boolean): void {
    const { low, high } = worldBox(this.info!);
    const cross: Vec3 = [...this.cross];
    cross[axis] = Math.min(high[axis], Math.max(low[axis], cross[axis] + voxels * voxelLength(this.info!)));
    this.moved(cross, isDragging);
  }

  private listen(): void {
    const { canvas } = this;
    const move = (event: PointerEvent, isDragging: boolean) => this.info && this.moved(this.crossAt(event.offsetX, event.offsetY), isDragging);
    canvas.addEventListener("pointerdown", (event) => {
      if (event.button !== 0) return;
      canvas.setPointerCapture(event.pointerId);
      move(event, true);
    });
    canvas.addEventListener("pointermove", (event) => canvas.hasPointerCapture(event.pointerId) && move(event, true));
    canvas.addEventListener("pointerup", (event) => canvas.hasPointerCapture(event.pointerId) && move(event, false));
    canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      this.scrolled += event.deltaMode === 0 ? event.deltaY : wheelStep * Math.sign(event.deltaY);
      const steps = Math.trunc(this.scrolled / wheelStep);
      this.scrolled -= steps * wheelStep;
      if (this.info && steps !== 0) this.step(this.axis, -steps, false);
    }, { passive: false });
    canvas.addEventListener("keydown", (event) => {
      const { right, down } = this.sides;
      const steps: Record<string, [number, number]> = {
        ArrowRight: [right.axis, right.sign], ArrowLeft: [right.axis, -right.sign], ArrowDown: [down.axis, down.sign],
        ArrowUp: [down.axis, -down.sign], PageUp: [this.axis, 1], PageDown: [this.axis, -1],
      };
      const step = steps[event.key];
      if (!step || !this.info) return;
      event.preventDefault();
      event.stopPropagation();
      this.step(...step, false);
    });
  }

  private invalidate(): void {
    if (this.isDue) return;
    this.isDue = true;
    requestAnimationFrame(() => {
      this.isDue = false;
      this.draw();
    });
  }

  private draw(): void {
    const { canvas } = this;
    const ratio = Math.min(window.devicePixelRatio, 2);
    canvas.width = Math.round(canvas.clientWidth * ratio);
    canvas.height = Math.round(canvas.clientHeight * ratio);
    // Draws on the CPU: the GPU is busy with surfaces.
    const context = canvas.getContext("2d", { willReadFrequently: true });
    if (!context || !this.info || canvas.width === 0) return;
    context.scale(ratio, ratio);
    const { x, y, width, height } = this.place;
    if (this.slice) {
      if (!this.isPainted) paint(this.picture, this.slice, this.scale);
      this.isPainted = true;
      context.drawImage(this.picture, x, y, width, height);
    }
    this.drawLines(context);
    this.drawCross(context, this.place);
    this.drawWords(context, this.place);
  }

  private drawLines(context: CanvasRenderingContext2D): void {
    context.lineWidth = 1.5;
    for (const { segments, toWorld, color } of this.lines) {
      context.strokeStyle = color;
      context.beginPath();
      for (let at = 0; at + 5 < segments.length; at += 6) {
        context.moveTo(...this.toScreen(applied(toWorld, [segments[at], segments[at + 1], segments[at + 2]])));
        context.lineTo(...this.toScreen(applied(toWorld, [segments[at + 3], segments[at + 4], segments[at + 5]])));
      }
      context.stroke();
    }
  }

  // Each line has the color of the axis perpendicular to its plane.
  private drawCross(context: CanvasRenderingContext2D, { x, y, width, height }: Rectangle): void {
    const [atX, atY] = this.toScreen(this.cross);
    const line = (color: string, ...ends: number[]) => {
      context.strokeStyle = color;
      context.beginPath();
      context.moveTo(ends[0], ends[1]);
      context.lineTo(ends[2], ends[3]);
      context.stroke();
    };
    context.lineWidth = 1;
    const [upright, level] = [axisColors[this.sides.right.axis], axisColors[this.sides.down.axis]];
    line(upright, atX, y, atX, Math.max(y, atY - gap));
    line(upright, atX, Math.min(y + height, atY + gap), atX, y + height);
    line(level, x, atY, Math.max(x, atX - gap), atY);
    line(level, Math.min(x + width, atX + gap), atY, x + width, atY);
  }

  private drawWords(context: CanvasRenderingContext2D, { x, y, width, height }: Rectangle): void {
    const { clientHeight } = this.canvas;
    const info = this.info!;
    context.font = '12px system-ui, "Segoe UI", Roboto, "Noto Sans", sans-serif';
    context.lineJoin = "round";
    const write = (text: string, atX: number, atY: number, align: CanvasTextAlign, color = "#ffffff") => {
      context.textAlign = align;
      context.strokeStyle = "#000000";
      context.lineWidth = 3;
      context.strokeText(text, atX, atY);
      context.fillStyle = color;
      context.fillText(text, atX, atY);
    };
    const names = axisNames(info);
    const letter = ({ axis, sign }: Direction, isEnd: boolean) => names[2 * axis + ((sign > 0) === isEnd ? 0 : 1)].letter;
    const { right, down } = this.sides;
    const [name, place] = [planeName(info, this.axis), this.placeText()];
    // Letters above and below the data if there is space; not on a text, in narrow views.
    const besides = (text: string) => (8 + context.measureText(text).width > x + width / 2 ? 18 : 0);
    const [above, below] = [y - 6 - besides(name) > 12, clientHeight - y - height - besides(place) > 24];
    write(letter(right, false), x + 6, y + height / 2 - 6, "left");
    write(letter(right, true), x + width - 6, y + height / 2 - 6, "right");
    write(letter(down, false), x + width / 2 + 6, above ? y - 6 : Math.max(y + 16, 18 + besides(name)), "left");
    write(letter(down, true), x + width / 2 + 6, below ? y + height + 16 : Math.min(y + height, clientHeight - besides(place)) - 8, "left");
    write(name, 8, 18, "left", axisColors[this.axis]);
    write(place, 8, clientHeight - 8, "left");
    this.drawScaleBar(context, write);
  }

  private drawScaleBar(context: CanvasRenderingContext2D, write: (text: string, x: number, y: number, align: CanvasTextAlign) => void): void {
    const { low, high } = worldBox(this.info!);
    const axis = this.sides.right.axis;
    const perUnit = this.place.width / (high[axis] - low[axis]);
    const { clientWidth } = this.canvas;
    const length = roundLength(Math.min(110, clientWidth / 4) / perUnit);
    if (!(length > 0) || !Number.isFinite(length)) return;
    const [end, y] = [clientWidth - 8, 12];
    const begin = end - length * perUnit;
    for (const [color, thickness] of [["#000000", 4], ["#ffffff", 2]] as const) {
      context.strokeStyle = color;
      context.lineWidth = thickness;
      context.beginPath();
      context.moveTo(begin, y);
      context.lineTo(end, y);
      context.stroke();
    }
    write(lengthText(length, this.info!, 4), (begin + end) / 2, y + 16, "center");
  }

  // "z 12.5 mm: 345 HU"
  private placeText(): string {
    const place = `${"xyz"[this.axis]} ${lengthText(this.cross[this.axis], this.info!, 5)}`;
    return this.value ? `${place}: ${this.value}` : place;
  }
}

// Places without a value stay transparent.
function paint(canvas: HTMLCanvasElement, { grid: { width, height }, values }: SliceValues, scale: ColorScale): void {
  canvas.width = width;
  canvas.height = height;
  const image = new ImageData(width, height);
  const colors = new Uint32Array(colorRow(scale.map, 256).buffer);
  const pixels = new Uint32Array(image.data.buffer);
  for (let i = 0; i < pixels.length; ++i) {
    if (!Number.isNaN(values[i])) pixels[i] = colors[Math.round(255 * Math.min(1, Math.max(0, fractionOf(values[i], scale))))];
  }
  canvas.getContext("2d", { willReadFrequently: true })!.putImageData(image, 0, 0);
}
