// Lines whose width is in CSS pixels, so that they are as wide in enlarged pictures as on the screen.
import type * as THREE from "three";
import { LineMaterial } from "three/examples/jsm/lines/LineMaterial.js";
import { LineSegments2 } from "three/examples/jsm/lines/LineSegments2.js";
import { LineSegmentsGeometry } from "three/examples/jsm/lines/LineSegmentsGeometry.js";

import { layers } from "./layers";

export interface LineLook {
  color: THREE.ColorRepresentation;
  width: number; // In CSS pixels.
  opacity?: number; // 1 by default.
}

// `segments`: the coordinates of both ends of each segment. The GPU's 32-bit numbers count from the first end, which may be far
// from the origin.
export function wideLines(segments: Float32Array | number[], { color, width, opacity = 1 }: LineLook): LineSegments2 {
  const material = new LineMaterial({ color, linewidth: width, opacity, transparent: opacity < 1, clipping: true });
  const origin = [segments[0] ?? 0, segments[1] ?? 0, segments[2] ?? 0] as const;
  const lines = new LineSegments2(new LineSegmentsGeometry().setPositions(Array.from(segments, (value, i) => value - origin[i % 3])), material);
  lines.position.set(...origin);
  lines.layers.set(layers.marks);
  return lines;
}
