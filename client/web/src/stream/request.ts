// Converts settings to a request. All fields are set, so that the server's copy can be compared with it.
import { create, equals } from "@bufbuild/protobuf";

import {
  BallShapeSchema,
  BoxShapeSchema,
  Combination,
  CoordinateSystem,
  type DatasetInfo,
  ErrorMeasure,
  ErrorUnit,
  FrustumSchema,
  type IsosurfaceRequest,
  IsosurfaceRequestSchema,
  ThresholdMapSchema,
  ThresholdRegionSchema,
  ThresholdViewSchema,
  TopologyRule,
} from "../protocol/messages";
import type { Region } from "../state/settings";
import type { OwnSettings } from "../state/surfaces";
import { voxelLength, worldBox } from "./dataset";

export interface View {
  eye: number[];
  target: number[];
  up: number[];
  fieldOfView: number; // Vertical, degrees.
  heightPixels: number;
  aspect: number;
  requiredBy?: ReadonlySet<string>; // Surfaces that cannot be shown without it, by their keys.
  isOnlyRequired?: boolean; // Others do without.
}

// Identifies a surface.
export function surfaceKey({ name }: DatasetInfo, isovalue: number): string {
  return `${name} ${isovalue}`;
}

const defaultLatticeResolution = 5;
const maxLatticeBits = 20;
const normalBits = 8;

export function latticeResolution(info: DatasetInfo): number {
  return Math.min(defaultLatticeResolution, maxLatticeBits - info.gridExponent);
}

// Returns the initial isovalue.
export function suggestedIsovalue(info: DatasetInfo): number {
  return info.suggestedIsovalues[0] ?? (info.min + info.max) / 2;
}

export function isosurfaceRequest(info: DatasetInfo, settings: OwnSettings, view: View | null): IsosurfaceRequest {
  return create(IsosurfaceRequestSchema, {
    isovalue: settings.isovalue ?? suggestedIsovalue(info),
    threshold: create(ThresholdMapSchema, {
      error: settings.error,
      unit: ErrorUnit.VOXEL,
      regionCoordinates: CoordinateSystem.WORLD,
      ...localThresholds(info, settings, view),
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

// If a pixel at the nearest place of the data is smaller than the allowed error, the smaller of the two applies
// everywhere; the box carries the error, because the view replaces it. Otherwise the request has no view and does not
// change as the camera turns, unless it requires one. With a region coarser than the rest, the regions apply in order.
function localThresholds(info: DatasetInfo, settings: OwnSettings, view: View | null) {
  const { region, error, followView, pixels } = settings;
  const regions = region ? [thresholdRegion(region)] : [];
  const isRequired = view?.requiredBy?.has(surfaceKey(info, settings.isovalue ?? suggestedIsovalue(info)));
  const isFiner = view !== null && !view.isOnlyRequired && !(region && region.error > error) && nearestPixel(info, view) * pixels < error;
  if (!followView || !view || !(isFiner || isRequired)) return { combine: Combination.IN_ORDER, regions };
  const whole = { kind: "box" as const, ...widened(worldBox(info)), error };
  return { combine: Combination.MINIMUM, regions: [thresholdRegion(whole), ...regions], view: thresholdView(view, pixels, error) };
}

// Returns the size of a pixel in voxels at the place of the data's box nearest to the eye; 0 inside the box.
export function nearestPixel(info: DatasetInfo, { eye, fieldOfView, heightPixels }: View): number {
  const { low, high } = worldBox(info);
  const distance = Math.hypot(...eye.map((at, axis) => Math.max(low[axis] - at, 0, at - high[axis])));
  const height = 2 * distance * Math.tan((fieldOfView * Math.PI) / 360);
  return height / heightPixels / voxelLength(info);
}

// Enlarges the box by its largest side: a surface may end one step beyond the samples.
function widened({ low, high }: ReturnType<typeof worldBox>): ReturnType<typeof worldBox> {
  const by = Math.max(...low.map((at, axis) => high[axis] - at), 1e-6);
  const moved = (from: readonly number[], step: number) => from.map((at) => at + step) as typeof low;
  return { low: moved(low, -by), high: moved(high, by) };
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
          value: create(BallShapeSchema, { center: region.center, radius: region.radius }),
        };
  return create(ThresholdRegionSchema, { threshold: region.error, shape });
}

function thresholdView(view: View, pixels: number, outside: number) {
  return create(ThresholdViewSchema, {
    eye: view.eye,
    fieldOfView: view.fieldOfView,
    heightPixels: view.heightPixels,
    tolerancePixels: pixels,
    frustum: create(FrustumSchema, {
      lookAt: view.target,
      up: view.up,
      aspect: view.aspect,
      outside,
    }),
  });
}
