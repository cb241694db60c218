// The scene view: camera, lights and background. Draws a frame after changes, and none otherwise.
//
// Frames during motion must be fast; at rest one more is drawn with full quality. Effects that are cheap are in both.
import * as THREE from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";

import type { Vec3 } from "../stream/dataset";
import type { View } from "../stream/request";
import { ContextKeeper } from "./context_keeper";
import { boxBetween } from "./crop";
import { areSamePlanes } from "./cut_plane";
import { nudgedFromUp, snappedToAxis } from "./directions";
import { gpuFinished } from "./gpu_fence";
import { Lights } from "./lights";
import type { SceneCamera } from "./occlusion";
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

export class Stage {
  readonly scene = new THREE.Scene();
  readonly camera = new THREE.PerspectiveCamera(35, 1, 0.1, 1000);
  readonly renderer: THREE.WebGLRenderer;
  readonly controls: OrbitControls;
  private readonly orthographicCamera = new THREE.OrthographicCamera(); // Follows `camera`.
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
  private readonly sphere = new THREE.Sphere(new THREE.Vector3(), 1);
  private isDue = false; // A frame is scheduled.
  private isChanged = false; // It redraws the picture.
  private size = { width: 0, height: 0 }; // CSS pixels.
  // Work done in small parts, one per frame; returns true if some was done or is left.
  private readonly frameTasks: (() => boolean)[] = [];
  private readonly afterFrame: (() => void)[] = [];
  private readonly pending: (() => boolean)[] = [];
  private readonly resizing = new ResizeObserver(() => this.resize());

