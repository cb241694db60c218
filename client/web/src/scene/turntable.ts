// The surface turned once around: as a film, or as pictures in a ZIP file. Every picture is drawn as at
// rest; a film runs as fast as this machine draws them, but no faster than it should.
import { Zip, ZipPassThrough } from "three/examples/jsm/libs/fflate.module.js";

import { hasDrawn } from "./card";
import type { Stage } from "./stage";

const framesOfFilm = 240;
const framesOfPictures = 120;
const framesASecond = 30;

type Told = (share: number) => void; // 0 to 1: what is done.

export async function pictures(stage: Stage, background: string, told: Told): Promise<Blob> {
  const parts: Uint8Array[] = [];
  const zip = new Zip((error, bytes) => {
    if (error) throw error;
    parts.push(bytes);
  });
  await turn(stage, background, framesOfPictures, async (canvas, at) => {
    const png = await new Promise<Blob | null>((resolve) => canvas.toBlob(resolve, "image/png"));
    if (!png) throw new Error("the picture is too large for this browser.");
    const file = new ZipPassThrough(`turn_${String(at).padStart(3, "0")}.png`); // PNG does not get smaller.
    zip.add(file);
    file.push(new Uint8Array(await png.arrayBuffer()), true);
    told((at + 1) / framesOfPictures);
  });
  zip.end();
  return new Blob(parts as Uint8Array<ArrayBuffer>[], { type: "application/zip" });
}

export async function film(stage: Stage, background: string, told: Told): Promise<Blob> {
  if (typeof MediaRecorder === "undefined") throw new Error("this browser records none.");
  const screen = stage.picture(background);
  const context = screen.getContext("2d")!;
  const stream = screen.captureStream(framesASecond);
  const recorder = new MediaRecorder(stream, { mimeType: "video/webm", videoBitsPerSecond: 12_000_000 });
  const parts: Blob[] = [];
  recorder.ondataavailable = ({ data }) => parts.push(data);
  const ended = new Promise<void>((resolve) => (recorder.onstop = () => resolve()));
  recorder.start();
  const begin = performance.now();
  await turn(stage, background, framesOfFilm, async (canvas, at) => {
    context.drawImage(canvas, 0, 0);
    told((at + 1) / framesOfFilm);
    const due = begin + ((at + 1) * 1000) / framesASecond;
    await new Promise((resolve) => setTimeout(resolve, Math.max(0, due - performance.now())));
  });
  recorder.stop();
  await ended;
  for (const track of stream.getTracks()) track.stop();
  return new Blob(parts, { type: "video/webm" });
}

async function turn(
  stage: Stage,
  background: string,
  frames: number,
  use: (canvas: HTMLCanvasElement, at: number) => Promise<void>,
): Promise<void> {
  for (let at = 0; at < frames; ++at) {
    await use(stage.picture(background), at);
    stage.turn((2 * Math.PI) / frames, 0);
    await hasDrawn(stage.renderer, 2);
  }
}
