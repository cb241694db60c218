// How long the viewer's volume and a page without a server take in Chromium without a graphics card, at 1280 x 720.
//
//   node tests/bench/viewer_figures.mjs PROGRAM VIEWER_FOLDER SCRATCH_FOLDER VOLUME.nrrd [RUNS]
//
// VOLUME: a CT as NRRD, 16 bits, raw or gzip, such as the Visible Female's head. Prepares it and its first 134 slices, unless the scratch folder has
// them, and prints the median of RUNS (3) and all of them:
//
//   volume  coarse, full   seconds from switching it on until the coarse and the complete volume are drawn, 512 x 512 x 134
//           drag           milliseconds of a frame while it is rotated
//   page    preview, exact seconds from the address, and from the request, until a preview and the exact surface at 300.5 are shown; on
//                          loopback, and with 100 Mbit/s
//
// and the processor time of each by process. Run nothing else on the machine.
import { execFileSync } from "node:child_process";
import { existsSync, mkdirSync, openSync, readdirSync, readFileSync, readSync, statSync, writeFileSync } from "node:fs";
import { createServer } from "node:http";
import { createRequire } from "node:module";
import path from "node:path";
import { gunzipSync } from "node:zlib";

import { Server } from "../client/web/viewer_host.mjs";

const [program, viewer, scratch, source, runs = "3"] = process.argv.slice(2);
const installed = createRequire(new URL("../../client/web/package.json", import.meta.url));
const { chromium } = installed("playwright-core");
const layers = 134;
const folders = { volume: path.join(scratch, "volume"), whole: path.join(scratch, "whole"), page: path.join(scratch, "page") };
prepare();
await repeated("volume", measureVolume);
await repeated("page, loopback", () => measurePage(Infinity));
await repeated("page, 100 Mbit/s", () => measurePage(100e6 / 8));
process.exit();

// ----

function prepare() {
  if (existsSync(path.join(folders.page, "index.html"))) return;
  mkdirSync(folders.volume, { recursive: true });
  mkdirSync(folders.whole, { recursive: true });
  const bytes = readFileSync(source);
  const end = bytes.indexOf("\n\n") + 2;
  const header = bytes.subarray(0, end).toString("latin1");
  const data = /encoding: *(gz|gzip)/.test(header) ? gunzipSync(bytes.subarray(end)) : bytes.subarray(end);
  const [width, height] = /sizes: *(.*)/.exec(header)[1].split(" ").map(Number);
  const part = header.replace(/sizes: .*/, `sizes: ${width} ${height} ${layers}`).replace(/encoding: .*/, "encoding: raw");
  const file = path.join(scratch, "part.nrrd");
  writeFileSync(file, Buffer.concat([Buffer.from(part, "latin1"), data.subarray(0, 2 * width * height * layers)]));
  const words = (from, to) => ["prepare", from, "--name", "ct", "-o", path.join(to, "ct.mtd"), "--quiet"];
  execFileSync(program, words(file, folders.volume), { stdio: "inherit" });
  execFileSync(program, words(source, folders.whole), { stdio: "inherit" });
  execFileSync(program, ["export", path.join(folders.whole, "ct.mtd"), "--page", folders.page, "--quiet"], { stdio: "inherit" });
}

async function repeated(name, measure) {
  const all = [];
  for (let i = 0; i < Number(runs); ++i) all.push(await measure());
  console.log(`${name}${readFileSync("/proc/loadavg", "utf8").split(" ")[0] > 3 ? "  (the machine is busy)" : ""}`);
  for (const key of Object.keys(all[0])) {
    const values = all.map((one) => one[key]).sort((a, b) => a - b);
    const text = (value) => value.toFixed(value < 10 ? 2 : 0);
    console.log(`  ${key.padEnd(34)} ${text(values[Math.floor(values.length / 2)]).padStart(7)}   ${values.map(text).join(" ")}`);
  }
}

