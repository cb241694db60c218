// Draws a volume between depths of surfaces, into a picture that may be coarser than the scene's: without a graphics card,
// every sample costs.
import * as THREE from "three";
import { FullScreenQuad } from "three/examples/jsm/postprocessing/Pass.js";
import type { DatasetInfo } from "../../protocol/messages";
import { type ColorScale, colorRow, endsOf } from "../../shared/color_maps";
import type { OpacityPoint } from "../../state/settings";
import { inverse, voxelLength } from "../../stream/dataset";
import { gpuFinished } from "../gpu_fence";
import type { SceneCamera } from "../occlusion";
import type { Level } from "./levels";
import { extinctionTable, isVisible, tableLength } from "./opacities";
import type { LabelMap } from "./volume_labels";
import { fragment, maxPlanes, vertex } from "./volume_shader";
import { blockTexture, type VolumeTexture } from "./volume_texture";

// How a volume is drawn: during motion fast, at rest well if that takes no longer than a few seconds, in pictures well.
export type VolumeQuality = "moving" | "resting" | "picture";

export interface VolumeLook {
  points: readonly OpacityPoint[]; // At least one.
  scale: ColorScale;
  isMaximum: boolean;
  isShaded: boolean;
  clip: readonly THREE.Plane[]; // Visible half-spaces.
}

export interface Depths {
  solid: THREE.Texture; // Of opaque surfaces.
  before: THREE.Texture | null; // The part begins at this layer; null: at the eye.
  after: THREE.Texture | null; // The part ends at this layer; null: at opaque surfaces.
}

const goal = { moving: 35, resting: 4000 }; // Milliseconds of a frame.
const finest = { shrink: 1, stride: 0.5 };
const maxShrink = 8; // Scene pixels along the side of a pixel.

export class VolumePass {
  private readonly material = new THREE.ShaderMaterial({
    uniforms: uniforms(),
    vertexShader: vertex,
    fragmentShader: fragment,
    blending: THREE.NoBlending,
    depthTest: false,
    depthWrite: false,
  });
  private readonly quad = new FullScreenQuad(this.material);
  readonly object = new THREE.Mesh(new THREE.PlaneGeometry(), this.material); // To compile programs for.
  private readonly target = new THREE.WebGLRenderTarget(1, 1, { type: THREE.HalfFloatType, depthBuffer: false });
  private shown: VolumeTexture | null = null;
  private info: DatasetInfo | null = null;
  private look: VolumeLook | null = null;
  private labels: LabelMap | null = null;
  private cost = 2000; // Milliseconds of a frame with all pixels and one place in each sample's length.
  private begun: Promise<number> | null = null;
  private measured = 1; // The frame's share of that, inverted.
  private isMeasuring = false;
  measuring: Promise<void> = Promise.resolve(); // Of the latest frame.

  constructor(private readonly renderer: THREE.WebGLRenderer) {}

  get isShown(): boolean {
    return this.shown !== null && this.look !== null;
  }

  // Whether it is or will be shown.
  get isWanted(): boolean {
    return this.look !== null;
  }

  get isMaximum(): boolean {
    return this.look?.isMaximum === true;
  }

  // Null: nothing.
  setSamples(shown: VolumeTexture | null, info: DatasetInfo | null): void {
    if (shown && this.shown) this.cost *= this.shown.level.step / shown.level.step;
    this.shown = shown;
    this.info = info;
    this.material.uniforms.samples.value = shown?.texture ?? null;
    if (shown && this.look) this.updateBlocks();
  }

  setLook(look: VolumeLook): void {
    const { uniforms } = this.material;
    const before = this.look;
    this.look = look;
    uniforms.ends.value.set(...endsOf(look.scale));
    uniforms.isLog.value = look.scale.isLog;
    uniforms.isMaximum.value = look.isMaximum;
    uniforms.isShaded.value = look.isShaded;
    if (look.scale.map !== before?.scale.map) {
      uniforms.colors.value?.dispose();
      const colors = new THREE.DataTexture(colorRow(look.scale.map, 256), 256, 1);
      colors.colorSpace = THREE.SRGBColorSpace;
      colors.minFilter = colors.magFilter = THREE.LinearFilter;
      colors.needsUpdate = true;
      uniforms.colors.value = colors;
    }
    if (look.points !== before?.points || look.isMaximum !== before.isMaximum) {
      const [first, last] = [look.points[0].value, look.points[look.points.length - 1].value];
      uniforms.opacityEnds.value.set(...endsOf({ low: first, high: last, isLog: false }));
      uniforms.opacities.value?.dispose();
      uniforms.opacities.value = new THREE.DataTexture(extinctionTable(look.points), tableLength, 1, THREE.RGFormat, THREE.FloatType);
      uniforms.opacities.value.needsUpdate = true;
      if (this.shown) this.updateBlocks();
    }
  }

  // Null: samples have the colors of their values.
  setLabels(labels: LabelMap | null): void {
    const { uniforms } = this.material;
    this.labels = labels;
    uniforms.hasLabels.value = labels !== null;
    uniforms.isOnlyLabels.value = labels?.isOnly === true;
    uniforms.labels.value = labels?.texture ?? null;
    uniforms.labelColors.value = labels?.colors ?? null;
  }

  // Begins a frame with this size in pixels.
  begin(camera: SceneCamera, { width, height }: { width: number; height: number }, quality: VolumeQuality): void {
    const { shrink, stride } = this.fineness(quality);
    this.target.setSize(Math.ceil(width / shrink), Math.ceil(height / shrink));
    this.material.uniforms.stride.value = stride;
    this.material.uniforms.isQuick.value = quality === "moving" && !this.isQuick;
    this.place(camera);
    this.begun = this.isMeasuring ? null : gpuFinished(this.renderer, 2).then(() => performance.now());
    this.measured = shrink ** 2 * stride;
  }

