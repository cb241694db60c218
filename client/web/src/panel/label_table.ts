// Writes labels as a table for spreadsheets, with the measures of their shown surfaces.
import { type MassProperties, volumeBound } from "../mesh/mass_properties";
import type { Label } from "../protocol/messages";
import { inDigits } from "../shared/quantities";

export interface MeasuredLabel {
  label: Label;
  samplesVolume: number; // In cubed world units; 0: unknown.
  found: MassProperties | null; // Null: not shown, and thus not measured.
  bound: number | null; // The surface's error in world units; null: unknown.
  centroid: readonly number[] | null; // The centroid of the label's samples, in world coordinates; null: unknown.
}

// Returns CSV with a header of ASCII letters, which all programs read. Unknown numbers are empty. Volumes have more
// digits than their bounds allow, for sums and differences.
export function labelTable(labels: readonly MeasuredLabel[], lengthUnit: string): string {
  const unit = (lengthUnit || "unit").replace(/[\u00b5\u03bc]/g, "u");
  const header = [
    "label",
    "name",
    "samples",
    `samples_volume_${unit}3`,
    `volume_${unit}3`,
    `volume_bound_${unit}3`,
    `area_about_${unit}2`,
    ...[..."xyz"].map((axis) => `centroid_${axis}_${unit}`),
    "triangles",
  ];
  const rows = labels.map(({ label, samplesVolume, found, bound, centroid }) => {
    const off = found && found.volume !== null && bound !== null ? volumeBound(found, bound) : null;
    const numbers = [samplesVolume || null, found?.volume, off, found?.area];
    const sizes = numbers.map((number, at) => (number == null ? "" : inDigits(number, at === 2 ? 3 : 7)));
    const texts = [...sizes, ...(centroid ?? ["", "", ""]).map(String)];
    return [String(label.value), quoted(label.name), label.samples ? String(label.samples) : "", ...texts, String(found?.triangles ?? "")];
  });
  return [header, ...rows].map((row) => `${row.join(",")}\r\n`).join("");
}

function quoted(text: string): string {
  return /[",\r\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
}