async function measureVolume() {
  const server = new Server(program, folders.volume, viewer);
  await server.start();
  const browser = await launched();
  try {
    const page = await opened(browser);
    await page.goto(`${server.page}#dataset=ct&visible=false&follow_view=false`);
    await page.waitForSelector(".dataset");
    await page.waitForTimeout(1500);
    const times = processorTimes(server.process.pid);
    const began = await page.evaluate(() => {
      location.hash += "&volume=on";
      return performance.now();
    });
    const coarse = await drawn(page, () => /samples? along each axis|All samples/.test(document.querySelector(".volume-detail").textContent));
    const full = await drawn(page, () => /All samples/.test(document.querySelector(".volume-detail").textContent));
    const spent = since(times, server.process.pid);
    await page.waitForTimeout(8000); // The frame at rest.
    const { frame, frames, drag } = await dragged(page);
    return { "coarse, s": (coarse - began) / 1000, "full, s": (full - began) / 1000, ...labelled("  processor until full, s:", spent, 1), "drag, ms a frame": frame,
             ...labelled("  processor a frame, ms:", drag, 1000 / frames) };
  } finally {
    await browser.close();
    await server.stop();
  }
}

async function measurePage(bytesPerSecond) {
  const { address, server } = await webServer(folders.page, bytesPerSecond);
  const browser = await launched();
  try {
    const page = await opened(browser);
    const times = processorTimes(0);
    await page.goto(`${address}#dataset=ct&isovalue=300.5&follow_view=false`);
    const shown = (isIt) => page.waitForFunction(isIt, null, { polling: "raf" }).then(() => page.evaluate(() => performance.now()));
    const preview = await shown(() => document.querySelector(".fact.triangles b")?.textContent);
    const exact = await shown(() => document.querySelector(".state b")?.textContent === "Complete");
    const spent = since(times, 0);
    const ofRequest = await page.evaluate(() => [...document.querySelectorAll(".came .fact")].map(({ textContent }) => parseFloat(textContent) / (/ms/.test(textContent) ? 1000 : 1)));
    return { "preview, s": preview / 1000, "exact, s": exact / 1000, "  since the request, first tile, s": ofRequest.at(-2), "  since the request, exact, s": ofRequest.at(-1),
             ...labelled("  processor, s:", spent, 1), "read, MB": server.sent / 1e6, "file, MB": statSync(path.join(folders.whole, "ct.mtd")).size / 1e6 };
  } finally {
    await browser.close();
    server.close();
  }
}

function launched() {
  return chromium.launch({
    executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium",
    args: ["--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"],
  });
}

async function opened(browser) {
  const page = await browser.newPage({ viewport: { width: 1280, height: 720 } });
  page.setDefaultTimeout(180_000);
  return page;
}

// Returns performance.now() in the page when the GPU has drawn the frame after the one in which `isShown()` became true.
async function drawn(page, isShown) {
  return page.evaluate(async (words) => {
    const isThere = new Function(`return (${words})()`);
    const next = () => new Promise((resolve) => requestAnimationFrame(resolve));
    while (!isThere()) await next();
    await next();
    const gl = document.querySelector(".stage canvas").getContext("webgl2");
    const fence = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
    gl.flush();
    while (gl.clientWaitSync(fence, 0, 0) === gl.TIMEOUT_EXPIRED) await new Promise((resolve) => setTimeout(resolve));
    return performance.now();
  }, isShown.toString());
}

// Rotates for three seconds; the browser draws the next frame when the GPU has room for it.
async function dragged(page) {
  const box = await page.locator(".stage canvas").boundingBox();
  const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
  await page.mouse.move(x, y);
  await page.mouse.down();
  for (let i = 0; i < 30; ++i) await page.mouse.move(x + i, y); // Learns how long a frame takes.
  const times = processorTimes(0);
  const counting = page.evaluate(async () => {
    const began = performance.now();
    let frames = 0;
    for (; performance.now() - began < 3000; ++frames) await new Promise((resolve) => requestAnimationFrame(resolve));
    return { frames, frame: (performance.now() - began) / frames };
  });
  let isOver = false;
  void counting.then(() => (isOver = true));
  for (let i = 0; !isOver; ++i) await page.mouse.move(x + 30 + (i % 200), y + (i % 50));
  const found = await counting;
  const drag = since(times, 0);
  await page.mouse.up();
  return { ...found, drag };
}