  // Returns the picture of the part between two layers: premultiplied, linear.
  texture(depths: Depths): THREE.Texture {
    const { uniforms } = this.material;
    uniforms.solid.value = depths.solid;
    uniforms.before.value = depths.before ?? depths.solid;
    uniforms.hasBefore.value = depths.before !== null;
    uniforms.after.value = depths.after ?? depths.solid;
    uniforms.hasAfter.value = depths.after !== null;
    this.renderer.setRenderTarget(this.target);
    this.quad.render(this.renderer);
    return this.target.texture;
  }

  // Ends the frame: measures what it cost. Other work on the GPU only makes it longer.
  end(): void {
    if (this.begun) this.measuring = this.measure(this.begun, this.measured);
  }

  // Whether a frame at rest would be clearly finer than the latest one: drawing has turned out to be faster than before.
  get isFinerAtRest(): boolean {
    const { shrink, stride } = this.fineness("resting");
    return this.isShown && shrink ** 2 * stride < 0.8 * this.measured;
  }

  // Whether frames during motion are as good as those at rest.
  get isQuick(): boolean {
    return !this.isShown || this.cost <= goal.moving * finest.stride;
  }

  private fineness(quality: VolumeQuality): { shrink: number; stride: number } {
    if (quality === "picture" || this.isQuick) return finest;
    const stride = quality === "moving" && this.shown!.level.step === 1 ? 2 : 1;
    if (quality === "resting" && this.cost <= goal.resting * finest.stride) return finest;
    return { shrink: Math.min(maxShrink, Math.max(1, Math.sqrt(this.cost / stride / goal[quality]))), stride };
  }

  private async measure(begun: Promise<number>, fraction: number): Promise<void> {
    this.isMeasuring = true;
    const begin = await begun;
    await gpuFinished(this.renderer, 2);
    const cost = (performance.now() - begin) * fraction;
    this.cost = cost < this.cost ? cost : 0.7 * this.cost + 0.3 * cost;
    this.isMeasuring = false;
  }

  private place(camera: SceneCamera): void {
    const { info, shown, look, labels } = this;
    const { uniforms } = this.material;
    const { counts } = shown!.level;
    const worldToTexture = toTexture(info!, shown!.level);
    const textureToWorld = worldToTexture.clone().invert();
    const clipToWorld = camera.matrixWorld.clone().multiply(camera.projectionMatrixInverse);
    uniforms.clipToTexture.value.multiplyMatrices(worldToTexture, clipToWorld);
    uniforms.textureToWorld.value.setFromMatrix4(textureToWorld);
    uniforms.gradientToWorld.value.setFromMatrix4(worldToTexture).transpose();
    if (labels) uniforms.toLabels.value.multiplyMatrices(toTexture(labels.info, labels.level), textureToWorld);
    uniforms.counts.value.set(...counts);
    uniforms.voxel.value = voxelLength(info!);
    uniforms.range.value.set(...shown!.rules.range);
    uniforms.planeCount.value = Math.min(maxPlanes, look!.clip.length);
    look!.clip.slice(0, maxPlanes).forEach(({ normal, constant }, i) => {
      // A plane's row vector is multiplied by the matrix from the texture to the world.
      const row = new THREE.Vector4(...normal.toArray(), constant).applyMatrix4(textureToWorld.clone().transpose());
      uniforms.planes.value[i].copy(row);
    });
  }

  private updateBlocks(): void {
    const { uniforms } = this.material;
    const { points, isMaximum } = this.look!;
    uniforms.blocks.value?.dispose();
    uniforms.blocks.value = blockTexture(this.shown!, (low, high) => (isMaximum ? high >= low : isVisible(points, low, high)));
  }

  dispose(): void {
    this.material.dispose();
    this.target.dispose();
  }
}

// Returns the map from the world to a level's texture, 0 to 1 along each axis, with samples in the middle of texels.
function toTexture({ indexToWorld }: DatasetInfo, { step, counts }: Level): THREE.Matrix4 {
  const back = inverse(indexToWorld);
  const row = (i: number) => [back[i], back[3 + i], back[6 + i], back[9 + i]].map((part) => part / step / counts[i]);
  const [x, y, z] = [0, 1, 2].map((i) => {
    const [a, b, c, d] = row(i);
    return [a, b, c, d + 0.5 / counts[i]];
  });
  return new THREE.Matrix4().set(x[0], x[1], x[2], x[3], y[0], y[1], y[2], y[3], z[0], z[1], z[2], z[3], 0, 0, 0, 1);
}

function uniforms(): Record<string, THREE.IUniform> {
  const none = ["samples", "blocks", "solid", "after", "before", "opacities", "colors", "labels", "labelColors"];
  const off = ["hasBefore", "hasAfter", "hasLabels", "isLog", "isMaximum", "isOnlyLabels", "isShaded", "isQuick"];
  return {
    ...Object.fromEntries(none.map((name) => [name, { value: null }])),
    ...Object.fromEntries(off.map((name) => [name, { value: false }])),
    clipToTexture: { value: new THREE.Matrix4() },
    toLabels: { value: new THREE.Matrix4() },
    textureToWorld: { value: new THREE.Matrix3() },
    gradientToWorld: { value: new THREE.Matrix3() },
    counts: { value: new THREE.Vector3() },
    planes: { value: Array.from({ length: maxPlanes }, () => new THREE.Vector4()) },
    planeCount: { value: 0 },
    stride: { value: 0.5 },
    voxel: { value: 1 },
    range: { value: new THREE.Vector2(0, 1) },
    opacityEnds: { value: new THREE.Vector2(0, 1) },
    ends: { value: new THREE.Vector2(0, 1) },
  };
}
