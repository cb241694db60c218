// Writes the visible labels as a table for spreadsheets, with the measures of their shown surfaces.
import type { MassProperties } from "../mesh/mass_properties";
import type { Label } from "../protocol/messages";
import { inDigits } from "../shared/quantities";

export interface MeasuredLabel {
  label: Label;
  found: MassProperties | null; // Null: not measured.
  bound: number | null; // The surface's error in world units; null: unknown.
}

// Returns CSV with a header. Unknown volumes and bounds are empty. Volumes have more digits than their bounds allow, for
// sums and differences.
export function labelTable(labels: readonly MeasuredLabel[], lengthUnit: string): string {
  const unit = lengthUnit || "unit";
  const header = ["label", "name", `volume_${unit}3`, `volume_bound_${unit}3`, `area_about_${unit}2`, "triangles"];
  const rows = labels.map(({ label, found, bound }) => {
    const volumeBound = found && found.volume !== null && bound !== null ? bound * found.area : null;
    const numbers = [found?.volume, volumeBound, found?.area, found?.triangles];
    return [String(label.value), quoted(label.name), ...numbers.map((number, at) => (number == null ? "" : inDigits(number, at === 1 ? 3 : 7)))];
  });
  return [header, ...rows].map((row) => `${row.join(",")}\r\n`).join("");
}

function quoted(text: string): string {
  return /[",\r\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
}
