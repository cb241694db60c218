// Estimated sizes of surfaces: when to request them, and which sizes require confirmation.
import { create, type DatasetInfo, type EstimateReply, IsosurfaceRequestSchema } from "../protocol/messages";
import type { SurfaceSize } from "../state/progress";
import { Store } from "../state/store";
import { voxelLength } from "../stream/dataset";
import { isSameRequest } from "../stream/request";
import type { StreamRequest } from "../stream/stream_request";

// Larger surfaces require confirmation.
const maxUnconfirmed = 5_000_000;
// Acceptable for every machine.
const safeTriangles = 2_000_000;
// Triangles of a ball's full-resolution surface, divided by its number of samples^(2/3). Other shapes have more,
// coarser surfaces far fewer.
const trianglesOfBall = 30;

// Returns the share of a view's triangles that a label needs, by its number of samples; 1 for other surfaces.
export function shareOfLabel(info: DatasetInfo): number {
  return Math.min(1, (trianglesOfLabel(info) ?? Infinity) / maxUnconfirmed);
}

function trianglesOfLabel({ member }: DatasetInfo): number | null {
  const samples = Number(member?.label?.samples ?? 0);
  return samples > 0 ? trianglesOfBall * samples ** (2 / 3) : null;
}

export class ExpectedSizes extends Store<{ expected: SurfaceSize | null }> {
  private last: { info: DatasetInfo; isosurface: StreamRequest["isosurface"] } | null = null; // The last request.
  surfaceCount = 1; // The number of surfaces in the view, which share its limits; small labels count by shareOfLabel().
  private confirmed = 0; // Triangles that the user confirmed.

  constructor() {
    super({ expected: null });
  }

  // Returns whether to request the size of this request now. Not while dragging the isovalue, when the size is unknown.
  isWanted(request: StreamRequest, isDragging: boolean): boolean {
    const { last } = this;
    const isOther = last?.info !== request.info || last.isosurface.isovalue !== request.isosurface.isovalue;
    if (isOther) this.set({ expected: null });
    if (isOther ? isDragging : isSameRequest(last.isosurface, request.isosurface)) return false;
    this.last = request;
    return true;
  }

  // Returns whether the label is small enough, by its number of samples, to need no confirmation. Estimates of small
  // labels take the server as long as their surfaces.
  isSmall(info: DatasetInfo): boolean {
    return (trianglesOfLabel(info) ?? Infinity) <= maxUnconfirmed * this.share;
  }

  // Call when the request has failed.
  forget(request: StreamRequest): void {
    if (this.last === request) this.last = null;
  }

  record(request: StreamRequest, { triangles, bytes, errorBoundWorld }: Pick<EstimateReply, "triangles" | "bytes" | "errorBoundWorld">): SurfaceSize {
    const errorVoxels = errorBoundWorld / voxelLength(request.info);
    const expected = { triangles: Number(triangles), budget: Number(request.isosurface.maxTriangles), bytes: Number(bytes), errorVoxels };
    this.set({ expected });
    return expected;
  }

  isAllowed(size: SurfaceSize): boolean {
    return size.triangles <= Math.max(this.confirmed, maxUnconfirmed * this.share);
  }

  // Accepts surfaces of this size for the user; up to 1.5 times as many triangles need no further confirmation.
  confirm(size: SurfaceSize): void {
    this.confirmed = Math.max(this.confirmed, 1.5 * size.triangles);
  }

  // Returns the request with a budget.
  withBudget(request: StreamRequest): StreamRequest {
    const maxTriangles = BigInt(Math.ceil(safeTriangles * this.share));
    return { ...request, isosurface: create(IsosurfaceRequestSchema, { ...request.isosurface, maxTriangles }) };
  }

  private get share(): number {
    return 2 / Math.max(2, this.surfaceCount);
  }
}
