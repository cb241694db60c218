// A slice of the samples in the scene: a rectangle with the field's colors and the lines where it cuts the surfaces. A
// filled cut shows it only where the field is above an isovalue.
import * as THREE from "three";
import type { LineSegments2 } from "three/examples/jsm/lines/LineSegments2.js";
import { type ColorMap, type ColorScale, colorRow, endsOf, fractionInShader } from "../shared/color_maps";
import type { Affine, Vec3 } from "../stream/dataset";
import type { SliceValues } from "../stream/dataset_queries";
import { affineMatrix } from "./affine_matrix";
import { layers } from "./layers";
import { gridCorners, valueAt } from "./slice_grid";
import { wideLines } from "./wide_lines";

export interface SliceLook extends ColorScale {
  above: number; // Nothing is drawn below this value; -Infinity: everything is drawn.
}

export interface CutLines {
  segments: Float32Array; // Lattice coordinates.
  toWorld: Affine;
  color: string;
  label: string | null; // The name of the surface's label.
}

const vertex = /* glsl */ `
  varying vec2 place;
  #include <clipping_planes_pars_vertex>
  void main() {
    place = uv;
    vec4 mvPosition = modelViewMatrix * vec4(position, 1.0);
    gl_Position = projectionMatrix * mvPosition;
    #include <clipping_planes_vertex>
  }`;

const fragment = /* glsl */ `
  uniform highp sampler2D values;
  uniform sampler2D colors;
  uniform vec2 ends;
  uniform bool isLog;
  uniform float above;
  varying vec2 place;
  #include <clipping_planes_pars_fragment>
  ${fractionInShader}

  // Returns the value, interpolated linearly between pixel centers, and that of the nearest pixel where one has no value.
  float valueHere() {
    ivec2 size = textureSize(values, 0);
    vec2 at = place * vec2(size - 1);
    ivec2 first = clamp(ivec2(floor(at)), ivec2(0), size - 1);
    ivec2 last = min(first + 1, size - 1);
    vec2 part = clamp(at - vec2(first), 0.0, 1.0);
    float a = texelFetch(values, first, 0).r;
    float b = texelFetch(values, ivec2(last.x, first.y), 0).r;
    float c = texelFetch(values, ivec2(first.x, last.y), 0).r;
    float d = texelFetch(values, last, 0).r;
    float near = texelFetch(values, clamp(ivec2(at + 0.5), ivec2(0), size - 1), 0).r;
    float mean = mix(mix(a, b, part.x), mix(c, d, part.x), part.y);
    return isnan(mean) ? near : mean;
  }

  void main() {
    #include <clipping_planes_fragment>
    float value = valueHere();
    if (isnan(value) || value < above) discard;
    float share = fractionOf(value, ends, isLog);
    gl_FragColor = vec4(texture2D(colors, vec2((share * 255.0 + 0.5) / 256.0, 0.5)).rgb, 1.0);
    #include <colorspace_fragment>
  }`;

export class SlicePlane {
  private readonly material = new THREE.ShaderMaterial({
    uniforms: {
      values: { value: null },
      colors: { value: null },
      above: { value: 0 },
      ends: { value: new THREE.Vector2(0, 1) },
      isLog: { value: false },
    },
    vertexShader: vertex,
    fragmentShader: fragment,
    clipping: true,
    side: THREE.DoubleSide,
    polygonOffset: true, // The lines are in front.
    polygonOffsetFactor: 1,
    polygonOffsetUnits: 2,
  });
  private readonly quad = new THREE.Mesh(new THREE.BufferGeometry(), this.material);
  private readonly lines = new THREE.Group();
  private shown: SliceValues | null = null;
  private look: SliceLook = { map: "gray", low: 0, high: 1, isLog: false, above: -Infinity };
  private map: ColorMap | null = null;
  private clip: THREE.Plane[] = [];

