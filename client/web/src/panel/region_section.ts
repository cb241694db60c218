// A region with another error: a box or a ball with handles in the scene.
import type { DatasetInfo } from "../protocol/messages";
import { h } from "../shared/elements";
import { counted } from "../shared/quantities";
import type { Region } from "../state/settings";
import { type Vec3, worldBox } from "../stream/dataset";
import { choice, slider } from "./inputs";
import { type Change, errorScale, type PanelSection } from "./panel_section";

export function regionPart(change: Change): PanelSection {
  let info: DatasetInfo | null = null;
  let region: Region | null = null;
  const regionOf = (kind: "none" | Region["kind"]) => (kind === "none" || !info ? null : regionInTheMiddle(kind, info, region?.error ?? 0));
  const shapeTip = "A region with its own allowed error. Drag its handles in the picture.";
  const shape = choice("Region", shapeTip, { none: "None", box: "Box", ball: "Ball" }, (kind) => change({ region: regionOf(kind) }));
  const text = (value: number) => (value === 0 ? "none: full resolution" : counted(value, "voxel"));
  const error = slider("Error inside", "The error allowed in the region.", { ...errorScale, text }, (value, isDragging) => {
    if (region) change({ region: { ...region, error: value } }, isDragging);
  });
  const hint = h("p", { class: "hint" }, "Allow a larger error above to see the difference.");
  return {
    elements: [shape.element, error.element, hint],
    show: ({ settings, info: shown }) => {
      info = shown;
      region = settings.region;
      shape.show(region?.kind ?? "none");
      error.element.hidden = !region;
      if (region) error.show(region.error);
      hint.hidden = !region || settings.error > region.error;
    },
  };
}

function regionInTheMiddle(kind: Region["kind"], info: DatasetInfo, error: number): Region {
  const { low, high } = worldBox(info);
  const center = low.map((value, axis) => (value + high[axis]) / 2) as Vec3;
  const size = low.map((value, axis) => high[axis] - value);
  if (kind === "ball") return { kind, center, radius: Math.min(...size) / 5, error };
  const corner = (sign: number) => center.map((value, axis) => value + (sign * size[axis]) / 6) as Vec3;
  return { kind, low: corner(-1), high: corner(1), error };
}
