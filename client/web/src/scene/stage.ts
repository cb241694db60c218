// The picture: camera, lights, background, and a frame whenever something has changed. Nothing is
// drawn while nothing moves.
//
// A frame while something moves has to be quick; when all rests, one more is drawn with all that makes
// it better. What the graphics card needs little time for is in both.
import * as THREE from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";

import type { Vec3 } from "../stream/dataset";
import type { View } from "../stream/request";
import { hasDrawn } from "./gpu_fence";
import { Lights } from "./lights";
import type { LensSettings } from "./occlusion";
import { SceneRenderer } from "./scene_renderer";
import { Programs } from "./programs";

export interface StageLook {
  isOrthographic: boolean;
  hasOcclusion: boolean;
  translucent: number; // Surfaces that are seen through.
  clip: THREE.Plane[]; // That cut the surfaces.
}

const extensions = ["EXT_texture_filter_anisotropic", "EXT_color_buffer_float", "OES_texture_float_linear", "WEBGL_multisampled_render_to_texture"];
const restAfter = 180; // Milliseconds without a change.
const quick = 20; // Milliseconds of the graphics card: a frame that may be drawn while things move.
const tooSlow = 4000; // And one that is not drawn at all.
const peels = { moving: 3, resting: 6, most: 12 };

export class Stage {
  readonly scene = new THREE.Scene();
  readonly camera = new THREE.PerspectiveCamera(35, 1, 0.1, 1000);
  readonly renderer: THREE.WebGLRenderer;
  readonly controls: OrbitControls;
  private readonly flat = new THREE.OrthographicCamera(); // Follows `camera`.
  private readonly lights = new Lights();
  private readonly sceneRenderer: SceneRenderer;
  readonly programs: Programs;
  private look: StageLook = { isOrthographic: false, hasOcclusion: false, translucent: 0, clip: [] };
  private occlusionCost: number | null = null; // Milliseconds of the frame that had it; null: not known.
  private restTimer = 0;
  private readonly sphere = new THREE.Sphere(new THREE.Vector3(), 1);
  private isDue = false; // A frame is coming.
  private isChanged = false; // It draws the picture again.
  private size = { width: 0, height: 0 }; // CSS pixels.
  // Work to do in small parts, one part a frame: true when some was done or is left.
  private readonly chores: (() => boolean)[] = [];
  private readonly afterFrame: (() => void)[] = [];
  private isComing = () => false;
  private readonly resizing = new ResizeObserver(() => this.resize());

