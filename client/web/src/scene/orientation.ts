// The axes of the world in their current orientation, with the patient's letters if the space is known. Each end is a
// button for the view from there. If the space is unknown, another button shows and switches the up axis.
import * as THREE from "three";
import { type DatasetInfo, WorldSpace } from "../protocol/messages";
import { button, h } from "../shared/elements";
import type { Vec3 } from "../stream/dataset";
import type { AxisArm } from "./annotations";
import { type AxisName, axisNames } from "./axis_names";
import type { Stage } from "./stage";

const upOrder: readonly Vec3[] = [
  [0, 0, 1],
  [0, 0, -1],
  [0, 1, 0],
  [0, -1, 0],
  [1, 0, 0],
  [-1, 0, 0],
];

export class Orientation {
  readonly element = h("div", { class: "orientation", role: "group", "aria-label": "Look from a side", hidden: true });
  private readonly turner = h("button", { type: "button", class: "turn-up", hidden: true });
  private names: AxisName[] = [];
  private ends: { button: HTMLElement; arm: HTMLElement; direction: THREE.Vector3 }[] = [];

  constructor(
    private readonly stage: Stage,
    private readonly lookFrom: (direction: THREE.Vector3) => void,
    turnUp: (up: Vec3) => void,
  ) {
    this.turner.addEventListener("click", () => turnUp(upOrder[(this.upAt() + 1) % upOrder.length]));
    stage.whenDrawn(() => this.follow());
  }

  setDataset(info: DatasetInfo): void {
    this.names = axisNames(info);
    this.turner.hidden = info.space !== WorldSpace.UNSPECIFIED;
    this.ends = this.names.map(({ letter, word, direction }, i) => {
      const towards = new THREE.Vector3(...direction);
      const words = { "aria-label": `Look from ${word}`, "data-tip": `Look from ${word}.` };
      const end = button(letter, () => this.lookFrom(towards), { class: `end axis-${"xyz"[i >> 1]}`, ...words });
      return { button: end, arm: h("span", { class: `arm axis-${"xyz"[i >> 1]}` }), direction: towards };
    });
    this.element.replaceChildren(...this.ends.map(({ arm }) => arm), ...this.ends.map(({ button }) => button), this.turner);
    this.element.hidden = false;
    this.follow();
  }

  show(isVisible: boolean): void {
    this.element.hidden = !isVisible || this.ends.length === 0;
  }

  // Returns the visible ends for pictures, far ones first: x right and y down, of length at most 1. Empty while hidden.
  get arms(): AxisArm[] {
    if (this.element.hidden) return [];
    const toEye = this.stage.activeCamera.quaternion.clone().invert();
    return this.names
      .map(({ letter, direction }, i) => ({ letter, axis: i >> 1, at: new THREE.Vector3(...direction).applyQuaternion(toEye) }))
      .sort((a, b) => a.at.z - b.at.z)
      .map(({ letter, axis, at }) => ({ letter, axis, x: at.x, y: -at.y, isBehind: at.z < -0.05 }));
  }

  // Returns the index in `upOrder` of the nearest axis.
  private upAt(): number {
    const { up } = this.stage.camera;
    const along = upOrder.map((axis) => up.dot(new THREE.Vector3(...axis)));
    return along.indexOf(Math.max(...along));
  }

  private showUp(): void {
    const place = (axis: Vec3) => this.names.find(({ direction }) => direction.every((part, i) => part === axis[i]))?.letter ?? "";
    const [now, next] = [0, 1].map((step) => place(upOrder[(this.upAt() + step) % upOrder.length]));
    const text = `up: ${now}`;
    if (this.turner.textContent === text) return;
    this.turner.textContent = text;
    this.turner.setAttribute("data-tip", `The file does not define which way is up. Click to turn ${next} up.`);
    this.turner.setAttribute("aria-label", `${now} is up; turn ${next} up`);
  }

  private follow(): void {
    if (this.element.hidden) return;
    this.showUp();
    const toEye = this.stage.activeCamera.quaternion.clone().invert();
    for (const { button, arm, direction } of this.ends) {
      const p = direction.clone().applyQuaternion(toEye);
      const arms = (count: number) => `calc(${count.toFixed(4)} * var(--arm))`; // Scales with the font size.
      button.style.transform = `translate(${arms(p.x)}, ${arms(-p.y)})`;
      button.style.zIndex = String(Math.round(10 + 9 * p.z));
      button.classList.toggle("is-behind", p.z < -0.05);
      arm.style.width = arms(Math.hypot(p.x, p.y));
      arm.style.transform = `rotate(${Math.atan2(-p.y, p.x).toFixed(4)}rad)`;
    }
  }
}
