// Describes the estimated size of a surface beside what is drawn of it.
import { inBytes, inTriangleRange } from "../shared/quantities";
import type { StepFacts, SurfaceSize } from "../state/progress";

// Returns whether the full resolution is drawn instead of the surface that the allowed error needs: its samples arrive sooner,
// and are not simplified.
export function isFullResolution({ isFinal, shell }: StepFacts): boolean {
  return isFinal && shell !== null;
}

// Empty: the size is unknown.
export function expectedText(size: SurfaceSize | null, shown: StepFacts | null): string {
  if (!size) return "";
  const estimate = `${inTriangleRange(size.triangles, size.budget)}, about ${inBytes(size.bytes)}`;
  if (!shown || !isFullResolution(shown) || shown.triangles <= size.triangles) return estimate;
  return `As a file: ${estimate}`;
}
