// The scene view: lights and background. Draws a frame after changes, and none otherwise.
//
// Frames during motion must be fast; at rest one more is drawn with full quality. Effects that are cheap are in both.
import * as THREE from "three";

import { ContextKeeper } from "./context_keeper";
import { areSamePlanes } from "./cut_plane";
import { gpuFinished } from "./gpu_fence";
import { Lights } from "./lights";
import { OrbitView } from "./orbit_view";
import { Programs } from "./programs";
import { type FrameOptions, SceneRenderer } from "./scene_renderer";
import type { VolumePass, VolumeQuality } from "./volume/volume_pass";

export interface StageLook {
  isOrthographic: boolean;
  hasOcclusion: boolean;
  translucent: number; // Number of translucent surfaces.
  clip: THREE.Plane[]; // Clip planes of the surfaces.
}

const extensions = ["EXT_texture_filter_anisotropic", "EXT_color_buffer_float", "OES_texture_float_linear", "WEBGL_multisampled_render_to_texture"];
const restAfter = 180; // Milliseconds without a change.
const delays = { picture: 500, work: 100 }; // Milliseconds.
const maxMotionCost = 20; // Milliseconds of GPU time: acceptable during motion.
const maxOcclusionCost = 4000; // Milliseconds: a frame this slow is not drawn at all.
const peels = { moving: 3, resting: 6, limit: 12 };

export class Stage extends OrbitView {
  readonly scene = new THREE.Scene();
  readonly renderer: THREE.WebGLRenderer;
  readonly context: ContextKeeper;
  private readonly lights = new Lights();
  private readonly sceneRenderer: SceneRenderer;
  readonly programs: Programs;
  volume: VolumePass | null = null;
  private look: StageLook = { isOrthographic: false, hasOcclusion: false, translucent: 0, clip: [] };
  private occlusionCost: number | null = null; // Milliseconds of a frame with occlusion; null: unknown.
  private restTimer = 0;
  private pictureTimer = 0;
  private workTimer = 0;
  private isDue = false; // A frame is scheduled.
  private isChanged = false; // It redraws the picture.
  private size = { width: 0, height: 0 }; // CSS pixels.
  // Work done in small parts, one per frame; returns true if some was done or is left.
  private readonly frameTasks: (() => boolean)[] = [];
  private readonly afterFrame: (() => void)[] = [];
  private readonly pending: (() => boolean)[] = [];
  private readonly resizing = new ResizeObserver(() => this.resize());

