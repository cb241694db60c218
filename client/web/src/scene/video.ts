// Videos made of pictures of one size.
import type { CanvasSource } from "mediabunny";

export interface Recording {
  file: Blob;
  ending: string; // The extension of its file name, such as "mp4".
}

export interface Video {
  add: (picture: HTMLCanvasElement) => Promise<void>;
  end: () => Promise<Recording>;
  cancel: () => Promise<void>;
}

const bitsPerSecond = 12_000_000;

// Rejects if this browser makes no videos. Pages from https or localhost encode each picture with the same duration,
// however long it took to render; others, where browsers have no encoder, record while the pictures are rendered.
export async function startVideo(width: number, height: number, framesPerSecond: number): Promise<Video> {
  const canvas = document.createElement("canvas");
  [canvas.width, canvas.height] = [width, height].map((side) => Math.max(2, side - (side % 2))); // H.264 requires even sides.
  const context = canvas.getContext("2d")!;
  const draw = (picture: HTMLCanvasElement) => context.drawImage(picture, 0, 0, canvas.width, canvas.height);
  return (await encoded(canvas, draw, framesPerSecond)) ?? recorded(canvas, draw, framesPerSecond);
}

type Draw = (picture: HTMLCanvasElement) => void;

// MP4, which presentations play, where the browser encodes H.264; otherwise WebM. Null: there is no encoder.
async function encoded(canvas: HTMLCanvasElement, draw: Draw, framesPerSecond: number): Promise<Video | null> {
  if (typeof VideoEncoder === "undefined") return null;
  const { BufferTarget, CanvasSource, getFirstEncodableVideoCodec, Mp4OutputFormat, Output, Quality, WebMOutputFormat } = await import("mediabunny");
  const quality = new Quality("very-high");
  const codec = await getFirstEncodableVideoCodec(["avc", "vp9", "vp8"], { width: canvas.width, height: canvas.height, quality });
  if (!codec) return null;
  const [format, ending] = codec === "avc" ? [new Mp4OutputFormat({ fastStart: "in-memory" }), "mp4"] : [new WebMOutputFormat(), "webm"];
  const target = new BufferTarget();
  const output = new Output({ format, target });
  const source: CanvasSource = new CanvasSource(canvas, { codec, quality });
  output.addVideoTrack(source, { frameRate: framesPerSecond });
  await output.start();
  let count = 0;
  return {
    add: async (picture) => {
      draw(picture);
      await source.add(count++ / framesPerSecond, 1 / framesPerSecond);
    },
    end: async () => {
      await output.finalize();
      return { file: new Blob([target.buffer!], { type: format.mimeType }), ending };
    },
    cancel: () => output.cancel(),
  };
}

function recorded(canvas: HTMLCanvasElement, draw: Draw, framesPerSecond: number): Video {
  if (typeof MediaRecorder === "undefined") throw new Error("this browser cannot record videos.");
  const stream = canvas.captureStream(30);
  const recorder = new MediaRecorder(stream, { mimeType: "video/webm", videoBitsPerSecond: bitsPerSecond });
  const parts: Blob[] = [];
  recorder.ondataavailable = ({ data }) => parts.push(data);
  const ended = new Promise<void>((resolve) => (recorder.onstop = () => resolve()));
  let due = 0;
  const stop = async () => {
    if (recorder.state !== "inactive") {
      recorder.stop();
      await ended;
    }
    for (const track of stream.getTracks()) track.stop();
  };
  return {
    add: async (picture) => {
      draw(picture);
      if (recorder.state === "inactive") {
        recorder.start();
        due = performance.now();
      }
      due += 1000 / framesPerSecond;
      await new Promise((resolve) => setTimeout(resolve, Math.max(0, due - performance.now())));
    },
    end: async () => {
      await stop();
      return { file: new Blob(parts, { type: "video/webm" }), ending: "webm" };
    },
    cancel: stop,
  };
}
