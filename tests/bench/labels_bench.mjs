// How long the first surfaces of a thousand labels take: the server alone, over one WebSocket, and the viewer.
//
//   node --experimental-websocket tests/bench/labels_bench.mjs PROGRAM VIEWER_FOLDER SCRATCH_FOLDER [LABELS]
//
// Makes and prepares a segmentation of LABELS balls (1000) of about 20 samples across, unless the scratch folder has it: some
// minutes. Prints the seconds and the processor time of
//
//   alone      a stream for each label, one after another
//   together   one stream for all
//   viewer     from the beginning of the page until all are drawn in Chromium; a browser without a graphics card draws on the
//              processor, so also without the drawing itself
//
// Run nothing else on the machine.
import { execFileSync } from "node:child_process";
import { existsSync, mkdirSync, readFileSync } from "node:fs";
import { createRequire } from "node:module";
import path from "node:path";

import { writeNrrd } from "../client/web/made_volumes.mjs";
import { Server } from "../client/web/viewer_host.mjs";

const [program, viewer, scratch, labels = "1000"] = process.argv.slice(2);
const count = Number(labels);
const spacing = 4;
let lastRequest = 0;
const folder = path.join(scratch, `labels_${count}`);
if (!existsSync(folder)) prepare();
const server = new Server(program, folder, viewer, ["--max-requests-per-second", "0"]); // One address has all requests.
let socket;
await measure("alone", async (names) => {
  for (const name of names) await stream(previewOf([name]));
});
await measure("together", (names) => stream(previewOf(names)));
for (const isDrawn of [true, false]) await measureViewer(isDrawn);
process.exit();

// ----

function prepare() {
  const across = Math.ceil(Math.cbrt(count));
  const size = Math.ceil(25.6 * across);
  const samples = new Uint16Array(size ** 3);
  const pitch = size / across;
  for (let i = 0; i < samples.length; ++i) {
    const at = [i % size, Math.floor(i / size) % size, Math.floor(i / size ** 2)];
    const cell = at.map((v) => Math.floor(v / pitch));
    const label = cell[0] + across * (cell[1] + across * cell[2]) + 1;
    const radius = pitch * (0.3 + 0.1 * Math.abs(Math.sin(label)));
    if (label <= count && Math.hypot(...at.map((v, axis) => v - pitch * (cell[axis] + 0.5))) < radius) samples[i] = label;
  }
  mkdirSync(folder, { recursive: true });
  const file = path.join(scratch, `labels_${count}.nrrd`);
  writeNrrd(file, size, samples);
  execFileSync(program, ["prepare", file, "--label", "all", "--name", "cells", "-o", folder, "--quiet"], { stdio: "inherit" });
}

function processorSeconds() {
  const [user, system] = readFileSync(`/proc/${server.process.pid}/stat`, "utf8").split(") ")[1].split(" ").slice(11, 13);
  return (Number(user) + Number(system)) / 100;
}

async function measure(what, act) {
  await server.start(); // Its caches are empty.
  socket = await connect();
  const names = await list();
  const [begin, used] = [performance.now(), processorSeconds()];
  const bytes = await act(names);
  const seconds = ((performance.now() - begin) / 1000).toFixed(2);
  console.log(`${what}: ${seconds} s, ${(processorSeconds() - used).toFixed(2)} s of the server's processors${bytes ? `, ${bytes} bytes` : ""}`);
  lastRequest = 0;
  await server.stop();
}

// Protocol Buffers, as far as it is needed here.
function varint(value) {
  const bytes = [];
  for (; value > 127; value = Math.floor(value / 128)) bytes.push((value % 128) + 128);
  return [...bytes, value];
}
function number(field, value) {
  return [...varint(8 * field), ...varint(value)];
}
function bytesOf(field, bytes) {
  return [...varint(8 * field + 2), ...varint(bytes.length), ...bytes];
}
function words(field, text) {
  return bytesOf(field, [...Buffer.from(text)]);
}
function* fieldsOf(bytes) {
  let at = 0;
  const next = () => {
    let value = 0;
    for (let scale = 1; ; scale *= 128) {
      const byte = bytes[at++];
      value += scale * (byte & 127);
      if (byte < 128) return value;
    }
  };
  while (at < bytes.length) {
    const tag = next();
    const size = { 0: 0, 1: 8, 5: 4 }[tag & 7] ?? next();
    if ((tag & 7) === 0) next();
    yield [tag >> 3, bytes.subarray(at, (at += size))];
  }
}

