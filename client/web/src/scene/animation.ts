// Renders a sequence of pictures as a video or a ZIP file: a turn around the surface, or the times of a series. Every
// picture has full quality and annotations.
import { Zip, ZipPassThrough } from "three/examples/jsm/libs/fflate.module.js";

import { gpuFinished } from "./gpu_fence";
import { pngOf } from "./png";
import type { Stage } from "./stage";
import { type Recording, startVideo, type Video } from "./video";

export interface Animation {
  name: string; // File name prefix of the pictures.
  frames: number;
  framesPerSecond: number;
  // Prepares picture `at` completely; called for every picture and once after the last. Rejects on failure.
  show: (at: number) => Promise<void>;
}

// Draws the current picture.
type Draw = () => HTMLCanvasElement;

type ProgressCallback = (share: number) => void; // 0 to 1.

// Begins and ends at the current view.
export function turntable(stage: Stage, form: "video" | "pictures"): Animation {
  const frames = form === "video" ? 240 : 120;
  let turned = 0;
  const show = async (at: number) => {
    stage.rotate((2 * Math.PI * (at - turned)) / frames, 0);
    turned = at;
  };
  return { name: "turn", frames, framesPerSecond: 30, show };
}

export async function recordPictures(stage: Stage, animation: Animation, draw: Draw, report: ProgressCallback): Promise<Recording> {
  const parts: Uint8Array[] = [];
  const zip = new Zip((error, bytes) => {
    if (error) throw error;
    parts.push(bytes);
  });
  await run(stage, animation, draw, async (canvas, at) => {
    const png = await pngOf(canvas);
    const file = new ZipPassThrough(`${animation.name}_${String(at).padStart(4, "0")}.png`); // PNG is already compressed.
    zip.add(file);
    file.push(new Uint8Array(await png.arrayBuffer()), true);
    report((at + 1) / animation.frames);
  });
  zip.end();
  return { file: new Blob(parts as Uint8Array<ArrayBuffer>[], { type: "application/zip" }), ending: "zip" };
}

export async function recordVideo(stage: Stage, animation: Animation, draw: Draw, report: ProgressCallback): Promise<Recording> {
  let video: Video | null = null;
  try {
    await run(stage, animation, draw, async (canvas, at) => {
      video ??= await startVideo(canvas.width, canvas.height, animation.framesPerSecond);
      await video.add(canvas);
      report((at + 1) / animation.frames);
    });
    return await video!.end();
  } catch (error) {
    await (video as Video | null)?.cancel();
    throw error;
  }
}

async function run(stage: Stage, { frames, show }: Animation, draw: Draw, use: (canvas: HTMLCanvasElement, at: number) => Promise<void>): Promise<void> {
  for (let at = 0; at < frames; ++at) {
    await show(at);
    await new Promise(requestAnimationFrame); // The overlays follow the scene.
    await gpuFinished(stage.renderer, 2);
    await use(draw(), at);
  }
  await show(frames);
}
