// Order-independent transparency by depth peeling. Each pass draws the nearest surface behind the
// previous pass and blends it behind the result.
//
// Weighted blending would need only one pass, but it weights surfaces by depth instead of ordering
// them, which looks milky where surfaces nest.
import * as THREE from "three";
import { FullScreenQuad } from "three/examples/jsm/postprocessing/Pass.js";

import { exactDepths } from "./exact_depths";
import { layers } from "./layers";
import type { SceneCamera } from "./occlusion";
import type { VolumePass } from "./volume/volume_pass";

const passthrough = "varying vec2 vUv; void main() { vUv = uv; gl_Position = vec4(position.xy, 0.0, 1.0); }";

// Shared by peeled materials: the depths between which fragments must lie.
export const peel = {
  before: { value: null as THREE.Texture | null }, // The previous pass; fragments not behind it are done.
  solid: { value: null as THREE.Texture | null }, // Fragments not in front of it are hidden.
  isFirst: { value: true },
};

// Adds peeling to a material; call in onBeforeCompile.
export function addPeeling(shader: THREE.WebGLProgramParametersWithUniforms): void {
  Object.assign(shader.uniforms, { peelBefore: peel.before, peelSolid: peel.solid, peelIsFirst: peel.isFirst });
  shader.fragmentShader = shader.fragmentShader
    .replace("#include <common>", "#include <common>\nuniform highp sampler2D peelBefore;\nuniform highp sampler2D peelSolid;\nuniform bool peelIsFirst;")
    .replace(
      "#include <clipping_planes_fragment>",
      "#include <clipping_planes_fragment>\n" +
        "ivec2 peelAt = ivec2(gl_FragCoord.xy);\n" +
        "if (gl_FragCoord.z >= texelFetch(peelSolid, peelAt, 0).r) discard;\n" +
        "if (!peelIsFirst && gl_FragCoord.z <= texelFetch(peelBefore, peelAt, 0).r) discard;",
    )
    // Increases the opacity at grazing angles.
    .replace(
      "#include <premultiplied_alpha_fragment>",
      "float peelRim = 1.0 - abs(dot(normal, geometryViewDir));\n" +
        "gl_FragColor.a += (1.0 - gl_FragColor.a) * gl_FragColor.a * peelRim * peelRim * peelRim;\n" +
        "gl_FragColor.rgb *= gl_FragColor.a;",
    );
}

export class Translucency {
  private readonly targets = [layerTarget(), layerTarget()];
  private readonly sum = new THREE.WebGLRenderTarget(1, 1, { type: THREE.HalfFloatType, depthBuffer: false });
  private readonly blendUnder = new FullScreenQuad(
    new THREE.ShaderMaterial({
      uniforms: { layer: { value: null } },
      vertexShader: passthrough,
      fragmentShader: "uniform sampler2D layer; varying vec2 vUv; void main() { gl_FragColor = texture2D(layer, vUv); }",
      depthTest: false,
      depthWrite: false,
      transparent: true,
      blending: THREE.CustomBlending,
      blendSrc: THREE.OneMinusDstAlphaFactor,
      blendDst: THREE.OneFactor,
    }),
  );

  // Draws all translucent surfaces, and the parts of a volume between them, in front of `solid`: premultiplied, linear.
  texture(
    renderer: THREE.WebGLRenderer,
    scene: THREE.Scene,
    camera: SceneCamera,
    solid: THREE.DepthTexture,
    passes: number,
    volume: VolumePass | null,
  ): THREE.Texture {
    if (volume && passes === 0) return volume.texture({ solid, before: null, after: null });
    const { width, height } = solid.image as { width: number; height: number };
    for (const target of [...this.targets, this.sum]) target.setSize(width, height);
    renderer.setRenderTarget(this.sum);
    renderer.clear();
    renderer.autoClear = false; // Passes accumulate.
    peel.solid.value = solid;
    camera.layers.set(layers.translucent);
    let before: THREE.Texture | null = null;
    const isOrdered = volume !== null && !volume.isMaximum; // The largest value has no order: it lies behind all layers.
    for (let pass = 0; pass < passes; ++pass) {
      const now = this.targets[pass % 2];
      peel.isFirst.value = pass === 0;
      peel.before.value = pass === 0 ? solid : this.targets[(pass + 1) % 2].depthTexture;
      renderer.setRenderTarget(now);
      renderer.clear();
      renderer.render(scene, camera);
      const after = now.depthTexture!;
      if (isOrdered) this.blend(renderer, volume.texture({ solid, before, after }));
      this.blend(renderer, now.texture);
      before = isOrdered ? after : null;
    }
    if (volume) this.blend(renderer, volume.texture({ solid, before, after: null }));
    renderer.autoClear = true;
    return this.sum.texture;
  }

  // Adds a layer behind all before.
  private blend(renderer: THREE.WebGLRenderer, layer: THREE.Texture): void {
    (this.blendUnder.material as THREE.ShaderMaterial).uniforms.layer.value = layer;
    renderer.setRenderTarget(this.sum);
    this.blendUnder.render(renderer);
  }
}

function layerTarget(): THREE.WebGLRenderTarget {
  return new THREE.WebGLRenderTarget(1, 1, {
    type: THREE.HalfFloatType,
    minFilter: THREE.NearestFilter,
    magFilter: THREE.NearestFilter,
    depthTexture: exactDepths(),
  });
}