  // `contextGone`: the browser took the scene's context away for good.
  constructor(canvas: HTMLCanvasElement, contextGone: () => void) {
    super(canvas);
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: true, alpha: true });
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
    this.renderer.setClearColor(0x000000, 0);
    this.renderer.debug.checkShaderErrors = import.meta.env.DEV; // It waits for the GPU, and fails without a context.
    this.renderer.localClippingEnabled = true; // Materials have clip planes.
    this.sceneRenderer = new SceneRenderer(this.renderer);
    this.programs = new Programs(this.renderer, this.scene, this.camera, this.sceneRenderer.targets, () => this.invalidate());
    // Queried now, while nothing is being drawn: later it would block the page until drawing is done.
    for (const name of extensions) this.renderer.extensions.has(name);
    this.context = new ContextKeeper(this.renderer, canvas, {
      gone: contextGone,
      restored: () => {
        this.programs.forget();
        this.invalidate();
      },
    });
    this.scene.add(this.lights.group);
    this.resizing.observe(canvas.parentElement!);
    this.resize();
  }

  invalidate(): void {
    this.isChanged = true;
    this.wake();
  }

  // Schedules a frame for work that does not change the picture.
  wake(): void {
    if (this.isDue) return;
    this.isDue = true;
    requestAnimationFrame(() => this.frame());
  }

  // Both do the same after a delay, once for all calls until then.
  invalidateSoon(): void {
    this.pictureTimer ||= window.setTimeout(() => this.invalidate(), delays.picture);
  }
  wakeSoon(): void {
    this.workTimer ||= window.setTimeout(() => this.wake(), delays.work);
  }

  setLook(look: StageLook): void {
    if (isSameLook(look, this.look)) return;
    this.look = look;
    this.isOrthographic = look.isOrthographic;
    this.invalidate();
  }

  everyFrame(task: () => boolean): void {
    this.frameTasks.push(task);
  }

  whenDrawn(listener: () => void): void {
    this.afterFrame.push(listener);
  }

  // While `isDataPending` returns true, more data is being fetched and decoded: frames at rest, which take seconds with
  // software rendering, wait until then.
  waitFor(isDataPending: () => boolean): void {
    this.pending.push(isDataPending);
  }

  // Draws the scene with full quality and without handles into a new canvas, on a background or transparent;
  // `enlargement` times the screen size, within the GPU's limits.
  picture(background: string | null, enlargement = 1): HTMLCanvasElement {
    const ratio = this.renderer.getPixelRatio();
    const maxEnlargement = this.renderer.capabilities.maxTextureSize / Math.max(1, this.canvas.width, this.canvas.height);
    if (enlargement !== 1) this.renderer.setPixelRatio(ratio * Math.min(enlargement, Math.max(1, maxEnlargement)));
    this.draw("picture", false);
    const copy = document.createElement("canvas");
    copy.width = this.canvas.width;
    copy.height = this.canvas.height;
    const context = copy.getContext("2d")!;
    if (background !== null) {
      context.fillStyle = background;
      context.fillRect(0, 0, copy.width, copy.height);
    }
    context.drawImage(this.canvas, 0, 0);
    if (enlargement !== 1) {
      this.renderer.setPixelRatio(ratio);
      this.invalidate();
    }
    return copy;
  }

  // Returns the enlargement for a picture of this width.
  enlargementTo(width: number): number {
    return (width + 0.01) / (this.size.width * this.renderer.getPixelRatio()); // The fraction is cut off.
  }

  // Frees the GPU.
  dispose(): void {
    clearTimeout(this.restTimer);
    this.isDue = this.isChanged = true; // Prevents further frames.
    this.controls.dispose();
    this.resizing.disconnect();
    this.context.dispose();
    this.renderer.dispose();
    this.renderer.forceContextLoss();
  }

  private frame(): void {
    clearTimeout(this.workTimer);
    this.workTimer = 0;
    this.isDue = false;
    const isMoving = this.controls.update();
    const isBusy = this.frameTasks.map((task) => task()).some(Boolean);
    if (!this.programs.areReady("scene", () => this.scene)) return;
    if (isBusy) this.sceneRenderer.upload(this.scene, this.activeCamera);
    if (isMoving) this.invalidate();
    else if (isBusy) this.wake();
    if (!this.isChanged) return;
    clearTimeout(this.pictureTimer);
    this.pictureTimer = 0;
    this.isChanged = isMoving;
    this.draw("moving");
    for (const listener of this.afterFrame) listener();
    clearTimeout(this.restTimer);
    if (!isMoving && !this.isQuick()) this.scheduleRest();
  }

  // Returns whether frames during motion have full quality.
  private isQuick(): boolean {
    const { hasOcclusion, translucent } = this.look;
    return translucent === 0 && (this.volume?.isQuick ?? true) && (!hasOcclusion || (this.occlusionCost ?? Infinity) <= maxMotionCost);
  }

  private scheduleRest(): void {
    this.restTimer = window.setTimeout(() => void this.drawAtRest(), restAfter);
  }

  private async drawAtRest(): Promise<void> {
    const timer = this.restTimer;
    await gpuFinished(this.renderer);
    if (this.isChanged || timer !== this.restTimer) return; // Another frame or another rest follows.
    if (this.pending.some((isDataPending) => isDataPending()) || this.isDue) return this.scheduleRest();
    const begin = performance.now();
    this.draw("resting");
    if (this.look.hasOcclusion) {
      await gpuFinished(this.renderer, 4);
      this.occlusionCost = performance.now() - begin;
    }
    await this.volume?.measuring;
    if (this.volumeToDraw("resting")?.pass.isFinerAtRest && !this.isChanged && timer === this.restTimer) this.scheduleRest();
  }

  private draw(quality: VolumeQuality, hasHandles = true): void {
    const isAtRest = quality !== "moving";
    const { radius } = this.sphere;
    this.updateCameras();
    this.lights.follow(this.camera);
    const cost = this.occlusionCost ?? 0;
    const isOccluded = this.look.hasOcclusion && (isAtRest ? cost < maxOcclusionCost : this.isQuick());
    this.sceneRenderer.draw(this.scene, this.activeCamera, {
      occlusion: isOccluded ? { radius: Math.min(0.12 * radius, this.worldLengthOf(90)), clip: this.look.clip } : null,
      peels: this.peels(isAtRest),
      volume: this.volumeToDraw(quality),
      hasHandles,
    });
  }

  private volumeToDraw(quality: VolumeQuality): FrameOptions["volume"] {
    const { volume: pass, programs } = this;
    const isReady = pass?.isWanted && programs.areReady("volume", () => pass.object, true);
    return isReady && pass.isShown ? { pass, quality } : null;
  }

  // Returns the number of passes: most pixels have few overlapping surfaces, even if there are many.
  private peels(isAtRest: boolean): number {
    const { translucent } = this.look;
    if (translucent === 0) return 0;
    return isAtRest ? Math.min(peels.limit, Math.max(peels.resting, 2 * translucent)) : peels.moving;
  }

  private resize(): void {
    const { clientWidth: width, clientHeight: height } = this.canvas.parentElement!;
    if (width === 0 || height === 0 || (width === this.size.width && height === this.size.height)) return;
    this.size = { width, height };
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    if (this.programs.areReady("scene", () => this.scene)) this.draw("moving");
    this.invalidate();
  }
}

function isSameLook(one: StageLook, other: StageLook): boolean {
  return (
    one.isOrthographic === other.isOrthographic &&
    one.hasOcclusion === other.hasOcclusion &&
    one.translucent === other.translucent &&
    areSamePlanes(one.clip, other.clip)
  );
}
