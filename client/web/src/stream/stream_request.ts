// A request for the steps of one surface.
import type { DatasetInfo, IsosurfaceRequest } from "../protocol/messages";
import { isSameRequest } from "./request";

// "coarse": one preview of a label with a spacing chosen here (coarse_preview.ts); "previews" if its box is unknown.
export type RequestedSteps = "all" | "previews" | "coarse" | "final";

export interface StreamRequest {
  info: DatasetInfo;
  isosurface: IsosurfaceRequest;
  steps?: RequestedSteps; // Default: all.
  scalars?: ScalarOptions;
}

// A dataset whose values are requested at the vertices, and their range.
export interface ScalarOptions {
  dataset: string;
  low?: number; // Both or neither; default: the dataset's range.
  high?: number;
}

// Whether both requests give the same surface in the same colors; the steps on the way do not matter.
export function isSameStream(a: StreamRequest, b: StreamRequest): boolean {
  const [x, y] = [a.scalars, b.scalars];
  const isSameColoring = x?.dataset === y?.dataset && x?.low === y?.low && x?.high === y?.high;
  return a.info === b.info && isSameColoring && isSameRequest(a.isosurface, b.isosurface);
}
