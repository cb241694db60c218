// The surroundings of the surfaces: the box of the data, numbers along three of its edges, and a scale bar, in the unit
// of the dataset's spacing.
import * as THREE from "three";
import type { DatasetInfo } from "../protocol/messages";
import { h } from "../shared/elements";
import { applied, lengthText, type Vec3 } from "../stream/dataset";
import type { AxisNumber } from "./annotations";
import { disposeTree } from "./dispose_tree";
import type { Stage } from "./stage";
import { roundLength, ticks } from "./ticks";
import { wideLines } from "./wide_lines";

const axisColors = [0xd9534f, 0x5cb85c, 0x4f8fd9];
const apart = 46; // The least distance between two numbers, in CSS pixels.
const outwards = 16; // From an edge to its numbers.
const inPictures = ".legend, .orientation .end, .scale-bar";
const over = `${inPictures}, .tools button, .stage-hint, .times, .picked, .notice`;

// An edge of the box that may have numbers.
interface Edge {
  from: THREE.Vector3;
  to: THREE.Vector3;
  low: number; // The numbers at its ends: world coordinates, or lengths if the box is oblique.
  high: number;
}

export class SceneDecorations {
  readonly scaleBar = h("div", { class: "scale-bar", "data-tip": "A length at the depth of the center of the picture, in the unit of the dataset's spacing." });
  readonly numbers = h("div", { class: "axis-numbers", "aria-hidden": "true" });
  private readonly box = new THREE.Group();
  private readonly labels: HTMLElement[] = [];
  private written: AxisNumber[] = [];
  private edges: Edge[][] = [[], [], []]; // Four per axis.
  private middle = new THREE.Vector3();
  private dataset: DatasetInfo | null = null; // Null: lengths have no meaning yet.

  constructor(private readonly stage: Stage) {
    stage.scene.add(this.box);
    stage.whenDrawn(() => {
      this.drawScale();
      this.drawNumbers();
    });
  }

  setDataset(info: DatasetInfo): void {
    disposeTree(this.box);
    this.dataset = info;
    const corner = (bits: number): Vec3 =>
      applied(
        info.indexToWorld,
        info.dims.map((n, axis) => (bits & (1 << axis) ? n - 1 : 0)),
      );
    this.middle
      .set(...corner(0))
      .add(new THREE.Vector3(...corner(7)))
      .multiplyScalar(0.5);
    this.edges = [0, 1, 2].map((axis) =>
      [0, 1, 2, 3, 4, 5, 6, 7]
        .filter((bits) => !(bits & (1 << axis)))
        .map((bits) => edgeOf(new THREE.Vector3(...corner(bits)), new THREE.Vector3(...corner(bits | (1 << axis))))),
    );
    for (const [axis, edges] of this.edges.entries()) {
      edges.forEach(({ from, to }, i) => this.box.add(lineOf(from, to, i === 0 ? axisColors[axis] : null)));
    }
    this.show(this.box.visible);
    this.stage.invalidate();
  }

  show(isVisible: boolean): void {
    const isHidden = !isVisible || !this.dataset;
    if (isVisible === this.box.visible && isHidden === this.scaleBar.hidden) return;
    this.box.visible = isVisible;
    this.scaleBar.hidden = this.numbers.hidden = isHidden;
    this.stage.invalidate();
  }

  // The length of the scale bar in CSS pixels; null: not shown.
  get scale(): { pixels: number; text: string } | null {
    const pixels = parseFloat(this.scaleBar.style.width);
    return this.scaleBar.hidden || !(pixels > 0) ? null : { pixels, text: this.scaleBar.textContent ?? "" };
  }

  // The numbers for exported pictures, which have no tools.
  get visibleNumbers(): readonly AxisNumber[] {
    const isFree = this.freePlaces(inPictures);
    return this.numbers.hidden ? [] : this.written.filter(({ text, x, y }) => isFree(x, y, halfWidthOf(text), 7));
  }

  private drawScale(): void {
    if (!this.dataset) return;
    const length = roundLength(this.stage.worldLengthOf(110));
    const pixels = length / this.stage.worldLengthOf(1);
    if (!Number.isFinite(pixels)) return;
    this.scaleBar.style.width = `${pixels.toFixed(1)}px`;
    const text = lengthText(length, this.dataset, 4);
    if (this.scaleBar.textContent !== text) this.scaleBar.textContent = text;
  }

