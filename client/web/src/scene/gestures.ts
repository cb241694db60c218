// Gestures in a page that can be scrolled past the scene, as in embedded maps: the wheel zooms with Ctrl, two fingers
// rotate and zoom, and the rest is the page's. A hint says so when it is tried.
import * as THREE from "three";
import type { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";

import { h } from "../shared/elements";

const hintTime = 1600; // Milliseconds.
const wheelNotch = 50; // Pixels: trackpads send smaller steps when two fingers pinch, which the browser marks as Ctrl.

export class Gestures {
  readonly hint = h("p", { class: "gesture-hint", hidden: true });
  private isCooperative = false;
  private timer = 0;

  // `element` has the scene and the slices; `isGrabbed`: whether a handle in the scene is being dragged.
  constructor(
    element: HTMLElement,
    private readonly canvas: HTMLCanvasElement,
    private readonly controls: OrbitControls,
    private readonly isGrabbed: () => boolean,
  ) {
    element.addEventListener("wheel", (event) => this.wheel(event), { capture: true, passive: false });
    for (const kind of ["touchstart", "touchmove"] as const) canvas.addEventListener(kind, (event) => this.touch(event), { passive: false });
  }

  setCooperative(isCooperative: boolean): void {
    this.isCooperative = isCooperative;
    this.controls.touches = isCooperative ? { ONE: null, TWO: THREE.TOUCH.DOLLY_ROTATE } : { ONE: THREE.TOUCH.ROTATE, TWO: THREE.TOUCH.DOLLY_PAN };
    this.canvas.style.touchAction = isCooperative ? "pan-x pan-y" : "none";
  }

  private get isSharing(): boolean {
    return this.isCooperative && !document.fullscreenElement;
  }

  private wheel(event: WheelEvent): void {
    if (!this.isSharing || !event.isTrusted) return;
    if (!event.ctrlKey && !event.metaKey) {
      event.stopPropagation(); // The page scrolls.
      return this.show(`Use ${/Mac|iPhone|iPad/.test(navigator.platform) ? "⌘" : "Ctrl"} + scroll to zoom`);
    }
    if (event.target !== this.canvas || Math.abs(event.deltaY) < wheelNotch) return;
    // The controls take a wheel with Ctrl for a pinch, whose steps are ten times as large.
    event.stopPropagation();
    event.preventDefault();
    const { deltaY, deltaMode, clientX, clientY } = event;
    this.canvas.dispatchEvent(new WheelEvent("wheel", { deltaY, deltaMode, clientX, clientY, cancelable: true }));
  }

  private touch(event: TouchEvent): void {
    if (!this.isSharing) return;
    if (event.touches.length > 1 || this.isGrabbed()) return event.preventDefault();
    if (event.type === "touchmove") this.show("Use two fingers to rotate and zoom");
  }

  private show(text: string): void {
    this.hint.textContent = text;
    this.hint.hidden = false;
    clearTimeout(this.timer);
    this.timer = window.setTimeout(() => (this.hint.hidden = true), hintTime);
  }
}
