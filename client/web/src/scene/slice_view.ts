// One of three linked slices: the samples on a plane perpendicular to a world axis, the lines where it cuts the
// surfaces, and a crosshair where the other planes meet it.
import { type DatasetInfo, WorldSpace } from "../protocol/messages";
import { type ColorScale, colorRow, fractionOf } from "../shared/color_maps";
import { h } from "../shared/elements";
import type { MeasuredPlace } from "../state/settings";
import { coordinateText, nearestSample, type Vec3, worldBox, worldSpacing } from "../stream/dataset";
import type { SliceGrid, SliceValues } from "../stream/dataset_queries";
import { axisNames } from "./axis_names";
import { drawLines, drawPlaces, drawScaleBar, labelsAt, type ToScreen, type Write, writerOn } from "./slice_drawing";
import { listenToSlice } from "./slice_gestures";
import { type Direction, gridCorners, type PlaneAxes, planeGrid, seenPart } from "./slice_grid";
import type { CutLines } from "./slice_plane";

const axisColors = ["#ff7a75", "#7fd67f", "#7fb4ff"]; // On gray.
const gap = 9; // CSS pixels around the crosshair's center.
const maxZoom = 64;

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

// A part of the planes that all views show.
export interface Zoom {
  factor: number; // 1 to 64; 1: each plane as large as fits.
  center: Vec3; // World coordinates.
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
  private zoom: Zoom | null = null;
  private scale: ColorScale = { map: "gray", low: 0, high: 1, isLog: false };
  private slice: SliceValues | null = null;
  private value = "";
  private lines: readonly CutLines[] = [];
  private labels: readonly string[] = []; // The names of those at the crosshair.
  private places: readonly MeasuredPlace[] = [];
  private readonly picture = h("canvas"); // The colors of the slice, one pixel each.
  private isPainted = false;
  private isDue = false;
  private readonly resizing = new ResizeObserver(() => this.invalidate());

  constructor(
    readonly axis: number,
    private readonly moved: (cross: Vec3, isDragging: boolean) => void,
    private readonly zoomed: (zoom: Zoom | null) => void,
    private readonly marked: (world: Vec3) => void, // A place to measure.
  ) {
    this.sides = planeAxes({ space: WorldSpace.UNSPECIFIED, lengthUnit: "" }, axis);
    this.resizing.observe(this.canvas);
    this.listen();
  }

  // `zoom` null: the whole plane.
  show(info: DatasetInfo, cross: Vec3, scale: ColorScale, zoom: Zoom | null, places: readonly MeasuredPlace[]): void {
    const { map, low, high, isLog } = this.scale;
    if (map !== scale.map || low !== scale.low || high !== scale.high || isLog !== scale.isLog) this.isPainted = false;
    [this.info, this.cross, this.scale, this.zoom, this.places] = [info, cross, scale, zoom, places];
    this.sides = planeAxes(info, this.axis);
    this.showLines(this.lines);
  }

  private describe(info: DatasetInfo): void {
    this.canvas.setAttribute(
      "aria-label",
      `${planeName(info, this.axis)} slice, ${this.placeText()}. Click to move the crosshair, scroll to change the slice; arrow keys, Page up and Page down do the same. Plus and minus zoom. Double-click to measure, or M at the crosshair.`,
    );
  }

  showSlice(slice: SliceValues | null): void {
    this.slice = slice;
    this.isPainted = false;
    if (!slice) this.lines = this.labels = [];
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
    if (!this.info) return;
    this.labels = labelsAt(this.cross, lines, this.sides);
    this.describe(this.info);
    this.invalidate();
  }

  close(): void {
    this.resizing.disconnect();
    this.isDue = true; // Prevents further frames.
  }

  // Returns whether zooming hides a place of the plane.
  hides(world: Vec3): boolean {
    if (!this.info || !this.zoom) return false;
    const [x, y] = this.toScreen(world);
    return x < 0 || y < 0 || x > this.canvas.clientWidth || y > this.canvas.clientHeight;
  }

  // Returns the grid of the samples that are needed.
  grid(spacing: Vec3): SliceGrid {
    const { zoom, canvas, place, sides } = this;
    const box = worldBox(this.info!);
    const seen: [number, number] = [canvas.clientWidth / place.width, canvas.clientHeight / place.height];
    const { low, high } = zoom ? seenPart(box, sides, zoom.center, seen, spacing) : box;
    return planeGrid(low, high, sides, this.cross[this.axis], spacing);
  }

  // The data's rectangle in the view, in CSS pixels: as large as fits, or zoomed.
  private get place(): Rectangle {
    const { right, down } = this.sides;
    const { low, high } = worldBox(this.info!);
    const [across, along] = [high[right.axis] - low[right.axis], high[down.axis] - low[down.axis]];
    const { clientWidth, clientHeight } = this.canvas;
    const scale = (this.zoom?.factor ?? 1) * Math.min(clientWidth / (across || 1), clientHeight / (along || 1));
    const [width, height] = [scale * across, scale * along];
    const centered = (side: Direction) => (this.zoom ? this.share(this.zoom.center, side) : 0.5);
    return { x: clientWidth / 2 - width * centered(right), y: clientHeight / 2 - height * centered(down), width, height };
  }

