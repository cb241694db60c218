// How the values of a second field become colours on surfaces. One for all surfaces of a view.
import * as THREE from "three";

import { type ColourMap, colourRow } from "./colour_maps";

export class FieldColours {
  readonly uniforms = {
    fieldColours: { value: null as THREE.DataTexture | null },
    fieldRange: { value: new THREE.Vector2(0, 1) }, // What the surface's numbers span, in values.
    fieldWindow: { value: new THREE.Vector2(0, 1) }, // The values of the first and the last colour.
  };
  private map: ColourMap | null = null;

  setRange(low: number, high: number): void {
    this.uniforms.fieldRange.value.set(low, high);
  }

  setLook(map: ColourMap, low: number, high: number): void {
    this.uniforms.fieldWindow.value.set(low, high > low ? high : low + 1e-6 * Math.max(1, Math.abs(low)));
    if (map === this.map) return;
    this.uniforms.fieldColours.value?.dispose();
    const row = new THREE.DataTexture(colourRow(map, 256), 256, 1);
    row.colorSpace = THREE.SRGBColorSpace;
    row.needsUpdate = true;
    this.uniforms.fieldColours.value = row;
    this.map = map;
  }

  // In onBeforeCompile of a surface's material. Places without a value are grey.
  enter(shader: THREE.WebGLProgramParametersWithUniforms): void {
    Object.assign(shader.uniforms, this.uniforms);
    shader.vertexShader = shader.vertexShader
      .replace("#include <common>", "#include <common>\nattribute float scalar;\nvarying float vScalar;")
      .replace("#include <begin_vertex>", "#include <begin_vertex>\nvScalar = scalar;");
    shader.fragmentShader = shader.fragmentShader
      .replace("#include <common>",
        "#include <common>\nuniform sampler2D fieldColours;\nuniform vec2 fieldRange;\nuniform vec2 fieldWindow;\nvarying float vScalar;")
      .replace("#include <color_fragment>",
        "#include <color_fragment>\n" +
          "if (vScalar >= 0.999) {\n" +
          "  float fieldValue = mix(fieldRange.x, fieldRange.y, vScalar - 1.0);\n" +
          "  float fieldShare = clamp((fieldValue - fieldWindow.x) / (fieldWindow.y - fieldWindow.x), 0.0, 1.0);\n" +
          "  diffuseColor.rgb = texture2D(fieldColours, vec2((fieldShare * 255.0 + 0.5) / 256.0, 0.5)).rgb;\n" +
          "} else if (vScalar != 0.0) diffuseColor.rgb = vec3(0.35);");
  }
}
