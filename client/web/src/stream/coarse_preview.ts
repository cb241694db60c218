// What is requested first of a label where many are shown: one preview, so coarse that it takes the server a small part
// of the final step's time, and so fine that the label still has its form.
import { create } from "@bufbuild/protobuf";

import { type DatasetInfo, type Preview, PreviewSchema } from "../protocol/messages";

const cellsAcross = 4; // At least, along the label's shortest side.

// Null: where the label lies is not known, and the server chooses.
export function coarsePreview({ member }: DatasetInfo): Preview | null {
  const box = member?.label?.box;
  if (box?.length !== 6) return null;
  const shortest = Math.min(...[0, 1, 2].map((axis) => box[3 + axis] - box[axis] + 1));
  const finestSpacing = 2 ** Math.floor(Math.log2(Math.max(1, shortest / cellsAcross)));
  return create(PreviewSchema, { finestSpacing, isUnsimplified: true });
}
