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

// `segments`: the coordinates of both ends of each segment.
export function wideLines(segments: Float32Array | number[], { color, width, opacity = 1 }: LineLook): LineSegments2 {
  const material = new LineMaterial({ color, linewidth: width, opacity, transparent: opacity < 1, clipping: true });
  const lines = new LineSegments2(new LineSegmentsGeometry().setPositions(segments), material);
  lines.layers.set(layers.marks);
  return lines;
}