  constructor(
    scene: THREE.Scene,
    private readonly invalidate: () => void,
  ) {
    this.quad.visible = false;
    this.quad.layers.set(layers.marks);
    this.quad.geometry.setAttribute("position", new THREE.Float32BufferAttribute(new Float32Array(12), 3));
    this.quad.geometry.setAttribute("uv", new THREE.Float32BufferAttribute([0, 0, 1, 0, 0, 1, 1, 1], 2));
    this.quad.geometry.setIndex([0, 1, 2, 2, 1, 3]);
    this.quad.frustumCulled = false;
    scene.add(this.quad, this.lines);
  }

  // Null: none.
  show(slice: SliceValues | null): void {
    if (!slice && !this.shown && this.lines.children.length === 0) return;
    this.quad.visible = slice !== null;
    if (slice && slice !== this.shown) this.place(slice);
    this.shown = slice;
    if (!slice) this.showLines([]);
    this.invalidate();
  }

  // Draws it inside the half-spaces `clip`.
  setLook(look: SliceLook, clip: readonly THREE.Plane[]): void {
    this.look = look;
    this.clip = this.material.clippingPlanes = [...clip];
    for (const line of this.lines.children as LineSegments2[]) line.material.clippingPlanes = this.clip;
    const { uniforms } = this.material;
    uniforms.ends.value.set(...endsOf(look));
    uniforms.isLog.value = look.isLog;
    uniforms.above.value = Math.max(look.above, -3e38); // GLSL has no infinity.
    if (look.map !== this.map) {
      uniforms.colors.value?.dispose();
      const row = new THREE.DataTexture(colorRow(look.map, 256), 256, 1);
      row.colorSpace = THREE.SRGBColorSpace;
      row.needsUpdate = true;
      uniforms.colors.value = row;
      this.map = look.map;
    }
    this.invalidate();
  }

  showLines(all: readonly CutLines[]): void {
    for (const one of this.lines.children as LineSegments2[]) {
      one.geometry.dispose();
      one.material.dispose();
    }
    this.lines.clear();
    for (const { segments, toWorld, color } of all) {
      const line = wideLines(segments, { color, width: 1.5 });
      line.material.clippingPlanes = this.clip;
      line.matrixAutoUpdate = false;
      line.matrix.copy(affineMatrix(toWorld)).multiply(new THREE.Matrix4().setPosition(line.position));
      this.lines.add(line);
    }
    this.invalidate();
  }

  // Returns where a ray hits the drawn part.
  hit(ray: THREE.Ray): Vec3 | null {
    if (!this.quad.visible || !this.shown) return null;
    const { origin, right, down } = this.shown.grid;
    const normal = new THREE.Vector3(...right).cross(new THREE.Vector3(...down)).normalize();
    const plane = new THREE.Plane().setFromNormalAndCoplanarPoint(normal, new THREE.Vector3(...origin));
    const place = ray.intersectPlane(plane, new THREE.Vector3())?.toArray();
    if (!place || this.clip.some((half) => half.distanceToPoint(new THREE.Vector3(...place)) < 0)) return null;
    const value = valueAt(this.shown, place);
    return Number.isNaN(value) || value < this.look.above ? null : place;
  }

  private place({ grid, values }: SliceValues): void {
    const position = this.quad.geometry.getAttribute("position") as THREE.BufferAttribute;
    const { origin } = grid; // The GPU's 32-bit numbers count from here.
    position.array.set(gridCorners(grid).flatMap((corner) => corner.map((value, axis) => value - origin[axis])));
    this.quad.position.set(...origin);
    position.needsUpdate = true;
    const texture = new THREE.DataTexture(values as Float32Array<ArrayBuffer>, grid.width, grid.height, THREE.RedFormat, THREE.FloatType);
    texture.needsUpdate = true;
    this.material.uniforms.values.value?.dispose();
    this.material.uniforms.values.value = texture;
  }
}
