// Compiles GPU programs before they are needed. A frame with a program that is not ready blocks the page, for some
// tenths of a second with software rendering.
import type * as THREE from "three";

import { gpuFinished } from "./gpu_fence";

const compileTimeout = 5000; // Milliseconds: an upper limit for GPUs that never report completion.

export class Programs {
  private readonly ready = new Set<string>();
  private readonly compiling = new Set<string>();

  // `targets`: the render targets; each needs its own programs.
  constructor(
    private readonly renderer: THREE.WebGLRenderer,
    private readonly scene: THREE.Scene,
    private readonly camera: THREE.Camera,
    private readonly targets: readonly (THREE.WebGLRenderTarget | null)[],
    private readonly changed: () => void,
  ) {}

  // Returns whether objects of this kind can be drawn immediately. If not, compilation begins, and the callback is
  // called when it is complete. The example's material must not be disposed until then. `isPass`: it is drawn without the
  // scene's lights, and never to the canvas.
  areReady(kind: string, example: () => THREE.Object3D, isPass = false): boolean {
    if (this.ready.has(kind)) return true;
    if (!this.compiling.has(kind)) void this.compile(kind, example, isPass);
    return false;
  }

  // Call when all programs are lost.
  forget(): void {
    this.ready.clear();
  }

  // Examples with materials of their own are compiled at the same time for all targets.
  private async compile(kind: string, example: () => THREE.Object3D, isPass: boolean): Promise<void> {
    this.compiling.add(kind);
    const scene = isPass ? null : this.scene;
    const timeout = new Promise((resolve) => setTimeout(resolve, compileTimeout));
    const targets = this.targets.filter((one) => one !== null || !isPass);
    await Promise.race([Promise.all(targets.map((target) => this.compiled(example(), scene, target))), timeout]);
    this.compiling.delete(kind);
    this.ready.add(kind);
    this.changed();
  }

  // A GPU that cannot report when a program is ready reports at least a completed draw.
  private async compiled(object: THREE.Object3D, scene: THREE.Scene | null, target: THREE.WebGLRenderTarget | null): Promise<void> {
    const { renderer, camera } = this;
    const canReport = renderer.extensions.has("KHR_parallel_shader_compile");
    renderer.setRenderTarget(target);
    const made = canReport ? renderer.compileAsync(object, camera, scene) : renderer.compile(object, camera, scene);
    renderer.setRenderTarget(null);
    await made;
    if (!canReport) await gpuFinished(renderer, 10);
  }
}
