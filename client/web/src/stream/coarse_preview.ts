// The first request for a label where many are shown: one preview, coarse enough to take a small part of the final
// step's time, and fine enough to keep the label's shape.
import { create } from "@bufbuild/protobuf";

import { type DatasetInfo, type Preview, PreviewSchema, ShellStepSchema, ShellValues } from "../protocol/messages";

const cellsAcross = 4; // The least number, along the label's shortest side.
const levelsPerOctave = 2; // Vertices move by less than a sixth of the spacing.

// Requests sample shells, or a mesh. Returns null if the label's box is unknown; then the server chooses.
export function coarsePreview({ member }: DatasetInfo, isInShells = false): Preview | null {
  const box = member?.label?.box;
  if (box?.length !== 6) return null;
  const shortest = Math.min(...[0, 1, 2].map((axis) => box[3 + axis] - box[axis] + 1));
  const finestSpacing = 2 ** Math.floor(Math.log2(Math.max(1, shortest / cellsAcross)));
  if (!isInShells) return create(PreviewSchema, { finestSpacing, isUnsimplified: true });
  return create(PreviewSchema, { finestSpacing, shell: create(ShellStepSchema, { values: ShellValues.QUANTIZED, levelsPerOctave }) });
}