  // `contextGone`: the browser took the scene's context away for good.
  constructor(
    private readonly canvas: HTMLCanvasElement,
    contextGone: () => void,
  ) {
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: true, alpha: true });
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
    this.renderer.setClearColor(0x000000, 0);
    this.renderer.debug.checkShaderErrors = import.meta.env.DEV; // It waits for the GPU, and fails without a context.
    this.renderer.localClippingEnabled = true; // Materials have clip planes.
    this.camera.up.set(0, 0, 1);
    this.orthographicCamera.up.copy(this.camera.up);
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
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.dampingFactor = 0.12;
    this.controls.enableDamping = !matchMedia("(prefers-reduced-motion: reduce)").matches;
    this.controls.addEventListener("change", () => this.invalidate());
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
    this.invalidate();
  }

  // The current camera, for rays and projections.
  get activeCamera(): SceneCamera {
    return this.look.isOrthographic ? this.orthographicCamera : this.camera;
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

  // Sets the box of the data, which determines the camera's depth range.
  setBounds(box: { low: Vec3; high: Vec3 }): void {
    boxBetween(box).getBoundingSphere(this.sphere);
    this.controls.maxDistance = 20 * this.sphere.radius;
    this.controls.minDistance = 0.002 * this.sphere.radius;
  }

  // From the front, slightly from the side and from above: patients look along -y with z up.
  defaultView(): void {
    this.lookFrom(this.upright([0.55, -1, 0.32]));
  }

  // Rotates a direction given for z up to the current up axis.
  upright(direction: readonly [number, number, number]): THREE.Vector3 {
    const turn = new THREE.Quaternion().setFromUnitVectors(new THREE.Vector3(0, 0, 1), this.camera.up);
    return new THREE.Vector3(...direction).applyQuaternion(turn);
  }

  // Sets the up direction; the eye does not move.
  setUp(up: Vec3): void {
    this.camera.up.set(...up).normalize();
    this.orthographicCamera.up.copy(this.camera.up);
    // The controls read the direction when they are constructed and cannot change it.
    const { _quat, _quatInverse } = this.controls as unknown as Record<"_quat" | "_quatInverse", THREE.Quaternion>;
    _quat.setFromUnitVectors(this.camera.up, new THREE.Vector3(0, 1, 0));
    _quatInverse.copy(_quat).invert();
    this.controls.update();
    this.invalidate();
  }

  // Returns the up direction after the picture is rotated clockwise.
  upAfterRoll(radians: number): Vec3 {
    const ahead = this.controls.target.clone().sub(this.camera.position).normalize();
    const up = new THREE.Vector3(0, 1, 0).applyQuaternion(this.camera.quaternion).applyAxisAngle(ahead, -radians);
    return snappedToAxis(up).toArray();
  }

  lookFrom(towards: THREE.Vector3): void {
    const direction = nudgedFromUp(towards, this.camera.up);
    const { center, radius } = this.sphere;
    const half = THREE.MathUtils.degToRad(this.camera.fov / 2);
    const narrow = Math.min(half, Math.atan(Math.tan(half) * this.camera.aspect));
    const distance = (0.93 * radius) / Math.sin(narrow);
    this.camera.position.copy(center).addScaledVector(direction.clone().normalize(), distance);
    this.controls.target.copy(center);
    this.controls.update();
    this.invalidate();
  }

  // Fits the box to the view; keeps the view direction. Ignores empty boxes.
  frameBox(box: THREE.Box3): void {
    if (box.isEmpty()) return;
    const direction = this.camera.position.clone().sub(this.controls.target).normalize();
    const target = box.getCenter(new THREE.Vector3());
    const right = new THREE.Vector3().crossVectors(this.camera.up, direction).normalize();
    const up = new THREE.Vector3().crossVectors(direction, right);
    const slope = Math.tan(THREE.MathUtils.degToRad(this.camera.fov / 2)) * 0.9;
    let distance = 0;
    for (let corner = 0; corner < 8; ++corner) {
      const p = new THREE.Vector3(corner & 1 ? box.max.x : box.min.x, corner & 2 ? box.max.y : box.min.y, corner & 4 ? box.max.z : box.min.z).sub(target);
      const across = Math.abs(p.dot(right)) / (slope * this.camera.aspect);
      const upwards = Math.abs(p.dot(up)) / slope;
      distance = Math.max(distance, p.dot(direction) + Math.max(across, upwards));
    }
    this.camera.position.copy(target).addScaledVector(direction, distance);
    this.controls.target.copy(target);
    this.controls.update();
    this.invalidate();
  }

  setView(eye: Vec3, target: Vec3): void {
    this.camera.position.set(...eye);
    this.controls.target.set(...target);
    this.controls.update();
    this.invalidate();
  }

  // Rotates around the target by radians and moves closer by a factor.
  rotate(azimuth: number, elevation: number, factor = 1): void {
    const offset = this.camera.position.clone().sub(this.controls.target);
    const upright = new THREE.Quaternion().setFromUnitVectors(this.camera.up, new THREE.Vector3(0, 1, 0));
    const s = new THREE.Spherical().setFromVector3(offset.applyQuaternion(upright));
    s.theta += azimuth;
    s.phi = Math.min(Math.PI - 0.02, Math.max(0.02, s.phi - elevation));
    s.radius *= factor;
    offset.setFromSpherical(s).applyQuaternion(upright.invert());
    this.camera.position.copy(this.controls.target).add(offset);
    this.controls.update();
    this.invalidate();
  }

  view(): View {
    return {
      eye: this.camera.position.toArray(),
      target: this.controls.target.toArray(),
      up: this.camera.up.toArray(),
      fieldOfView: this.camera.fov,
      heightPixels: Math.max(1, this.renderer.domElement.height),
      aspect: this.camera.aspect,
    };
  }

  // Returns the world length of CSS pixels at the target.
  worldLengthOf(pixels: number): number {
    const distance = this.camera.position.distanceTo(this.controls.target);
    const height = 2 * distance * Math.tan(THREE.MathUtils.degToRad(this.camera.fov / 2));
    return (pixels * height) / Math.max(1, this.canvas.clientHeight);
  }

  // Returns the ray through a place on the canvas, in CSS pixels from its corner.
  rayAt(x: number, y: number): THREE.Ray {
    const ndc = new THREE.Vector2((2 * x) / this.canvas.clientWidth - 1, 1 - (2 * y) / this.canvas.clientHeight);
    const caster = new THREE.Raycaster();
    caster.setFromCamera(ndc, this.activeCamera);
    return caster.ray;
  }

  // Projects a place to the canvas; null if behind the camera.
  project(place: THREE.Vector3): { x: number; y: number } | null {
    const p = place.clone().project(this.activeCamera);
    if (p.z > 1) return null;
    return {
      x: ((p.x + 1) / 2) * this.canvas.clientWidth,
      y: ((1 - p.y) / 2) * this.canvas.clientHeight,
    };
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
    if (!this.programs.areReady("scene", this.scene)) return;
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
    if (!this.look.hasOcclusion) return;
    await gpuFinished(this.renderer, 4);
    this.occlusionCost = performance.now() - begin;
  }

  private draw(quality: VolumeQuality, hasHandles = true): void {
    const isAtRest = quality !== "moving";
    const distance = this.camera.position.distanceTo(this.sphere.center);
    const { radius } = this.sphere;
    this.camera.near = Math.max(distance - 2.5 * radius, 0.0015 * radius);
    this.camera.far = distance + 2.5 * radius;
    this.camera.updateProjectionMatrix();
    this.camera.updateMatrixWorld();
    this.updateOrthographicCamera(distance, radius);
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
    const isReady = pass?.isWanted && programs.areReady("volume", pass.object, true);
    return isReady && pass.isShown ? { pass, quality } : null;
  }

  // Returns the number of passes: most pixels have few overlapping surfaces, even if there are many.
  private peels(isAtRest: boolean): number {
    const { translucent } = this.look;
    if (translucent === 0) return 0;
    return isAtRest ? Math.min(peels.limit, Math.max(peels.resting, 2 * translucent)) : peels.moving;
  }

  // Matches the orthographic camera to the perspective one at the distance of the target.
  private updateOrthographicCamera(distance: number, radius: number): void {
    const half = this.worldLengthOf(this.canvas.clientHeight) / 2;
    const { orthographicCamera, camera } = this;
    [orthographicCamera.left, orthographicCamera.right, orthographicCamera.top, orthographicCamera.bottom] = [
      -half * camera.aspect,
      half * camera.aspect,
      half,
      -half,
    ];
    orthographicCamera.near = distance - 2.5 * radius; // Includes what is beside or behind the eye.
    orthographicCamera.far = distance + 2.5 * radius;
    orthographicCamera.position.copy(camera.position);
    orthographicCamera.quaternion.copy(camera.quaternion);
    orthographicCamera.updateProjectionMatrix();
    orthographicCamera.updateMatrixWorld();
  }

  private resize(): void {
    const { clientWidth: width, clientHeight: height } = this.canvas.parentElement!;
    if (width === 0 || height === 0 || (width === this.size.width && height === this.size.height)) return;
    this.size = { width, height };
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    if (this.programs.areReady("scene", this.scene)) this.draw("moving");
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
