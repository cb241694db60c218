// Ambient occlusion of opaque surfaces from depths and normals: three's ground-truth ambient occlusion. Its noise
// pattern has 5 by 5 pixels; average over that area.
import * as THREE from "three";
import { FullScreenQuad } from "three/examples/jsm/postprocessing/Pass.js";
import { GTAOShader, generateMagicSquareNoise } from "three/examples/jsm/shaders/GTAOShader.js";

import { exactDepths } from "./exact_depths";
import { layers } from "./layers";

export class Occlusion {
  // The field's normals, as used for shading: depths alone would show every triangle.
  private readonly shape = new THREE.WebGLRenderTarget(1, 1, {
    minFilter: THREE.NearestFilter,
    magFilter: THREE.NearestFilter,
    depthTexture: exactDepths(),
  });
  private readonly normals = new THREE.MeshNormalMaterial({ side: THREE.DoubleSide });
  private readonly target = new THREE.WebGLRenderTarget(1, 1, {
    depthBuffer: false,
    minFilter: THREE.NearestFilter,
    magFilter: THREE.NearestFilter,
  });
  private readonly material = new THREE.ShaderMaterial({
    defines: { ...GTAOShader.defines, NORMAL_VECTOR_TYPE: 1, SAMPLES: 16 },
    uniforms: THREE.UniformsUtils.clone(GTAOShader.uniforms),
    vertexShader: GTAOShader.vertexShader,
    fragmentShader: GTAOShader.fragmentShader,
    blending: THREE.NoBlending,
    depthTest: false,
    depthWrite: false,
  });
  private readonly quad = new FullScreenQuad(this.material);

  constructor() {
    this.material.uniforms.tNoise.value = generateMagicSquareNoise();
  }

  // The depths of the surface in the texture.
  get depths(): THREE.DepthTexture {
    return this.shape.depthTexture!;
  }

  // Returns 1 where light arrives from everywhere, less in hollows narrower than `radius`, in world units.
  texture(
    renderer: THREE.WebGLRenderer,
    scene: THREE.Scene,
    camera: SceneCamera,
    { radius, clip }: OcclusionOptions,
    { width, height }: { width: number; height: number },
  ): THREE.Texture {
    this.shape.setSize(width, height);
    this.target.setSize(width, height);
    this.normals.clippingPlanes = clip;
    camera.layers.set(layers.solid);
    scene.overrideMaterial = this.normals;
    renderer.setRenderTarget(this.shape);
    renderer.clear();
    renderer.render(scene, camera);
    scene.overrideMaterial = null;
    const { uniforms, defines } = this.material;
    const isPerspective = camera instanceof THREE.PerspectiveCamera ? 1 : 0;
    if (defines.PERSPECTIVE_CAMERA !== isPerspective) {
      defines.PERSPECTIVE_CAMERA = isPerspective;
      this.material.needsUpdate = true;
    }
    uniforms.tDepth.value = this.shape.depthTexture;
    uniforms.tNormal.value = this.shape.texture;
    uniforms.resolution.value.set(width, height);
    uniforms.cameraNear.value = camera.near;
    uniforms.cameraFar.value = camera.far;
    uniforms.cameraProjectionMatrix.value.copy(camera.projectionMatrix);
    uniforms.cameraProjectionMatrixInverse.value.copy(camera.projectionMatrixInverse);
    uniforms.cameraWorldMatrix.value.copy(camera.matrixWorld);
    uniforms.radius.value = radius;
    uniforms.thickness.value = radius;
    uniforms.distanceExponent.value = 1.5;
    uniforms.scale.value = 1.35;
    renderer.setRenderTarget(this.target);
    this.quad.render(renderer);
    return this.target.texture;
  }
}

export interface OcclusionOptions {
  radius: number;
  clip: THREE.Plane[]; // The clip planes of solid materials.
}

export type SceneCamera = THREE.PerspectiveCamera | THREE.OrthographicCamera;
