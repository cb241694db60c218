// The drawing over the samples of a slice view: the contours of surfaces, measured places, texts and the scale bar, in CSS
// pixels of the view.
import type { DatasetInfo } from "../protocol/messages";
import type { MeasuredPlace } from "../state/settings";
import { applied, lengthText, type Vec3 } from "../stream/dataset";
import { lengthBetween } from "./measures";
import type { PlaneAxes } from "./slice_grid";
import type { CutLines } from "./slice_plane";
import { roundLength } from "./ticks";

export type ToScreen = (world: readonly number[]) => [number, number];
export type Write = (text: string, x: number, y: number, align: CanvasTextAlign, color?: string) => void;

const measured = "#ffd24a";

// Returns a function that writes outlined text.
export function writerOn(context: CanvasRenderingContext2D): Write {
  context.font = '12px system-ui, "Segoe UI", Roboto, "Noto Sans", sans-serif';
  context.lineJoin = "round";
  return (text, x, y, align, color = "#ffffff") => {
    context.textAlign = align;
    context.strokeStyle = "#000000";
    context.lineWidth = 3;
    context.strokeText(text, x, y);
    context.fillStyle = color;
    context.fillText(text, x, y);
  };
}

export function drawLines(context: CanvasRenderingContext2D, lines: readonly CutLines[], toScreen: ToScreen): void {
  context.lineWidth = 1.5;
  for (const line of lines) {
    context.strokeStyle = line.color;
    context.beginPath();
    for (const [from, to] of segmentsOf(line)) {
      context.moveTo(...toScreen(from));
      context.lineTo(...toScreen(to));
    }
    context.stroke();
  }
}

// Draws the places that lie on the plane, and the lines between two of them with their lengths.
export function drawPlaces(
  context: CanvasRenderingContext2D,
  write: Write,
  places: readonly (MeasuredPlace & { isOnPlane: boolean })[],
  info: DatasetInfo,
  toScreen: ToScreen,
): void {
  const sides = places
    .slice(1)
    .map((to, i) => ({ from: places[i], to }))
    .filter(({ from, to }) => from.isOnPlane && to.isOnPlane);
  for (const { from, to } of sides) {
    context.strokeStyle = measured;
    context.lineWidth = 2;
    context.beginPath();
    context.moveTo(...toScreen(from.world));
    context.lineTo(...toScreen(to.world));
    context.stroke();
  }
  places.forEach(({ world, isOnPlane, note }, i) => {
    if (!isOnPlane) return;
    const [x, y] = toScreen(world);
    context.fillStyle = measured;
    context.beginPath();
    context.arc(x, y, 3.5, 0, 2 * Math.PI);
    context.fill();
    write(note ? `${"ABC"[i]} ${note}` : "ABC"[i], x + 7, y - 6, "left", measured);
  });
  for (const { from, to } of sides) {
    const [[x1, y1], [x2, y2]] = [toScreen(from.world), toScreen(to.world)];
    write(lengthBetween(from, to, info), (x1 + x2) / 2, (y1 + y2) / 2 + 16, "center", measured);
  }
}

// A bar of a round length in the upper right corner; `perUnit`: pixels per unit of length.
export function drawScaleBar(context: CanvasRenderingContext2D, write: Write, perUnit: number, width: number, info: DatasetInfo): void {
  const length = roundLength(Math.min(110, width / 4) / perUnit);
  if (!(length > 0) || !Number.isFinite(length)) return;
  const [end, y] = [width - 8, 12];
  const begin = end - length * perUnit;
  for (const [color, thickness] of [
    ["#000000", 4],
    ["#ffffff", 2],
  ] as const) {
    context.strokeStyle = color;
    context.lineWidth = thickness;
    context.beginPath();
    context.moveTo(begin, y);
    context.lineTo(end, y);
    context.stroke();
  }
  write(lengthText(length, info, 4), (begin + end) / 2, y + 16, "center");
}

// Returns the names of the labels whose contours enclose a place of the plane. A contour that the border of the data or
// of a region leaves open encloses only places where it is crossed an odd number of times on both sides.
export function labelsAt(world: Vec3, lines: readonly CutLines[], { right, down }: PlaneAxes): string[] {
  const [x, y] = [world[right.axis], world[down.axis]];
  const encloses = (line: CutLines) => {
    let [before, after] = [0, 0];
    for (const [from, to] of segmentsOf(line)) {
      const [y1, y2] = [from[down.axis] - y, to[down.axis] - y];
      if (y1 < 0 === y2 < 0) continue;
      const crossing = from[right.axis] + ((to[right.axis] - from[right.axis]) * y1) / (y1 - y2);
      if (crossing < x) ++before;
      else ++after;
    }
    return before % 2 === 1 && after % 2 === 1;
  };
  return lines.filter((line) => line.label && encloses(line)).map(({ label }) => label!);
}

// Yields both ends of each segment in world coordinates.
function* segmentsOf({ segments, toWorld }: CutLines): Generator<[Vec3, Vec3]> {
  for (let at = 0; at + 5 < segments.length; at += 6) {
    yield [applied(toWorld, [segments[at], segments[at + 1], segments[at + 2]]), applied(toWorld, [segments[at + 3], segments[at + 4], segments[at + 5]])];
  }
}
