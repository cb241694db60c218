// Draws the scene as a picture file, opaque or transparent, with scale bar, axes, legends and measurements.
import { annotate, type Annotations } from "./scene/annotations";
import type { Stage } from "./scene/stage";
import type { DatasetInfo } from "./protocol/messages";
import { timeOf, timeText } from "./state/series";
import type { Settings } from "./state/settings";
import { surfacesOf } from "./state/surfaces";
import { suggestedIsovalue } from "./stream/request";
import type { PictureOptions } from "./viewer_options";

// "jet, temperature, isovalue 300.5 K, 0.25 s": the content of a picture in one line. Surfaces of other datasets are
// named with their isovalues: "cells, DAPI, isovalue 1245, cells.actin 900.5".
export function captionOf(settings: Settings, info: DatasetInfo): string {
  const { member } = info;
  const time = timeOf(info);
  const visible = surfacesOf(settings).filter((surface) => surface.visible);
  const others = member?.label ? [] : visible.filter(({ dataset }) => dataset).map(({ dataset, isovalue }) => `${dataset} ${isovalue}`);
  const values = visible.filter(({ dataset }) => !dataset).map(({ isovalue }) => isovalue ?? suggestedIsovalue(info)).join(", ");
  return [
    member?.series || info.name, member?.field ?? "",
    values && !member?.label ? `isovalue ${values}${info.valueUnit ? ` ${info.valueUnit}` : ""}` : "", ...others,
    time === null || !member ? "" : timeText(time, member.timeUnit),
  ].filter((word) => word !== "").join(", ");
}

// Returns the first text of a picture: its content, if enabled; frames of a video always have their time.
export function pictureHeading(settings: Settings, info: DatasetInfo | null, isVideoFrame: boolean): string[] {
  if (info && settings.axes) return [captionOf(settings, info)];
  const time = info && timeOf(info);
  return isVideoFrame && info?.member && time !== null ? [timeText(time, info.member.timeUnit)] : [];
}

// `element` determines the colors.
export function drawPicture(
  stage: Stage, element: HTMLElement, annotations: Annotations, { enlargement = 1, width, isTransparent = false }: PictureOptions,
): HTMLCanvasElement {
  const { backgroundColor: own, color } = getComputedStyle(element);
  const isNone = own === "transparent" || own === "rgba(0, 0, 0, 0)";
  const paper = isNone ? getComputedStyle(document.body).backgroundColor : own;
  const shownWidth = Math.max(1, stage.renderer.domElement.clientWidth);
  const canvas = stage.picture(isTransparent ? null : paper, width ? stage.enlargementTo(width) : enlargement);
  annotate(canvas.getContext("2d")!, annotations, canvas.width / shownWidth, color, paper);
  return canvas;
}