  private drawNumbers(): void {
    if (this.numbers.hidden) return;
    this.written = [];
    const isFree = this.freePlaces(over);
    const center = this.stage.project(this.middle);
    for (const edges of center ? this.edges : []) {
      const seen = edges.map(({ from, to }) => [this.stage.project(from), this.stage.project(to)] as const);
      const best = outermost(seen, center!);
      if (best < 0) continue;
      const [a, b] = seen[best] as [Place, Place];
      const { low, high } = edges[best];
      const length = Math.hypot(b.x - a.x, b.y - a.y);
      if (length < 2 * apart) continue;
      // Perpendicular to the edge, away from the box's center.
      const side = Math.sign((b.x - a.x) * (center!.y - a.y) - (b.y - a.y) * (center!.x - a.x)) || 1;
      const [nx, ny] = [(side * (b.y - a.y)) / length, (-side * (b.x - a.x)) / length];
      for (const { value, text } of ticks(Math.min(low, high), Math.max(low, high), Math.min(6, length / apart))) {
        const share = (value - low) / (high - low);
        const x = a.x + share * (b.x - a.x) + outwards * nx;
        const y = a.y + share * (b.y - a.y) + outwards * ny;
        this.write(text, x, y, isFree);
      }
    }
    for (const label of this.labels.slice(this.written.length)) label.hidden = true;
  }

  // Returns whether numbers are legible at a place: not under another element over the scene, and not cut off.
  private freePlaces(over: string): IsFree {
    const frame = this.numbers.getBoundingClientRect();
    const covers = [...(this.numbers.parentElement?.querySelectorAll(over) ?? [])].map((one) => one.getBoundingClientRect());
    return (x, y, halfWidth, halfHeight) => {
      const [left, right, top, bottom] = [x - halfWidth, x + halfWidth, y - halfHeight, y + halfHeight];
      if (left < 0 || right > frame.width || top < 0 || bottom > frame.height) return false;
      return covers.every(
        (box) => frame.left + left > box.right || frame.left + right < box.left || frame.top + top > box.bottom || frame.top + bottom < box.top,
      );
    };
  }

  // Unless it would overlap another number.
  private write(text: string, x: number, y: number, isFree: IsFree): void {
    if (this.written.some((other) => Math.abs(other.y - y) < 14 && Math.abs(other.x - x) < 4 * (text.length + other.text.length))) return;
    const at = this.written.push({ text, x, y }) - 1;
    const label = (this.labels[at] ??= this.numbers.appendChild(h("span")));
    label.hidden = !isFree(x, y, halfWidthOf(text), 7);
    if (label.textContent !== text) label.textContent = text;
    label.style.transform = `translate(${x.toFixed(1)}px, ${y.toFixed(1)}px) translate(-50%, -50%)`;
  }
}

type IsFree = (x: number, y: number, halfWidth: number, halfHeight: number) => boolean;

function halfWidthOf(text: string): number {
  return 4 * text.length;
}

interface Place {
  x: number;
  y: number;
}

// Returns the edge whose center is farthest from the box's center on the screen, preferring lower ones: nothing is
// behind its numbers. -1: not all are in front of the eye.
function outermost(seen: (readonly [Place | null, Place | null])[], center: Place): number {
  let best = -1;
  let farthest = -Infinity;
  seen.forEach(([a, b], i) => {
    if (!a || !b) return;
    const [x, y] = [(a.x + b.x) / 2 - center.x, (a.y + b.y) / 2 - center.y];
    const far = Math.hypot(x, y) + 0.4 * y - 0.1 * x;
    if (far <= farthest) return;
    farthest = far;
    best = i;
  });
  return best;
}

function edgeOf(from: THREE.Vector3, to: THREE.Vector3): Edge {
  const along = to.clone().sub(from);
  const length = along.length();
  const axis = along.toArray().findIndex((part) => Math.abs(part) > 0.99999 * length);
  if (axis < 0) return { from, to, low: 0, high: length };
  return { from, to, low: from.getComponent(axis), high: to.getComponent(axis) };
}

function lineOf(from: THREE.Vector3, to: THREE.Vector3, color: number | null): THREE.Object3D {
  const line = wideLines([...from.toArray(), ...to.toArray()], { color: color ?? 0x808a96, width: 1, opacity: color === null ? 0.32 : 1 });
  line.material.depthWrite = false;
  return line;
}