// OpenStream for one preview each, in sample shells.
function previewOf([first, ...others]) {
  const isovalue = [...varint(8 + 1), ...new Uint8Array(new Float64Array([0.5]).buffer)];
  const preview = [...number(1, spacing), ...bytesOf(3, [...number(1, 3), ...number(2, 2)])];
  return bytesOf(3, [
    ...number(1, ++lastRequest), ...words(2, first), ...bytesOf(3, isovalue), ...number(4, 3), ...bytesOf(6, preview), ...number(10, 2),
    ...others.flatMap((name) => words(11, name)),
  ]);
}

function connect() {
  return new Promise((resolve, reject) => {
    const opened = new WebSocket(`${server.page.replace("http", "ws")}v1/stream`, "multitetra.v1");
    opened.binaryType = "arraybuffer";
    opened.onopen = () => opened.send(Uint8Array.from(bytesOf(1, [...number(1, 1), ...number(2, 1), ...bytesOf(3, [2, 1])])));
    opened.onmessage = () => resolve(opened);
    opened.onerror = reject;
  });
}

// Until the end of the stream: its bytes.
function stream(request) {
  return new Promise((resolve, reject) => {
    let bytes = 0;
    socket.onmessage = ({ data }) => {
      bytes += data.byteLength;
      const [[kind, content]] = fieldsOf(new Uint8Array(data));
      if (kind === 6) resolve(bytes);
      if (kind === 7) reject(new Error(Buffer.from(content).toString()));
    };
    socket.send(Uint8Array.from(request));
  });
}

function list() {
  return new Promise((resolve) => {
    socket.onmessage = ({ data }) => {
      const [[, content]] = fieldsOf(new Uint8Array(data));
      const infos = [...fieldsOf(content)].filter(([field]) => field === 2).map(([, info]) => [...fieldsOf(info)]);
      resolve(infos.map((info) => Buffer.from(info.find(([field]) => field === 1)[1]).toString()));
    };
    socket.send(Uint8Array.from(bytesOf(2, number(1, 1))));
  });
}

async function measureViewer(isDrawn) {
  const { chromium } = createRequire(new URL("../../client/web/package.json", import.meta.url))("playwright-core");
  await server.start();
  const browser = await chromium.launch({
    executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium",
    args: ["--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"],
  });
  const page = await browser.newPage({ viewport: { width: 900, height: 640 } });
  if (!isDrawn) {
    await page.addInitScript(() => {
      for (const name of ["drawElements", "drawArrays", "clear", "blitFramebuffer"]) WebGL2RenderingContext.prototype[name] = () => {};
    });
  }
  const devtools = await page.context().newCDPSession(page);
  await devtools.send("Performance.enable");
  const used = processorSeconds();
  await page.goto(`${server.page}#dataset=cells&labels=1-${count}&follow_view=false`);
  const end = await page.waitForFunction((all) => {
    const shown = Number(document.querySelector(".fact.triangles span")?.textContent.match(/of (\d+) surfaces/)?.[1] ?? 0);
    return shown >= all && performance.now();
  }, count, { polling: 50, timeout: 600_000 });
  const { metrics } = await devtools.send("Performance.getMetrics");
  const [busy, all] = ["ThreadTime", "ProcessTime"].map((one) => metrics.find(({ name }) => name === one).value.toFixed(2));
  console.log(`viewer${isDrawn ? "" : ", undrawn"}: ${((await end.jsonValue()) / 1000).toFixed(2)} s, main thread ${busy} s of processor time, page and its workers ${all} s, ` +
    `${(processorSeconds() - used).toFixed(2)} s of the server's processors`);
  await browser.close();
  await server.stop();
}
