// Draws the scene, and the slices beside it, as a picture, opaque or transparent, with scale bar, axes, legends and
// measurements.

import type { DatasetInfo } from "../protocol/messages";
import type { SliceViews } from "../samples/slice_views";
import { type Annotations, annotate, type SurfaceKey } from "../scene/annotations";
import type { Stage } from "../scene/stage";
import { h } from "../shared/elements";
import { findByName, nameOfLabel, timeOf, timesOf, timeText } from "../state/series";
import type { Settings } from "../state/settings";
import { suggestedIsovalue } from "../stream/request";
import type { PictureOptions } from "./viewer_options";

const maxKeys = 12;

// "jet, temperature, isovalue 300.5 K, 0.25 s": the content of a picture in one line. Surfaces of other datasets are
// named with their isovalues, labels as a whole: "cells, DAPI, isovalue 1245, cells.actin 900.5, labels of nuclei".
export function captionOf(settings: Settings, info: DatasetInfo, list: readonly DatasetInfo[]): string {
  const { member } = info;
  const time = timeOf(info);
  const visible = settings.surfaces.filter((surface) => surface.visible);
  const others = member?.label
    ? []
    : visible
        .filter(({ dataset }) => dataset)
        .map(({ dataset, isovalue }) => {
          const beside = findByName(list, dataset!);
          return beside?.member?.label ? `labels of ${beside.member.series || beside.name}` : `${dataset} ${isovalue}`;
        });
  const values = visible
    .filter(({ dataset }) => !dataset)
    .map(({ isovalue }) => isovalue ?? suggestedIsovalue(info))
    .join(", ");
  return [
    member?.series || info.name,
    member?.field ?? "",
    values && !member?.label ? `isovalue ${values}${info.valueUnit ? ` ${info.valueUnit}` : ""}` : "",
    ...new Set(others),
    time === null || !member ? "" : timeText(time, member.timeUnit, timesOf(list, info)),
  ]
    .filter((word) => word !== "")
    .join(", ");
}

// Returns colors and names of the visible surfaces, if there are several; at most 12.
export function surfaceKeys(settings: Settings, info: DatasetInfo | null, list: readonly DatasetInfo[]): SurfaceKey[] {
  const visible = settings.surfaces.filter((surface) => surface.visible);
  if (!info || !settings.axes || settings.colorBy || visible.length < 2) return [];
  const keys = visible.slice(0, maxKeys).map(({ color, dataset, isovalue }) => {
    const of = dataset ? (findByName(list, dataset) ?? info) : info;
    const label = of.member?.label;
    const value = `${isovalue ?? suggestedIsovalue(of)}${of.valueUnit ? ` ${of.valueUnit}` : ""}`;
    return { color, text: label ? nameOfLabel(label, settings) : dataset ? `${dataset} ${value}` : value };
  });
  const others = visible.length - keys.length;
  return others > 0 ? [...keys, { color: "", text: `and ${others} more` }] : keys;
}

// Returns the first text of a picture: its content, if enabled; frames of a video always have their time.
export function pictureHeading(settings: Settings, info: DatasetInfo | null, list: readonly DatasetInfo[], isVideoFrame: boolean): string[] {
  if (info && settings.axes) return [captionOf(settings, info, list)];
  const time = info && timeOf(info);
  return isVideoFrame && info?.member && time !== null ? [timeText(time, info.member.timeUnit, timesOf(list, info))] : [];
}

// Draws the scene, and the slices beside it, if any. `element` contains both and determines the colors.
export function drawPicture(
  stage: Stage,
  slices: SliceViews | null,
  element: HTMLElement,
  annotations: Annotations,
  { enlargement = 1, width, isTransparent = false }: PictureOptions,
): HTMLCanvasElement {
  const { backgroundColor: own, color } = getComputedStyle(element);
  const isNone = own === "transparent" || own === "rgba(0, 0, 0, 0)";
  const paper = isNone ? getComputedStyle(document.body).backgroundColor : own;
  const whole = element.getBoundingClientRect();
  const shown = stage.renderer.domElement.getBoundingClientRect();
  const widthOfScene = width && slices ? (width * shown.width) / whole.width : width;
  const scene = stage.picture(isTransparent ? null : paper, widthOfScene ? stage.enlargementTo(widthOfScene) : enlargement);
  const ratio = scene.width / Math.max(1, shown.width);
  annotate(scene.getContext("2d")!, annotations, ratio, color, paper);
  if (!slices) return scene;
  const all = h("canvas");
  [all.width, all.height] = [width ?? Math.round(ratio * whole.width), Math.round(ratio * whole.height)];
  const context = all.getContext("2d")!;
  context.drawImage(scene, ratio * (shown.x - whole.x), ratio * (shown.y - whole.y));
  context.scale(ratio, ratio);
  slices.drawOn(context, whole);
  return all;
}
