// Maps the values of a second field to colors on surfaces; shared by all surfaces of a view.
import * as THREE from "three";

import { type ColorMap, type ColorScale, colorRow, endsOf, fractionInShader } from "../shared/color_maps";

export class FieldColors {
  readonly uniforms = {
    fieldColors: { value: null as THREE.DataTexture | null },
    fieldRange: { value: new THREE.Vector2(0, 1) }, // The values spanned by the surface's scalars.
    fieldEnds: { value: new THREE.Vector2(0, 1) }, // The range of the colors, from endsOf().
    fieldIsLog: { value: false },
    fieldNoValue: { value: new THREE.Color() }, // The color where there is no value.
  };
  private map: ColorMap | null = null;
  private look = ""; // Identifies the uniforms' values.

  // `changed` is called when the colors of surfaces change.
  constructor(private readonly changed: () => void) {}

  // `range`: the values spanned by the surfaces' scalars. `noValue`: the color where the field has no value.
  setLook({ map, ...scale }: ColorScale, range: { min: number; max: number }, noValue: string): void {
    const look = JSON.stringify([map, scale, range.min, range.max, noValue]);
    if (look === this.look) return;
    this.look = look;
    this.uniforms.fieldRange.value.set(range.min, range.max);
    this.uniforms.fieldEnds.value.set(...endsOf(scale));
    this.uniforms.fieldIsLog.value = scale.isLog;
    this.uniforms.fieldNoValue.value.set(noValue);
    if (map !== this.map) this.setMap(map);
    this.changed();
  }

  private setMap(map: ColorMap): void {
    this.uniforms.fieldColors.value?.dispose();
    const row = new THREE.DataTexture(colorRow(map, 256), 256, 1);
    row.colorSpace = THREE.SRGBColorSpace;
    row.needsUpdate = true;
    this.uniforms.fieldColors.value = row;
    this.map = map;
  }

  // Call in onBeforeCompile of a surface's material.
  addToShader(shader: THREE.WebGLProgramParametersWithUniforms): void {
    Object.assign(shader.uniforms, this.uniforms);
    shader.vertexShader = shader.vertexShader
      .replace("#include <common>", "#include <common>\nattribute float scalar;\nvarying float vScalar;")
      .replace("#include <begin_vertex>", "#include <begin_vertex>\nvScalar = scalar;");
    shader.fragmentShader = shader.fragmentShader
      .replace(
        "#include <common>",
        "#include <common>\nuniform sampler2D fieldColors;\nuniform vec2 fieldRange;\nuniform vec2 fieldEnds;\n" +
          `uniform bool fieldIsLog;\nuniform vec3 fieldNoValue;\nvarying float vScalar;\n${fractionInShader}`,
      )
      .replace(
        "#include <color_fragment>",
        "#include <color_fragment>\n" +
          "if (vScalar >= 0.999) {\n" +
          "  float fieldValue = mix(fieldRange.x, fieldRange.y, vScalar - 1.0);\n" +
          "  float fieldShare = fractionOf(fieldValue, fieldEnds, fieldIsLog);\n" +
          "  diffuseColor.rgb = texture2D(fieldColors, vec2((fieldShare * 255.0 + 0.5) / 256.0, 0.5)).rgb;\n" +
          "} else if (vScalar != 0.0) diffuseColor.rgb = fieldNoValue;",
      );
  }
}
