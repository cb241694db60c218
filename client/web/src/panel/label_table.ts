// Writes the visible labels as a table for spreadsheets, with the measures of their shown surfaces.
import type { MassProperties } from "../mesh/mass_properties";
import type { Label } from "../protocol/messages";
import { inDigits, withBound } from "../shared/quantities";

export interface MeasuredLabel {
  label: Label;
  found: MassProperties | null; // Null: not measured.
  bound: number | null; // The surface's error in world units; null: unknown.
}

// Returns CSV with a header. Unknown volumes and bounds are empty.
export function labelTable(labels: readonly MeasuredLabel[], lengthUnit: string): string {
  const unit = lengthUnit || "unit";
  const header = ["label", "name", `volume_${unit}3`, `volume_bound_${unit}3`, `area_about_${unit}2`, "triangles"];
  const rows = labels.map(({ label, found, bound }) => {
    const [volume, plusMinus = ""] = volumeOf(found, bound).split(" ± ");
    return [String(label.value), quoted(label.name), volume, plusMinus, found ? inDigits(found.area, 4) : "", found ? String(found.triangles) : ""];
  });
  return [header, ...rows].map((row) => `${row.join(",")}\r\n`).join("");
}

function volumeOf(found: MassProperties | null, bound: number | null): string {
  if (!found || found.volume === null) return "";
  return bound === null ? inDigits(found.volume, 4) : withBound(found.volume, bound * found.area);
}

function quoted(text: string): string {
  return /[",\r\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
}