// Processor seconds by kind: the page's thread and process, the GPU process, other processes of the browser, the server.
function processorTimes(server) {
  const times = {};
  const add = (kind, stat) => {
    const [user, system] = stat.split(") ").at(-1).split(" ").slice(11, 13).map(Number);
    times[kind] = (times[kind] ?? 0) + (user + system) / 100;
  };
  for (const pid of readdirSync("/proc").filter((name) => /^\d+$/.test(name))) {
    try {
      const words = readFileSync(`/proc/${pid}/cmdline`, "utf8");
      if (Number(pid) === server) add("server", readFileSync(`/proc/${pid}/stat`, "utf8"));
      if (!/chromium/.test(words) || !isOurs(pid)) continue;
      const kind = /--type=([\w-]+)/.exec(words)?.[1] ?? "browser";
      add({ renderer: "page and workers", "gpu-process": "GPU process" }[kind] ?? "browser", readFileSync(`/proc/${pid}/stat`, "utf8"));
      if (kind === "renderer") add("page alone", readFileSync(`/proc/${pid}/task/${pid}/stat`, "utf8"));
    } catch {} // It has ended.
  }
  return times;
}

function isOurs(pid) {
  for (let at = Number(pid); at > 1; at = Number(readFileSync(`/proc/${at}/stat`, "utf8").split(") ").at(-1).split(" ")[1])) if (at === process.pid) return true;
  return false;
}

function since(before, server) {
  return Object.fromEntries(Object.entries(processorTimes(server)).map(([kind, now]) => [kind, now - (before[kind] ?? 0)]));
}

function labelled(label, times, factor) {
  return Object.fromEntries(["server", "page alone", "page and workers", "GPU process", "browser"].filter((kind) => kind in times)
    .map((kind) => [`${label} ${kind}`, factor * times[kind]]));
}

// A web server with ranges, all of whose replies share a rate.
async function webServer(folder, bytesPerSecond) {
  const types = { ".html": "text/html", ".js": "text/javascript", ".css": "text/css", ".wasm": "application/wasm", ".svg": "image/svg+xml", ".json": "application/json" };
  let free = 0; // When the link is free, in milliseconds.
  const server = createServer(async ({ url, headers }, reply) => {
    const name = decodeURIComponent(new URL(url, "http://localhost").pathname);
    const file = path.join(folder, name.endsWith("/") ? `${name}index.html` : name);
    if (!existsSync(file)) return reply.writeHead(404).end();
    const { size } = statSync(file);
    const range = /^bytes=(\d+)-(\d+)$/.exec(headers.range ?? "");
    const [first, end] = range ? [Number(range[1]), Math.min(size, Number(range[2]) + 1)] : [0, size];
    const bytes = Buffer.alloc(end - first);
    readSync(openSync(file, "r"), bytes, 0, bytes.length, first);
    const place = range ? { "Content-Range": `bytes ${first}-${end - 1}/${size}` } : {};
    reply.writeHead(range ? 206 : 200, { "Content-Type": types[path.extname(file)] ?? "application/octet-stream", "Content-Length": bytes.length, ETag: '"1"', ...place });
    for (let at = 0; at < bytes.length; at += 16384) {
      const piece = bytes.subarray(at, at + 16384);
      server.sent += path.extname(file) === ".mtd" ? piece.length : 0;
      free = Math.max(free, performance.now()) + (1000 * piece.length) / bytesPerSecond;
      if (free - performance.now() > 1) await new Promise((resolve) => setTimeout(resolve, free - performance.now()));
      reply.write(piece);
    }
    reply.end();
  });
  server.sent = 0;
  await new Promise((resolve) => server.listen(0, "127.0.0.1", resolve));
  return { server, address: `http://127.0.0.1:${server.address().port}/` };
}
