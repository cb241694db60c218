// Names of the world's directions: the patient's sides if the space is known.
import { type DatasetInfo, WorldSpace } from "../protocol/messages";
import type { Vec3 } from "../stream/dataset";

export interface AxisName {
  letter: string;
  word: string; // "the left"
  direction: Vec3;
}

const patient = {
  L: "the patient's left",
  R: "the patient's right",
  P: "behind the patient",
  A: "the patient's front",
  S: "above the patient",
  I: "below the patient",
} as const;
type Side = keyof typeof patient;

// Returns the ends of x, y and z, the positive end of each first.
export function axisNames({ space }: Pick<DatasetInfo, "space">): AxisName[] {
  const sides: Side[] | null = space === WorldSpace.LPS ? ["L", "R", "P", "A", "S", "I"] : space === WorldSpace.RAS ? ["R", "L", "A", "P", "S", "I"] : null;
  return [0, 1, 2].flatMap((axis) =>
    [1, -1].map((sign, end) => {
      const side = sides?.[2 * axis + end];
      const direction: Vec3 = [0, 0, 0];
      direction[axis] = sign;
      const plain = `${sign > 0 ? "" : "−"}${"xyz"[axis]}`;
      return { letter: side ?? plain, word: side ? patient[side] : `${plain} of the world`, direction };
    }),
  );
}
