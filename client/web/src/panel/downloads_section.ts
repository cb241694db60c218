// Exports: a link, pictures, files.
import type { MeshFormat } from "../mesh/mesh_file";
import { button, h } from "../shared/elements";
import { grouped, inTriangleRange } from "../shared/quantities";
import type { SurfaceSize } from "../state/progress";
import { type Choices, choice, labeled, toggle } from "./inputs";
import { numberInput } from "./number_input";

const maxPictureWidth = 16384; // Width.

export interface DownloadsEvents {
  copyLink: () => void;
  copyEmbedding: () => void;
  turntable: (form: "video" | "pictures") => void;
  times: (form: "video" | "pictures") => void;
  screenshot: (options: { enlargement: number; width?: number; isTransparent: boolean }) => void;
  download: (format: MeshFormat) => void;
}

export function downloadsPart(events: DownloadsEvents): DownloadsPart {
  const action = (word: string, tip: string, act: () => void) => button(word, act, { class: "action", "data-tip": tip });
  const ofTimes = [
    action("Times: video", "All times of the series, at the playback speed (MP4 or WebM).", () => events.times("video")),
    action("Times: PNGs", "The same as pictures in a ZIP file.", () => events.times("pictures")),
  ];
  const picture: Parameters<DownloadsEvents["screenshot"]>[0] = { enlargement: 1, isTransparent: false };
  const sizeTip = "Size of saved pictures: as on the screen, or larger for print.";
  const size = choice("Picture size", sizeTip, { 1: "1 ×", 2: "2 ×", 4: "4 ×" } as Choices<string>, (value) => {
    picture.enlargement = Number(value);
    picture.width = undefined;
    width.show(null);
    size.show(value);
  });
  size.show("1");
  const width = numberInput(
    "Width of the picture, in pixels",
    (pixels) => {
      picture.width = Math.min(maxPictureWidth, Math.max(16, Math.round(pixels)));
      width.show(picture.width);
    },
    () => (picture.width = undefined),
  );
  width.element.setAttribute("placeholder", "any");
  const widthRow = labeled("Width in pixels", "Width of saved pictures in pixels, within the limits of the graphics card.", width.element);
  const transparent = toggle("Transparent background", "Saves pictures without a background.", (isOn) => (picture.isTransparent = isOn));
  const actions = h(
    "div",
    { class: "actions" },
    action("Copy link", "The address of this view, with all settings.", events.copyLink),
    action("Embed", "HTML that shows this view in another page; see the documentation of embedding for its messages.", events.copyEmbedding),
    action("Picture", "The current view as PNG, with scale bar, axes, legend and measurement.", () => events.screenshot(picture)),
    action("GLB", "All visible surfaces, simplified if enabled, for Blender, web and office programs.", () => events.download("glb")),
    action("PLY", "The first surface, for ParaView, MeshLab, CloudCompare.", () => events.download("ply")),
    action("STL", "The first surface, for 3D printing.", () => events.download("stl")),
    action("Turn: video", "One full turn of the surface as a video (MP4 or WebM).", () => events.turntable("video")),
    action("Turn: PNGs", "The same as 120 pictures in a ZIP file.", () => events.turntable("pictures")),
    ...ofTimes,
  );
  const showTimes = (hasTimes: boolean) => ofTimes.forEach((one) => (one.hidden = !hasTimes));
  showTimes(false);
  return { elements: [actions, size.element, widthRow, transparent.element], showTimes };
}

export interface SavedSurface {
  triangles: number;
  isOfSamples: boolean; // Extracted here from sample shells and not simplified.
  isOneOfSeveral: boolean;
  expected: SurfaceSize | null; // The estimate for the request; null: unknown.
}

// Describes the triangles of a mesh file.
export function savedFileText({ triangles, isOfSamples, isOneOfSeveral, expected }: SavedSurface): string {
  const saved = `Saved ${grouped(triangles)} triangles${isOneOfSeveral ? ", those of the first surface" : ""}`;
  if (!isOfSamples) return `${saved}.`;
  const isLarger = expected !== null && expected.triangles < triangles;
  const simplified = isLarger ? `; "multitetra-client fetch" writes ${inTriangleRange(expected.triangles, expected.budget)} for the same error` : "";
  return `${saved}, as shown: generated in this browser from samples and not simplified${simplified}.`;
}

export interface DownloadsPart {
  elements: HTMLElement[];
  showTimes: (hasTimes: boolean) => void;
}
