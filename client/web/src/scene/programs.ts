// Programs of the graphics card, made before something is drawn with them. A frame that needs one that is
// not ready yet has the page wait for it, some tenths of a second where the card is the processor.
import * as THREE from "three";

import { hasDrawn } from "./card";

const patience = 5000; // Milliseconds: a card that never tells may have the page wait.

export class Programs {
  private readonly ready = new Set<string>();
  private readonly coming = new Set<string>();

  // `targets`: what things are drawn to: each has programs of its own.
  constructor(
    private readonly renderer: THREE.WebGLRenderer,
    private readonly scene: THREE.Scene,
    private readonly camera: THREE.Camera,
    private readonly targets: readonly (THREE.WebGLRenderTarget | null)[],
    private readonly changed: () => void,
  ) {}

  // Whether things of this kind, of which the object is one, can be drawn at once. If not, that begins, and is
  // told when it is so.
  areReady(kind: string, object: THREE.Object3D): boolean {
    if (this.ready.has(kind)) return true;
    if (!this.coming.has(kind)) void this.make(kind, object);
    return false;
  }

  private async make(kind: string, object: THREE.Object3D): Promise<void> {
    this.coming.add(kind);
    for (const target of this.targets) {
      await Promise.race([this.made(object, target), new Promise((resolve) => setTimeout(resolve, patience))]);
    }
    this.coming.delete(kind);
    this.ready.add(kind);
    this.changed();
  }

  // A card that cannot tell that a program is ready tells at least that it has got as far.
  private async made(object: THREE.Object3D, target: THREE.WebGLRenderTarget | null): Promise<void> {
    const { renderer, camera, scene } = this;
    const canTell = renderer.extensions.has("KHR_parallel_shader_compile");
    renderer.setRenderTarget(target);
    const made = canTell ? renderer.compileAsync(object, camera, scene) : renderer.compile(object, camera, scene);
    renderer.setRenderTarget(null);
    await made;
    if (!canTell) await hasDrawn(renderer, 10);
  }
}