  // The part of it that is seen.
  private get seen(): Rectangle {
    const { x, y, width, height } = this.place;
    const { clientWidth, clientHeight } = this.canvas;
    const [left, top] = [Math.max(0, x), Math.max(0, y)];
    return { x: left, y: top, width: Math.min(clientWidth, x + width) - left, height: Math.min(clientHeight, y + height) - top };
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

  // Returns `start` moved to (x, y) of the view, within the data.
  private worldAt(x: number, y: number, start: Vec3): Vec3 {
    const { low, high } = worldBox(this.info!);
    const place = this.place;
    const world: Vec3 = [...start];
    const set = ({ axis, sign }: Direction, part: number) => {
      const share = Math.min(1, Math.max(0, sign > 0 ? part : 1 - part));
      world[axis] = low[axis] + share * (high[axis] - low[axis]);
    };
    set(this.sides.right, (x - place.x) / (place.width || 1));
    set(this.sides.down, (y - place.y) / (place.height || 1));
    return world;
  }

  // Moves the crosshair to the sample at (x, y).
  private moveCross(x: number, y: number, isDragging: boolean): void {
    if (!this.info) return;
    const cross = this.worldAt(x, y, this.cross);
    for (const { axis } of [this.sides.right, this.sides.down]) cross[axis] = nearestSample(this.info, axis, cross[axis]);
    this.moved(cross, isDragging);
  }

  private step({ axis, sign }: Direction, samples: number): void {
    if (!this.info) return;
    const cross: Vec3 = [...this.cross];
    cross[axis] = nearestSample(this.info, axis, cross[axis] + sign * samples * worldSpacing(this.info)[axis]);
    this.moved(cross, false);
  }

  // Zooms about (x, y): what is there stays there.
  private zoomAt(scale: number, x: number, y: number): void {
    if (!this.info) return;
    const { low, high } = worldBox(this.info);
    const { factor, center } = this.zoom ?? { factor: 1, center: low.map((from, axis) => (from + high[axis]) / 2) as Vec3 };
    const next = Math.min(maxZoom, factor * scale);
    if (next <= 1) return this.zoomed(null);
    const fixed = this.worldAt(x, y, center);
    this.zoomed({ factor: next, center: fixed.map((at, axis) => at + ((center[axis] - at) * factor) / next) as Vec3 });
  }

  private pan(x: number, y: number): void {
    if (!this.info || !this.zoom) return;
    const { clientWidth, clientHeight } = this.canvas;
    this.zoomed({ ...this.zoom, center: this.worldAt(clientWidth / 2 - x, clientHeight / 2 - y, this.zoom.center) });
  }

  private listen(): void {
    listenToSlice(this.canvas, {
      moveCross: (x, y, isDragging) => this.moveCross(x, y, isDragging),
      step: (towards, samples) => this.step(towards === "normal" ? { axis: this.axis, sign: 1 } : this.sides[towards], samples),
      zoom: (factor, x, y) => this.zoomAt(factor, x, y),
      pan: (x, y) => this.pan(x, y),
      resetZoom: () => this.zoomed(null),
      mark: (place) => this.info && this.marked(place ? this.worldAt(place.x, place.y, this.cross) : this.cross),
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
    if (!context) return;
    context.scale(ratio, ratio);
    this.drawOn(context);
  }

  // Draws the view from (0, 0) to its size on the screen, in CSS pixels.
  drawOn(context: CanvasRenderingContext2D): void {
    if (!this.info || this.canvas.clientWidth === 0) return;
    const toScreen: ToScreen = (world) => this.toScreen(world);
    if (this.slice) {
      if (!this.isPainted) paint(this.picture, this.slice, this.scale);
      this.isPainted = true;
      this.drawSlice(context, this.slice);
    }
    drawLines(context, this.lines, toScreen);
    this.drawCross(context, this.seen);
    const write = writerOn(context);
    drawPlaces(
      context,
      write,
      this.places.map((one) => ({ ...one, isOnPlane: this.isOnPlane(one.world) })),
      this.info,
      toScreen,
    );
    this.drawWords(context, write, this.seen);
  }

  // Returns whether a place is nearer to the plane than the next samples are.
  private isOnPlane(world: Vec3): boolean {
    return Math.abs(world[this.axis] - this.cross[this.axis]) <= worldSpacing(this.info!)[this.axis] / 2;
  }

  // From the center of the first pixel to that of the last.
  private drawSlice(context: CanvasRenderingContext2D, { grid }: SliceValues): void {
    const corners = gridCorners(grid);
    const [[x, y], [endX, endY]] = [this.toScreen(corners[0]), this.toScreen(corners[3])];
    const { width, height } = grid;
    context.drawImage(this.picture, 0.5, 0.5, Math.max(0.5, width - 1), Math.max(0.5, height - 1), x, y, endX - x, endY - y);
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

  private drawWords(context: CanvasRenderingContext2D, write: Write, { x, y, width, height }: Rectangle): void {
    const { clientWidth, clientHeight } = this.canvas;
    const info = this.info!;
    const names = axisNames(info);
    const letter = ({ axis, sign }: Direction, isEnd: boolean) => names[2 * axis + (sign > 0 === isEnd ? 0 : 1)].letter;
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
    const { low, high } = worldBox(info);
    drawScaleBar(context, write, this.place.width / (high[right.axis] - low[right.axis]), clientWidth, info);
  }

  // "z 12.5 mm: 345 HU, Liver"
  private placeText(): string {
    const place = `${"xyz"[this.axis]} ${coordinateText(this.cross[this.axis], this.info!)}`;
    const found = [this.value, ...this.labels].filter((text) => text !== "").join(", ");
    return found ? `${place}: ${found}` : place;
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
