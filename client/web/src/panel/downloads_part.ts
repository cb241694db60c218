// What one exports: a link, a picture, a file.
import type { MeshFormat } from "../workers/worker_messages";
import { h } from "../shared/elements";

export interface DownloadsEvents {
  copyLink: () => void;
  copyEmbedding: () => void;
  turntable: (form: "video" | "pictures") => void;
  times: (form: "video" | "pictures") => void;
  screenshot: () => void;
  download: (format: MeshFormat) => void;
}

export function downloadsPart(events: DownloadsEvents): DownloadsPart {
  const button = (word: string, tip: string, act: () => void) => {
    const element = h("button", { type: "button", class: "action", "data-tip": tip }, word);
    element.addEventListener("click", act);
    return element;
  };
  const ofTimes = [
    button("Times: video", "Every time of the series, as fast as it plays (WebM).", () => events.times("video")),
    button("Times: PNGs", "The same as pictures in a ZIP file.", () => events.times("pictures")),
  ];
  const element = h("div", { class: "actions" },
    button("Copy link", "The address of exactly this view, with all settings.", events.copyLink),
    button("Embed", "HTML that shows this view in another page; what it may ask of it is in the documentation.",
      events.copyEmbedding),
    button("Picture", "What you see, as PNG.", events.screenshot),
    button("GLB", "The shown surface for Blender, web and office programs.", () => events.download("glb")),
    button("PLY", "The shown surface for ParaView, MeshLab, CloudCompare.", () => events.download("ply")),
    button("STL", "The shown surface for 3D printing.", () => events.download("stl")),
    button("Turn: video", "The surface turned once around, as a film (WebM).", () => events.turntable("video")),
    button("Turn: PNGs", "The same as 120 pictures in a ZIP file.", () => events.turntable("pictures")),
    ...ofTimes);
  const showTimes = (hasTimes: boolean) => ofTimes.forEach((one) => (one.hidden = !hasTimes));
  showTimes(false);
  return { element, showTimes };
}

export interface DownloadsPart {
  element: HTMLElement;
  showTimes: (hasTimes: boolean) => void;
}