  constructor(private readonly canvas: HTMLCanvasElement) {
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: true, alpha: true });
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
    this.renderer.setClearColor(0x000000, 0);
    this.renderer.localClippingEnabled = true; // Materials have planes that cut the surface open.
    this.camera.up.set(0, 0, 1);
    this.flat.up.copy(this.camera.up);
    this.sceneRenderer = new SceneRenderer(this.renderer);
    this.programs = new Programs(this.renderer, this.scene, this.camera, this.sceneRenderer.targets, () => this.invalidate());
    // Asked now, when nothing is being drawn: later the page would wait for all that is.
    for (const name of extensions) this.renderer.extensions.has(name);
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

  // A frame for work that changes nothing in the picture.
  wake(): void {
    if (this.isDue) return;
    this.isDue = true;
    requestAnimationFrame(() => this.frame());
  }

  setLook(look: StageLook): void {
    if (isSameLook(look, this.look)) return;
    this.look = look;
    this.invalidate();
  }

  // What rays and places are seen through.
  get lens(): LensSettings {
    return this.look.isOrthographic ? this.flat : this.camera;
  }

  everyFrame(chore: () => boolean): void {
    this.chores.push(chore);
  }

  whenDrawn(listener: () => void): void {
    this.afterFrame.push(listener);
  }

  // While `isComing` is true, more of the picture is on its way, and the processor decodes it: frames at rest, which
  // take seconds where the processor draws them, too, wait until then.
  waitFor(isComing: () => boolean): void {
    this.isComing = isComing;
  }

  // The box of the data; the camera's range of depths follows it.
  setBounds(low: Vec3, high: Vec3): void {
    new THREE.Box3(new THREE.Vector3(...low), new THREE.Vector3(...high)).getBoundingSphere(
      this.sphere,
    );
    this.controls.maxDistance = 20 * this.sphere.radius;
    this.controls.minDistance = 0.002 * this.sphere.radius;
  }

  // From the front, a little from the side and from above: patients look along -y, where z is up.
  defaultView(): void {
    this.lookFrom(this.upright([0.55, -1, 0.32]));
  }

  // The direction in the world of one that is meant where z is above.
  upright(direction: readonly [number, number, number]): THREE.Vector3 {
    const turn = new THREE.Quaternion().setFromUnitVectors(new THREE.Vector3(0, 0, 1), this.camera.up);
    return new THREE.Vector3(...direction).applyQuaternion(turn);
  }

  // What is above in the picture; the place of the eye stays.
  setUp(up: Vec3): void {
    this.camera.up.set(...up).normalize();
    this.flat.up.copy(this.camera.up);
    // The controls take the direction when they are made, and have no way to change it.
    const { _quat, _quatInverse } = this.controls as unknown as Record<"_quat" | "_quatInverse", THREE.Quaternion>;
    _quat.setFromUnitVectors(this.camera.up, new THREE.Vector3(0, 1, 0));
    _quatInverse.copy(_quat).invert();
    this.controls.update();
    this.invalidate();
  }

  // What is above after the picture is turned clockwise around its middle.
  rolledUp(radians: number): Vec3 {
    const ahead = this.controls.target.clone().sub(this.camera.position).normalize();
    const up = new THREE.Vector3(0, 1, 0).applyQuaternion(this.camera.quaternion).applyAxisAngle(ahead, -radians);
    return nearAxis(up).toArray();
  }

  lookFrom(towards: THREE.Vector3): void {
    const direction = besideUp(towards, this.camera.up);
    const { center, radius } = this.sphere;
    const half = THREE.MathUtils.degToRad(this.camera.fov / 2);
    const narrow = Math.min(half, Math.atan(Math.tan(half) * this.camera.aspect));
    const distance = (0.93 * radius) / Math.sin(narrow);
    this.camera.position.copy(center).addScaledVector(direction.clone().normalize(), distance);
    this.controls.target.copy(center);
    this.controls.update();
    this.invalidate();
  }

  frameBounds({ low, high }: { low: Vec3; high: Vec3 }): void {
    this.frameBox(new THREE.Box3(new THREE.Vector3(...low), new THREE.Vector3(...high)));
  }

  // The box fills the picture; the direction of view stays. Nothing happens for an empty box.
  frameBox(box: THREE.Box3): void {
    if (box.isEmpty()) return;
    const direction = this.camera.position.clone().sub(this.controls.target).normalize();
    const target = box.getCenter(new THREE.Vector3());
    const right = new THREE.Vector3().crossVectors(this.camera.up, direction).normalize();
    const up = new THREE.Vector3().crossVectors(direction, right);
    const slope = Math.tan(THREE.MathUtils.degToRad(this.camera.fov / 2)) * 0.9;
    let distance = 0;
    for (let corner = 0; corner < 8; ++corner) {
      const p = new THREE.Vector3(
        corner & 1 ? box.max.x : box.min.x,
        corner & 2 ? box.max.y : box.min.y,
        corner & 4 ? box.max.z : box.min.z,
      ).sub(target);
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

  // Turns around the target by radians, moves closer by a factor.
  turn(azimuth: number, elevation: number, factor = 1): void {
    const offset = this.camera.position.clone().sub(this.controls.target);
    const upright = new THREE.Quaternion().setFromUnitVectors(
      this.camera.up,
      new THREE.Vector3(0, 1, 0),
    );
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

  // World units that a length of CSS pixels covers at the target.
  unitsOf(pixels: number): number {
    const distance = this.camera.position.distanceTo(this.controls.target);
    const height = 2 * distance * Math.tan(THREE.MathUtils.degToRad(this.camera.fov / 2));
    return (pixels * height) / Math.max(1, this.canvas.clientHeight);
  }

  // The ray under a place on the canvas, in CSS pixels from its corner.
  rayAt(x: number, y: number): THREE.Ray {
    const ndc = new THREE.Vector2(
      (2 * x) / this.canvas.clientWidth - 1,
      1 - (2 * y) / this.canvas.clientHeight,
    );
    const caster = new THREE.Raycaster();
    caster.setFromCamera(ndc, this.lens);
    return caster.ray;
  }

  // Where a place in the world is on the canvas; null behind the camera.
  project(place: THREE.Vector3): { x: number; y: number } | null {
    const p = place.clone().project(this.lens);
    if (p.z > 1) return null;
    return {
      x: ((p.x + 1) / 2) * this.canvas.clientWidth,
      y: ((1 - p.y) / 2) * this.canvas.clientHeight,
    };
  }

  // What is shown as it is at rest, without handles, drawn into a canvas of its own on a background, or on nothing; `enlargement` times as large
  // as on the screen, as far as the graphics card can.
  picture(background: string | null, enlargement = 1): HTMLCanvasElement {
    const ratio = this.renderer.getPixelRatio();
    const most = this.renderer.capabilities.maxTextureSize / Math.max(1, this.canvas.width, this.canvas.height);
    if (enlargement !== 1) this.renderer.setPixelRatio(ratio * Math.min(enlargement, Math.max(1, most)));
    this.draw(true, false);
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

  // For a picture of that many pixels across.
  enlargementTo(width: number): number {
    return (width + 0.01) / (this.size.width * this.renderer.getPixelRatio()); // What is left over is cut off.
  }

  // Gives the graphics card back.
  dispose(): void {
    clearTimeout(this.restTimer);
    this.isDue = this.isChanged = true; // No frame follows.
    this.controls.dispose();
    this.resizing.disconnect();
    this.renderer.dispose();
    this.renderer.forceContextLoss();
  }

  private frame(): void {
    this.isDue = false;
    const isMoving = this.controls.update();
    const isBusy = this.chores.map((chore) => chore()).some(Boolean);
    if (!this.programs.areReady("scene", this.scene)) return;
    if (isBusy) this.sceneRenderer.upload(this.scene, this.lens);
    if (isMoving) this.invalidate();
    else if (isBusy) this.wake();
    if (!this.isChanged) return;
    this.isChanged = isMoving;
    this.draw(false);
    for (const listener of this.afterFrame) listener();
    clearTimeout(this.restTimer);
    if (!isMoving && !this.isQuick()) this.restSoon();
  }

  // Whether frames while things move are as good as those at rest.
  private isQuick(): boolean {
    const { hasOcclusion, translucent } = this.look;
    return translucent === 0 && (!hasOcclusion || (this.occlusionCost ?? Infinity) <= quick);
  }

  private restSoon(): void {
    this.restTimer = window.setTimeout(() => void this.drawAtRest(), restAfter);
  }

  private async drawAtRest(): Promise<void> {
    const timer = this.restTimer;
    await hasDrawn(this.renderer);
    if (this.isChanged || timer !== this.restTimer) return; // Another frame follows, or another rest.
    if (this.isComing() || this.isDue) return this.restSoon();
    const begin = performance.now();
    this.draw(true);
    if (!this.look.hasOcclusion) return;
    await hasDrawn(this.renderer, 4);
    this.occlusionCost = performance.now() - begin;
  }

  private draw(isAtRest: boolean, hasHandles = true): void {
    const distance = this.camera.position.distanceTo(this.sphere.center);
    const { radius } = this.sphere;
    this.camera.near = Math.max(distance - 2.5 * radius, 0.0015 * radius);
    this.camera.far = distance + 2.5 * radius;
    this.camera.updateProjectionMatrix();
    this.camera.updateMatrixWorld();
    this.followFlat(distance, radius);
    this.lights.follow(this.camera);
    const cost = this.occlusionCost ?? 0;
    const isOccluded = this.look.hasOcclusion && (isAtRest ? cost < tooSlow : this.isQuick());
    this.sceneRenderer.draw(this.scene, this.lens, {
      occlusion: isOccluded ? { radius: Math.min(0.12 * radius, this.unitsOf(90)), clip: this.look.clip } : null,
      peels: this.peels(isAtRest), hasHandles,
    });
  }

  // Passes: most places have few surfaces one behind the other, however many there are.
  private peels(isAtRest: boolean): number {
    const { translucent } = this.look;
    if (translucent === 0) return 0;
    return isAtRest ? Math.min(peels.most, Math.max(peels.resting, 2 * translucent)) : peels.moving;
  }

  // The same picture at the distance of the target, without perspective.
  private followFlat(distance: number, radius: number): void {
    const half = this.unitsOf(this.canvas.clientHeight) / 2;
    const { flat, camera } = this;
    [flat.left, flat.right, flat.top, flat.bottom] = [-half * camera.aspect, half * camera.aspect, half, -half];
    flat.near = distance - 2.5 * radius; // What is beside or behind the eye is there, too.
    flat.far = distance + 2.5 * radius;
    flat.position.copy(camera.position);
    flat.quaternion.copy(camera.quaternion);
    flat.updateProjectionMatrix();
    flat.updateMatrixWorld();
  }

  private resize(): void {
    const { clientWidth: width, clientHeight: height } = this.canvas.parentElement!;
    if (width === 0 || height === 0 || (width === this.size.width && height === this.size.height)) return;
    this.size = { width, height };
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    if (this.programs.areReady("scene", this.scene)) this.draw(false);
    this.invalidate();
  }
}

function isSameLook(one: StageLook, other: StageLook): boolean {
  const isSamePlane = (plane: THREE.Plane, at: number) => other.clip[at]?.equals(plane) ?? false;
  return one.isOrthographic === other.isOrthographic && one.hasOcclusion === other.hasOcclusion &&
    one.translucent === other.translucent && one.clip.length === other.clip.length && one.clip.every(isSamePlane);
}

// The axis of the world where the direction is within half a degree of one.
function nearAxis(direction: THREE.Vector3): THREE.Vector3 {
  const axis = [0, 1, 2].find((one) => Math.abs(direction.getComponent(one)) > Math.cos(THREE.MathUtils.degToRad(0.5)));
  return axis === undefined ? direction : new THREE.Vector3().setComponent(axis, Math.sign(direction.getComponent(axis)));
}

// Straight along what is up there is no up in the picture: a hair beside it there is.
function besideUp(direction: THREE.Vector3, up: THREE.Vector3): THREE.Vector3 {
  if (direction.clone().normalize().cross(up).length() >= 1e-6) return direction;
  const hair = Math.abs(up.y) < 0.9 ? new THREE.Vector3(0, -1e-4, 0) : new THREE.Vector3(0, 0, -1e-4);
  return direction.clone().add(hair);
}
