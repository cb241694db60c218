// Draws a frame, normally in one pass to the canvas. Translucent surfaces, a volume and ambient occlusion need more passes:
//
//   solid things, marks -> colors, depths ------------->+
//   solid things -> normals, depths -> occlusion ------->+-> canvas -> overlay
//   translucent surfaces and a volume, layer by layer -->+
import * as THREE from "three";
import { FullScreenQuad } from "three/examples/jsm/postprocessing/Pass.js";

import { exactDepths } from "./exact_depths";
import { layers } from "./layers";
import { Occlusion, type OcclusionOptions, type SceneCamera } from "./occlusion";
import { Translucency } from "./translucency";
import type { VolumePass, VolumeQuality } from "./volume/volume_pass";

export interface FrameOptions {
  occlusion: OcclusionOptions | null; // Null: none.
  peels: number; // Passes for translucent surfaces; 0: there are none.
  volume: { pass: VolumePass; quality: VolumeQuality } | null; // Null: none.
  hasHandles: boolean; // Whether to draw the layer `overlay`.
}

const compositeShader = /* glsl */ `
  uniform sampler2D solid;
  uniform sampler2D occlusion;
  uniform sampler2D translucent;
  uniform highp sampler2D depths;
  uniform highp sampler2D shape; // Depths of the surfaces that the occlusion was computed for.
  uniform bool hasOcclusion;
  uniform bool hasTranslucent;
  varying vec2 vUv;

  // Returns the mean occlusion over the noise pattern's 5 by 5 pixels, with low weights for other depths.
  float light() {
    ivec2 at = ivec2(gl_FragCoord.xy);
    ivec2 end = textureSize(depths, 0) - 1;
    float here = texelFetch(depths, at, 0).r;
    if (here >= 1.0) return 1.0;
    float slope = fwidth(here) * 3.0 + 1e-5;
    if (here < texelFetch(shape, at, 0).r - slope) return 1.0; // A mark in front of the surface.
    float sum = 0.0;
    float weights = 0.0;
    for (int y = -2; y <= 2; ++y) {
      for (int x = -2; x <= 2; ++x) {
        ivec2 p = clamp(at + ivec2(x, y), ivec2(0), end);
        float near = abs(texelFetch(depths, p, 0).r - here) <= slope ? 1.0 : 0.02;
        sum += near * texelFetch(occlusion, p, 0).r;
        weights += near;
      }
    }
    return 0.3 + 0.7 * sum / weights; // Occluded places keep some indirect light.
  }

  void main() {
    vec4 color = texture2D(solid, vUv);
    if (hasOcclusion) color.rgb *= light();
    if (hasTranslucent) {
      vec4 front = texture2D(translucent, vUv);
      color = front + (1.0 - front.a) * color;
    }
    vec3 plain = color.a > 0.0 ? color.rgb / color.a : vec3(0.0);
    gl_FragColor = vec4(sRGBTransferOETF(vec4(min(plain, 1.0), 1.0)).rgb * color.a, color.a);
  }`;

export class SceneRenderer {
  private readonly smooth = solidTarget(4);
  private readonly quick = solidTarget(0); // Without a graphics card, four samples a pixel cost more than the rest of a frame.
  private readonly uploadTarget = new THREE.WebGLRenderTarget(1, 1, { type: THREE.HalfFloatType }); // The target of uploads.
  private readonly occlusion = new Occlusion();
  private readonly translucency = new Translucency();
  private readonly composite = new FullScreenQuad(
    new THREE.ShaderMaterial({
      uniforms: {
        solid: { value: null },
        occlusion: { value: null },
        translucent: { value: null },
        depths: { value: null },
        shape: { value: null },
        hasOcclusion: { value: false },
        hasTranslucent: { value: false },
      },
      vertexShader: "varying vec2 vUv; void main() { vUv = uv; gl_Position = vec4(position.xy, 0.0, 1.0); }",
      fragmentShader: compositeShader,
      blending: THREE.NoBlending,
      depthTest: false,
      depthWrite: false,
    }),
  );

  constructor(private readonly renderer: THREE.WebGLRenderer) {}

  // The render targets of the scene; each needs its own programs.
  get targets(): (THREE.WebGLRenderTarget | null)[] {
    return [null, this.smooth];
  }

  // Uploads the buffers of the layer `upload` to the GPU without redrawing the picture.
  upload(scene: THREE.Scene, camera: SceneCamera): void {
    camera.layers.set(layers.upload);
    this.renderer.setRenderTarget(this.uploadTarget);
    this.renderer.render(scene, camera);
    this.renderer.setRenderTarget(null);
    camera.layers.enableAll();
  }

  draw(scene: THREE.Scene, camera: SceneCamera, options: FrameOptions): void {
    const { renderer } = this;
    if (options.occlusion === null && options.peels === 0 && options.volume === null) {
      camera.layers.enableAll();
      if (!options.hasHandles) camera.layers.disable(layers.overlay);
      renderer.setRenderTarget(null);
      renderer.render(scene, camera);
      camera.layers.enableAll();
      return;
    }
    const size = renderer.getDrawingBufferSize(new THREE.Vector2());
    const { volume } = options;
    const target = volume && volume.quality === "moving" && !volume.pass.isQuick ? this.quick : this.smooth;
    target.setSize(size.x, size.y);
    camera.layers.set(layers.solid);
    camera.layers.enable(layers.marks);
    renderer.setRenderTarget(target);
    renderer.clear();
    renderer.render(scene, camera);
    const depths = target.depthTexture!;
    const { uniforms } = this.composite.material as THREE.ShaderMaterial;
    uniforms.solid.value = target.texture;
    uniforms.depths.value = depths;
    uniforms.hasOcclusion.value = options.occlusion !== null;
    uniforms.hasTranslucent.value = options.peels > 0 || options.volume !== null;
    if (options.occlusion !== null) {
      uniforms.shape.value = this.occlusion.depths;
      uniforms.occlusion.value = this.occlusion.texture(renderer, scene, camera, options.occlusion, target);
    }
    if (uniforms.hasTranslucent.value) {
      const pass = volume?.pass ?? null;
      pass?.begin(camera, { width: size.x, height: size.y }, volume!.quality);
      uniforms.translucent.value = this.translucency.texture(renderer, scene, camera, depths, options.peels, pass);
      pass?.end();
    }
    renderer.setRenderTarget(null);
    renderer.clear();
    this.composite.render(renderer);
    if (options.hasHandles) this.drawOverlay(scene, camera);
  }

  private drawOverlay(scene: THREE.Scene, camera: SceneCamera): void {
    const { renderer } = this;
    renderer.autoClear = false;
    camera.layers.set(layers.overlay);
    renderer.render(scene, camera);
    camera.layers.enableAll();
    renderer.autoClear = true;
  }
}

function solidTarget(samples: number): THREE.WebGLRenderTarget {
  return new THREE.WebGLRenderTarget(1, 1, { samples, type: THREE.HalfFloatType, depthTexture: exactDepths() });
}
