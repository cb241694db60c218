// Settings -> the request. All fields are set, so that what the server repeats can
// be compared with it.
import { create, equals } from "@bufbuild/protobuf";

import {
  Combination,
  CoordinateSystem,
  type DatasetInfo,
  ErrorMeasure,
  FrustumSchema,
  type IsosurfaceRequest,
  IsosurfaceRequestSchema,
  LengthUnit,
  ThresholdMapSchema,
  ThresholdRegionSchema,
  ThresholdViewSchema,
  TopologyRule,
  BallShapeSchema,
  BoxShapeSchema,
} from "../protocol/messages";
import type { Region, Settings } from "../state/settings";

export interface View {
  eye: number[];
  target: number[];
  up: number[];
  fieldOfView: number; // Vertical, degrees.
  heightPixels: number;
  aspect: number;
}

const defaultLatticeResolution = 5;
const maxLatticeBits = 20;
const normalBits = 8;
const coarsestOutsideView = 8; // Voxels: the threshold behind the camera.

export function latticeResolution(info: DatasetInfo): number {
  return Math.min(defaultLatticeResolution, maxLatticeBits - info.gridExponent);
}

// A good isovalue to begin with.
export function suggestedIsovalue(info: DatasetInfo): number {
  return info.suggestedIsovalues[0] ?? (info.min + info.max) / 2;
}

export function isosurfaceRequest(
  info: DatasetInfo,
  settings: Settings,
  view: View | null,
): IsosurfaceRequest {
  return create(IsosurfaceRequestSchema, {
    isovalue: settings.isovalue ?? suggestedIsovalue(info),
    threshold: create(ThresholdMapSchema, {
      error: settings.error,
      unit: LengthUnit.VOXEL,
      regionUnit: CoordinateSystem.WORLD,
      combine: Combination.IN_ORDER,
      regions: settings.region ? [thresholdRegion(settings.region)] : [],
      view: settings.followView && view ? thresholdView(view, settings.pixels) : undefined,
      atLeast: 0,
    }),
    bound: settings.bound === "certified" ? ErrorMeasure.CERTIFIED : ErrorMeasure.PAPER,
    topologyRule: settings.topologyRule === "exact" ? TopologyRule.EXACT : TopologyRule.PAPER,
    topologyTolerance: settings.topologyTolerance,
    lattice: latticeResolution(info),
    maxTriangles: BigInt(settings.maxTriangles),
    simplify: settings.simplify,
    normals: settings.shading === "field" ? normalBits : 0,
  });
}

export function isSameRequest(a: IsosurfaceRequest, b: IsosurfaceRequest): boolean {
  return equals(IsosurfaceRequestSchema, a, b);
}

function thresholdRegion(region: Region) {
  const shape =
    region.kind === "box"
      ? {
          case: "box" as const,
          value: create(BoxShapeSchema, { low: region.low, high: region.high }),
        }
      : {
          case: "ball" as const,
          value: create(BallShapeSchema, { centre: region.centre, radius: region.radius }),
        };
  return create(ThresholdRegionSchema, { threshold: region.error, shape });
}

function thresholdView(view: View, pixels: number) {
  return create(ThresholdViewSchema, {
    eye: view.eye,
    fieldOfView: view.fieldOfView,
    heightPixels: view.heightPixels,
    tolerancePixels: pixels,
    frustum: create(FrustumSchema, {
      lookAt: view.target,
      up: view.up,
      aspect: view.aspect,
      outside: coarsestOutsideView,
    }),
  });
}
