// The camera of a canvas, perspective or parallel, which the user orbits, and its views of the data.
import * as THREE from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";

import type { Vec3 } from "../stream/dataset";
import type { View } from "../stream/request";
import { boxBetween } from "./crop";
import { nudgedFromUp, snappedToAxis } from "./directions";
import type { SceneCamera } from "./occlusion";

export abstract class OrbitView {
  readonly camera = new THREE.PerspectiveCamera(35, 1, 0.1, 1000);
  readonly controls: OrbitControls;
  protected readonly sphere = new THREE.Sphere(new THREE.Vector3(), 1); // Around the data.
  protected isOrthographic = false;
  private readonly orthographicCamera = new THREE.OrthographicCamera(); // Follows `camera`.

  constructor(protected readonly canvas: HTMLCanvasElement) {
    this.camera.up.set(0, 0, 1);
    this.orthographicCamera.up.copy(this.camera.up);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.dampingFactor = 0.12;
    this.controls.enableDamping = !matchMedia("(prefers-reduced-motion: reduce)").matches;
    this.controls.addEventListener("change", () => this.invalidate());
  }

  // Called when the camera has moved.
  abstract invalidate(): void;

  // The current camera, for rays and projections.
  get activeCamera(): SceneCamera {
    return this.isOrthographic ? this.orthographicCamera : this.camera;
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
      heightPixels: Math.max(1, this.canvas.height),
      aspect: this.camera.aspect,
    };
  }

  // Returns the world length of CSS pixels at the target.
  worldLengthOf(pixels: number): number {
    const distance = this.camera.position.distanceTo(this.controls.target);
    const height = 2 * distance * Math.tan(THREE.MathUtils.degToRad(this.camera.fov / 2));
    return (pixels * height) / Math.max(1, this.canvas.clientHeight);
  }

  // Returns the world length of a CSS pixel at a place.
  worldLengthAt(place: THREE.Vector3): number {
    const { position } = this.camera;
    return (this.worldLengthOf(1) * position.distanceTo(place)) / Math.max(1e-12, position.distanceTo(this.controls.target));
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

  // Call before drawing. Matches the orthographic camera to the perspective one at the distance of the target.
  protected updateCameras(): void {
    const distance = this.camera.position.distanceTo(this.sphere.center);
    const { radius } = this.sphere;
    this.camera.near = Math.max(distance - 2.5 * radius, 0.0015 * radius);
    this.camera.far = distance + 2.5 * radius;
    this.camera.updateProjectionMatrix();
    this.camera.updateMatrixWorld();
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
}
