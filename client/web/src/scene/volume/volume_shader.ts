// Marches rays through the samples of a volume, between depths of surfaces. Places are in coordinates of the texture; a
// ray's parameter is the length in the world from the near plane.
import { fractionInShader } from "../../shared/color_maps";
import { blockSide } from "./levels";

export const maxPlanes = 7; // A cut and the faces of a crop.

export const vertex = "varying vec2 vUv; void main() { vUv = uv; gl_Position = vec4(position.xy, 0.0, 1.0); }";

export const fragment = /* glsl */ `
  uniform highp sampler3D samples; // 0 to 1 over \`range\`; far below 0 where there is no value.
  uniform highp sampler3D blocks; // Of each block of cells: whether it is visible, and its largest value.
  uniform highp sampler2D solid; // Depths at which rays end, of opaque surfaces
  uniform highp sampler2D after; // and of the translucent layer behind this part, if any;
  uniform highp sampler2D before; // and at which they begin: of the layer in front of it, if any.
  uniform bool hasBefore;
  uniform bool hasAfter;
  uniform mat4 clipToTexture;
  uniform mat3 textureToWorld; // Of directions.
  uniform mat3 gradientToWorld;
  uniform vec3 counts; // Samples along each axis.
  uniform vec4 planes[${maxPlanes}]; // Half-spaces that are visible, as vec4(normal, distance).
  uniform int planeCount;
  uniform float stride; // Samples from one place on a ray to the next.
  uniform float voxel; // The thickness that opacities apply to, in the world.
  uniform vec2 range;
  uniform highp sampler2D opacities; // Opacities as extinctions, and their integrals from the first value on.
  uniform vec2 opacityEnds; // The values of the first and last opacity.
  uniform sampler2D colors;
  uniform bool hasLabels;
  uniform highp sampler3D labels; // The number of the label at each sample of their map: two bytes; 0: none.
  uniform mat4 toLabels;
  uniform sampler2D labelColors; // By number; transparent: hidden.
  uniform bool isOnlyLabels; // Samples without a label are transparent.
  uniform vec2 ends;
  uniform bool isLog;
  uniform bool isMaximum;
  uniform bool isShaded;
  uniform bool isQuick; // Half as many samples for shading.
  varying vec2 vUv;
  ${fractionInShader}

  vec3 placeAt(float depth) {
    vec4 place = clipToTexture * vec4(2.0 * vec3(vUv, depth) - 1.0, 1.0);
    return place.xyz / place.w;
  }

  vec3 colorOf(float value) {
    float share = fractionOf(mix(range.x, range.y, value), ends, isLog);
    return texture2D(colors, vec2((share * 255.0 + 0.5) / 256.0, 0.5)).rgb;
  }

  // Returns the color at a place with this value; transparent: it is hidden.
  vec4 colorAt(vec3 place, float value) {
    if (!hasLabels) return vec4(colorOf(value), 1.0);
    vec3 at = (toLabels * vec4(place, 1.0)).xyz;
    bool isOutside = any(lessThan(at, vec3(0.0))) || any(greaterThan(at, vec3(1.0)));
    int number = isOutside ? 0 : int(dot(texture(labels, at).rg, vec2(255.0, 65280.0)) + 0.5);
    return number > 0 ? texelFetch(labelColors, ivec2(number, 0), 0) : vec4(colorOf(value), isOnlyLabels ? 0.0 : 1.0);
  }

  // Returns the place of a value in the table of opacities: 0 to 1, or beyond; its extinction and the integral up to it.
  vec3 extinctionOf(float value) {
    float share = (mix(range.x, range.y, value) - opacityEnds.x) / (opacityEnds.y - opacityEnds.x);
    int last = textureSize(opacities, 0).x - 1;
    float at = clamp(share, 0.0, 1.0) * float(last);
    int before = min(int(at), last - 1);
    vec2 found = mix(texelFetch(opacities, ivec2(before, 0), 0).rg, texelFetch(opacities, ivec2(before + 1, 0), 0).rg, at - float(before));
    return vec3(share, found.r, found.g + found.r * (share - clamp(share, 0.0, 1.0)));
  }

  // Returns the mean extinction between two values, as if all between them occurred equally often.
  float meanExtinction(vec3 one, vec3 other) {
    float apart = other.x - one.x;
    return max(0.0, abs(apart) > 2e-3 ? (other.z - one.z) / apart : 0.5 * (one.y + other.y));
  }

  float sampleAt(vec3 place) {
    return texture(samples, place).r;
  }

  // Returns the values one sample further along each axis; with -1, before.
  vec3 beside(vec3 place, float way) {
    vec3 by = way / counts;
    return vec3(sampleAt(place + vec3(by.x, 0.0, 0.0)), sampleAt(place + vec3(0.0, by.y, 0.0)), sampleAt(place + vec3(0.0, 0.0, by.z)));
  }

  // Lit from the camera; without a slope, as it is. \`value\`: about that of the place.
  vec3 shaded(vec3 color, float value, vec3 place, vec3 ray) {
    vec3 slope = beside(place, 1.0) - (isQuick ? vec3(value) : beside(place, -1.0));
    vec3 gradient = gradientToWorld * (slope * counts);
    float steepness = length(gradient);
    if (steepness < 1e-12) return color;
    float facing = abs(dot(gradient, ray)) / steepness;
    return color * (0.3 + 0.75 * facing) + 0.18 * pow(facing, 24.0);
  }

  // Returns where the ray leaves the block that it is in.
  float endOfBlock(vec3 place, vec3 block, vec3 direction, float at) {
    vec3 border = ((block + step(vec3(0.0), direction)) * ${blockSide}.0 + 0.5) / counts;
    vec3 ahead = (border - place) / direction;
    return at + max(0.0, min(ahead.x, min(ahead.y, ahead.z)));
  }

  void main() {
    gl_FragColor = vec4(0.0);
    ivec2 pixel = ivec2(vUv * vec2(textureSize(solid, 0)));
    float nearDepth = hasBefore ? texelFetch(before, pixel, 0).r : 0.0;
    float farDepth = texelFetch(solid, pixel, 0).r;
    if (hasAfter) farDepth = min(farDepth, texelFetch(after, pixel, 0).r);
    if (nearDepth >= farDepth) return;
    vec3 origin = placeAt(0.0);
    vec3 whole = placeAt(1.0) - origin;
    float worldLength = length(textureToWorld * whole);
    vec3 direction = whole / worldLength;
    direction += vec3(lessThan(abs(direction), vec3(1e-12))) * 1e-12;
    float perUnit = worldLength / dot(whole, whole);
    float first = nearDepth > 0.0 ? dot(placeAt(nearDepth) - origin, whole) * perUnit : 0.0;
    float last = farDepth < 1.0 ? dot(placeAt(farDepth) - origin, whole) * perUnit : worldLength;

    vec3 low = (0.5 / counts - origin) / direction;
    vec3 high = (1.0 - 0.5 / counts - origin) / direction;
    vec3 enter = min(low, high);
    vec3 leave = max(low, high);
    float entered = max(max(enter.x, enter.y), enter.z);
    first = max(first, entered);
    last = min(last, min(min(leave.x, leave.y), leave.z));
    for (int i = 0; i < planeCount; ++i) {
      float here = dot(planes[i].xyz, origin) + planes[i].w;
      float growth = dot(planes[i].xyz, direction);
      if (growth > 0.0) first = max(first, -here / growth);
      else if (growth < 0.0) last = min(last, -here / growth);
      else if (here < 0.0) return;
    }

    vec3 inSamples = abs(direction * counts);
    float spacing = stride / max(inSamples.x, max(inSamples.y, inSamples.z));
    // The same places in all parts of a ray. Noise replaces rings; the largest value is at a sample.
    float noise = isMaximum || isQuick ? 0.0 : fract(52.9829189 * fract(dot(gl_FragCoord.xy, vec2(0.06711056, 0.00583715))));
    float phase = entered + noise * spacing;
    float number = ceil((first - phase) / spacing - 1e-3);
    float thickness = spacing / voxel;
    vec3 ray = textureToWorld * direction;
    vec3 lastBlock = vec3(textureSize(blocks, 0) - 1);
    float largest = -1.0;
    float value = -1.0; // At the place before the current one, if that is number \`reached\` - 1.
    float reached = -1.0;
    vec3 extinction = vec3(0.0);
    vec4 sum = vec4(0.0);
    float at = phase + number * spacing;
    last += 1e-3 * spacing;
    while (at <= last) {
      vec3 place = origin + at * direction;
      vec3 block = clamp(floor((place * counts - 0.5) / ${blockSide}.0 + 1e-4 * sign(direction)), vec3(0.0), lastBlock);
      vec2 found = texelFetch(blocks, ivec3(block), 0).rg;
      float until = min(last, endOfBlock(place, block, direction, at));
      if (found.r == 0.0 || (isMaximum && found.g <= largest)) {
        number += max(1.0, ceil((until - at) / spacing));
        at = phase + number * spacing;
        continue;
      }
      if (!isMaximum && number != reached) {
        value = sampleAt(origin + max(at - spacing, entered) * direction);
        extinction = extinctionOf(value);
      }
      do {
        place = origin + at * direction;
        float before = value;
        value = sampleAt(place);
        largest = max(largest, value);
        if (!isMaximum && value > -1e-3) {
          vec3 extinctionBefore = extinction;
          extinction = extinctionOf(value);
          float mean = before > -1e-3 ? meanExtinction(extinctionBefore, extinction) : extinction.y;
          if (mean > 0.0) {
            float middle = before > -1e-3 ? 0.5 * (before + value) : value;
            vec3 between = place - 0.5 * spacing * direction;
            vec4 color = colorAt(between, middle);
            if (isShaded && color.a > 0.0) color.rgb = shaded(color.rgb, middle, between, ray);
            float part = color.a * (1.0 - sum.a) * (1.0 - exp(-mean * thickness));
            sum += vec4(part * color.rgb, part);
            if (sum.a > 0.996) break;
          }
        }
        number += 1.0;
        at = phase + number * spacing;
      } while (at < until);
      reached = number;
      if (sum.a > 0.996) break;
    }
    if (isMaximum && largest > -1e-3) sum = vec4(colorOf(max(largest, 0.0)), 1.0);
    gl_FragColor = sum;
  }`;
