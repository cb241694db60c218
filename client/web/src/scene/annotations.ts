// The annotations of exported pictures: scale bar, numbers along the box, axes, legends with units, and measurements,
// all in their size on the screen.
import { gradientOf, type LegendText } from "../shared/color_maps";

export interface Annotations {
  scale: { pixels: number; text: string } | null; // CSS pixels.
  numbers: readonly AxisNumber[]; // Along the box of the data.
  axes: readonly AxisArm[]; // In drawing order.
  legends: LegendText[];
  points: { x: number; y: number; note: string }[]; // In CSS pixels from the upper left corner.
  words: string[]; // The description of the surfaces and the measurements.
  surfaces: SurfaceKey[]; // Below the description.
}

export interface SurfaceKey {
  color: string; // Empty: only a text.
  text: string;
}

// Positioned by its center, in CSS pixels from the upper left corner.
export interface AxisNumber {
  text: string;
  x: number;
  y: number;
}

// One end of a world axis.
export interface AxisArm {
  letter: string;
  axis: number;
  // Position of the end relative to the axes' origin: x right, y down; 1 is the full length.
  x: number;
  y: number;
  isBehind: boolean;
}

const margin = 16;
const legendLength = 200;
const legendHeight = 52; // With the space to the next one.
const arm = 30; // CSS pixels.
const axisColors = ["#d9534f", "#5cb85c", "#4f8fd9"];
const measured = "#ffd24a";

// `ratio`: canvas pixels per CSS pixel; `ink` and `paper`: colors of text and its outline.
export function annotate(
  context: CanvasRenderingContext2D,
  { scale, numbers, axes, legends, points, words, surfaces }: Annotations,
  ratio: number,
  ink: string,
  paper: string,
): void {
  context.save();
  context.scale(ratio, ratio);
  const [width, height] = [context.canvas.width / ratio, context.canvas.height / ratio];
  context.font = '13px system-ui, "Segoe UI", Roboto, "Noto Sans", sans-serif';
  context.lineJoin = "round";
  const write = (text: string, x: number, y: number, align: CanvasTextAlign) => {
    context.textAlign = align;
    context.strokeStyle = paper;
    context.lineWidth = 3;
    context.strokeText(text, x, y);
    context.fillStyle = ink;
    context.fillText(text, x, y);
  };
  for (const { text, x, y } of numbers) write(text, x, y + 4.5, "center");
  if (scale) {
    const [left, right] = [width - margin - scale.pixels, width - margin];
    const isBesideLegends = left >= margin + legendLength + margin; // Otherwise it lies above them.
    const bottom = height - margin - (isBesideLegends ? 0 : legendHeight * legends.length);
    context.strokeStyle = ink;
    context.lineWidth = 1.5;
    context.beginPath();
    for (const [x1, y1, x2, y2] of [
      [left, bottom - 8, left, bottom],
      [left, bottom - 4, right, bottom - 4],
      [right, bottom - 8, right, bottom],
    ]) {
      context.moveTo(x1, y1);
      context.lineTo(x2, y2);
    }
    context.stroke();
    write(scale.text, (left + right) / 2, bottom - 11, "center");
  }
  legends.forEach((legend, i) => drawLegend(context, legend, margin, height - margin - legendHeight * i, write));
  drawAxes(context, axes, margin + arm + 10, height - margin - arm - 10 - legendHeight * legends.length, ink, paper);
  drawPoints(context, points);
  for (const { x, y, note } of points) if (note) write(note, x + 13, y + 4.5, "left");
  words.forEach((text, i) => write(text, margin, margin + 12 + 18 * i, "left"));
  surfaces.forEach(({ color, text }, i) => {
    const bottom = margin + 16 + 18 * (words.length + i);
    context.fillStyle = color;
    if (color) context.fillRect(margin, bottom - 10, 11, 11);
    write(text, margin + 18, bottom, "left");
  });
  context.restore();
}

function drawLegend(
  context: CanvasRenderingContext2D,
  { name, low, high, map }: LegendText,
  x: number,
  bottom: number,
  write: (text: string, x: number, y: number, align: CanvasTextAlign) => void,
): void {
  const colors = gradientOf(map).match(/#[0-9a-f]{6}/g)!;
  const gradient = context.createLinearGradient(x, 0, x + legendLength, 0);
  colors.forEach((color, i) => gradient.addColorStop(i / (colors.length - 1), color));
  context.fillStyle = gradient;
  context.fillRect(x, bottom - 28, legendLength, 11);
  write(low, x, bottom - 3, "left");
  write(high, x + legendLength, bottom - 3, "right");
  if (name) write(name, x, bottom - 33, "left");
}

function drawAxes(context: CanvasRenderingContext2D, axes: readonly AxisArm[], x: number, y: number, ink: string, paper: string): void {
  context.textAlign = "center";
  for (const { letter, axis, x: right, y: down, isBehind } of axes) {
    context.globalAlpha = isBehind ? 0.55 : 1;
    context.strokeStyle = axisColors[axis];
    context.lineWidth = 2;
    context.beginPath();
    context.moveTo(x, y);
    context.lineTo(x + arm * right, y + arm * down);
    context.stroke();
    context.fillStyle = paper;
    context.lineWidth = 1;
    context.beginPath();
    context.arc(x + arm * right, y + arm * down, 9, 0, 2 * Math.PI);
    context.fill();
    context.stroke();
    context.fillStyle = ink;
    context.fillText(letter, x + arm * right, y + arm * down + 4.5);
  }
  context.globalAlpha = 1;
}

function drawPoints(context: CanvasRenderingContext2D, points: Annotations["points"]): void {
  context.strokeStyle = measured;
  context.lineWidth = 2.5;
  context.beginPath();
  for (const { x, y } of points) context.lineTo(x, y);
  context.stroke();
  context.textAlign = "center";
  points.forEach(({ x, y }, i) => {
    context.fillStyle = measured;
    context.beginPath();
    context.arc(x, y, 8, 0, 2 * Math.PI);
    context.fill();
    context.fillStyle = "#20160a";
    context.fillText("ABC"[i], x, y + 4.5);
  });
}
