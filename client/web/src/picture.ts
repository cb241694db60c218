// What is shown as a picture file: on the page's background or on none, with scale bar, axes, legends and what is measured.
import { annotate, type Annotations } from "./scene/annotations";
import type { Stage } from "./scene/stage";
import type { PictureOptions } from "./viewer_options";

// `element`: whose colors the picture has. PNG.
export function pictureOf(
  stage: Stage, element: HTMLElement, annotations: Annotations, { enlargement = 1, width, isTransparent = false }: PictureOptions,
): Promise<Blob> {
  const { backgroundColor: own, color } = getComputedStyle(element);
  const isNone = own === "transparent" || own === "rgba(0, 0, 0, 0)";
  const paper = isNone ? getComputedStyle(document.body).backgroundColor : own;
  const shownWidth = Math.max(1, stage.renderer.domElement.clientWidth);
  const canvas = stage.picture(isTransparent ? null : paper, width ? stage.enlargementTo(width) : enlargement);
  annotate(canvas.getContext("2d")!, annotations, canvas.width / shownWidth, color, paper);
  return new Promise((resolve) => canvas.toBlob((blob) => resolve(blob!), "image/png"));
}
