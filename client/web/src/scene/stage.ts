// The picture: camera, lights, background, and a frame whenever something has changed. Nothing is
// drawn while nothing moves.
import * as THREE from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";

import type { Vec3 } from "../stream/dataset";
import type { View } from "../stream/request";

export class Stage {
  readonly scene = new THREE.Scene();
  readonly camera = new THREE.PerspectiveCamera(35, 1, 0.1, 1000);
  readonly renderer: THREE.WebGLRenderer;
  readonly controls: OrbitControls;
  private readonly headlight = new THREE.DirectionalLight(0xfff6ea, 2.5);
  private readonly sphere = new THREE.Sphere(new THREE.Vector3(), 1);
  private isDue = false;
  // Work to do in small parts, one part a frame: true when there is more.
  private readonly chores: (() => boolean)[] = [];
  private readonly afterFrame: (() => void)[] = [];

  constructor(private readonly canvas: HTMLCanvasElement) {
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: true, alpha: true });
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
    this.renderer.setClearColor(0x000000, 0);
    this.renderer.localClippingEnabled = true; // Materials have planes that cut the surface open.
    this.camera.up.set(0, 0, 1);
    this.scene.add(new THREE.HemisphereLight(0xdfe8f5, 0x2a2622, 0.85), this.camera);
    this.headlight.position.set(-0.6, 0.9, 1);
    this.camera.add(this.headlight, this.headlight.target);
    this.headlight.target.position.set(0, 0, -1);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.dampingFactor = 0.12;
    this.controls.enableDamping = !matchMedia("(prefers-reduced-motion: reduce)").matches;
    this.controls.addEventListener("change", () => this.invalidate());
    new ResizeObserver(() => this.resize()).observe(canvas.parentElement!);
    this.resize();
  }

  invalidate(): void {
    if (this.isDue) return;
    this.isDue = true;
    requestAnimationFrame(() => this.frame());
  }

  everyFrame(chore: () => boolean): void {
    this.chores.push(chore);
  }

  whenDrawn(listener: () => void): void {
    this.afterFrame.push(listener);
  }

  // The box of the data; the camera's range of depths follows it.
  setBounds(low: Vec3, high: Vec3): void {
    new THREE.Box3(new THREE.Vector3(...low), new THREE.Vector3(...high)).getBoundingSphere(
      this.sphere,
    );
    this.controls.maxDistance = 20 * this.sphere.radius;
    this.controls.minDistance = 0.002 * this.sphere.radius;
  }

  // From the front, a little from the side and from above: patients look along -y.
  defaultView(): void {
    this.lookFrom(new THREE.Vector3(0.55, -1, 0.32));
  }

  lookFrom(direction: THREE.Vector3): void {
    const { center, radius } = this.sphere;
    const half = THREE.MathUtils.degToRad(this.camera.fov / 2);
    const narrow = Math.min(half, Math.atan(Math.tan(half) * this.camera.aspect));
    const distance = (0.93 * radius) / Math.sin(narrow);
    this.camera.position.copy(center).addScaledVector(direction.clone().normalize(), distance);
    this.controls.target.copy(center);
    this.controls.update();
    this.invalidate();
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
      up: [0, 0, 1],
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
    caster.setFromCamera(ndc, this.camera);
    return caster.ray;
  }

  // Where a place in the world is on the canvas; null behind the camera.
  project(place: THREE.Vector3): { x: number; y: number } | null {
    const p = place.clone().project(this.camera);
    if (p.z > 1) return null;
    return {
      x: ((p.x + 1) / 2) * this.canvas.clientWidth,
      y: ((1 - p.y) / 2) * this.canvas.clientHeight,
    };
  }

  // A picture of what is shown, as PNG, on the page's background.
  async picture(background: string): Promise<Blob> {
    this.draw();
    const copy = document.createElement("canvas");
    copy.width = this.canvas.width;
    copy.height = this.canvas.height;
    const context = copy.getContext("2d")!;
    context.fillStyle = background;
    context.fillRect(0, 0, copy.width, copy.height);
    context.drawImage(this.canvas, 0, 0);
    return new Promise((resolve) => copy.toBlob((blob) => resolve(blob!), "image/png"));
  }

  private frame(): void {
    this.isDue = false;
    const isMoving = this.controls.update();
    const isBusy = this.chores.map((chore) => chore()).some(Boolean);
    this.draw();
    for (const listener of this.afterFrame) listener();
    if (isMoving || isBusy) this.invalidate();
  }

  private draw(): void {
    const distance = this.camera.position.distanceTo(this.sphere.center);
    const { radius } = this.sphere;
    this.camera.near = Math.max(distance - 2.5 * radius, 0.0015 * radius);
    this.camera.far = distance + 2.5 * radius;
    this.camera.updateProjectionMatrix();
    this.renderer.render(this.scene, this.camera);
  }

  private resize(): void {
    const { clientWidth: width, clientHeight: height } = this.canvas.parentElement!;
    if (width === 0 || height === 0) return;
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.draw();
    this.invalidate();
  }
}
