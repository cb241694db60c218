// Common parts of the viewer's tests in a real browser, against a real server. A test file imports this, calls test()
// for each test and finish() at its end, and is run as
//
//   node FILE SERVER_PROGRAM VIEWER_FOLDER SCRATCH_FOLDER
//
// Exit code 77, with a warning, means that something is not installed and nothing was tested.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { existsSync, mkdirSync, readFileSync, rmSync } from "node:fs";
import { createRequire } from "node:module";
import path from "node:path";

import { Server } from "./viewer_host.mjs";

const [program, viewer, scratchFolder] = process.argv.slice(2);
const chromiumPath = process.env.CHROMIUM ?? "/usr/bin/chromium";
export const scratch = scratchFolder;
export const maxScenes = 6; // That the browser draws at a time; 16 otherwise.
export const patience = Number(process.env.PATIENCE ?? 120_000); // Enough for a busy machine without a graphics card.

function skip(what) {
  console.log(`!! ${what}: the viewer is NOT TESTED in a browser.`);
  process.exit(77);
}
if (!existsSync(chromiumPath)) skip("Chromium is not installed");
if (!existsSync(path.join(viewer, "index.html"))) skip("The viewer was not built");
const installed = createRequire(new URL("../../../client/web/package.json", import.meta.url));
let chromium;
try {
  ({ chromium } = installed("playwright-core"));
} catch {
  skip("playwright-core is not installed");
}

prepareDatasets();
export const server = new Server(program, path.join(scratch, "datasets"), viewer);
await server.start();
const hosts = new Set([new URL(server.page).host]); // Hosts that pages may connect to.
const others = [];
const browser = await chromium.launch({
  executablePath: chromiumPath,
  args: ["--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", `--max-active-webgl-contexts=${maxScenes}`],
});
const reader = await browser.newPage(); // Decodes screenshots.
let failures = 0;

const pages = new Map(); // By what they emulate. A page that is used again costs half the time of a new one.

// `device`: the emulated screen; by default one without animations, each frame of which costs without a graphics card.
// Tests get an empty page that others may have used before; `isFresh`: one that nobody uses after it either.
export async function test(name, act, { isFresh = false, ...emulated } = {}) {
  if (process.env.ONLY && !new RegExp(process.env.ONLY).test(name)) return; // ONLY selects tests during development.
  const device = { viewport: { width: 900, height: 640 }, reducedMotion: "reduce", ...emulated };
  const key = JSON.stringify(device);
  const page = (!isFresh && pages.get(key)) || (await newPage(device));
  if (!isFresh) pages.delete(key);
  const began = Date.now();
  const { failure } = Object.assign(page, { failure: [], mayLoseItsConnection: false, maySay: null });
  try {
    await act(page);
    assert.deepEqual(failure, [], "nothing is said on the console");
    if (!isFresh) await forget(page, device);
    assert.deepEqual(failure, [], "nothing is said while the page is left");
    console.log(`ok   ${name} (${((Date.now() - began) / 1000).toFixed(1)} s)`);
  } catch (error) {
    ++failures;
    console.log(`FAIL ${name}: ${error.stack}\n${failure.join("\n")}`);
    await page.screenshot({ path: path.join(scratch, `${name}.png`) }).catch(() => {});
    return page.close();
  }
  if (isFresh) return page.close();
  pages.set(key, page);
}

async function newPage(device) {
  const page = await browser.newPage(device);
  page.setDefaultTimeout(patience);
  page.lastNavigation = 0;
  page.mayBeAt = (host) => hosts.add(host); // A page of another site that the test itself serves.
  page.on("console", (message) => {
    // The browser logs failed requests, including the page's icon, while the server is down.
    const isAway = /WebSocket|ERR_CONNECTION_(REFUSED|RESET)/.test(message.text());
    // Requests of a page that is being left fail, that for its icon as one of the empty page.
    const isOfALeftPage = /net::ERR_FAILED$|icon\.svg' from origin 'null'/.test(message.text());
    const isCancelled = isOfALeftPage && Date.now() - page.lastNavigation < 2000;
    const isExpected = isCancelled || (page.mayLoseItsConnection && isAway) || page.maySay?.test(message.text());
    if (message.type() === "error" && !isExpected) page.failure.push(message.text());
  });
  page.on("pageerror", (error) => page.failure.push(error.message));
  page.on("request", (request) => {
    if (request.isNavigationRequest()) page.lastNavigation = Date.now();
    const { host, protocol } = new URL(request.url());
    const isLocal = hosts.has(host) || protocol === "data:" || protocol === "blob:" || protocol === "about:";
    if (!isLocal) page.failure.push(`It requests ${request.url()}.`);
  });
  return page;
}

// Leaves nothing of a test in its page.
async function forget(page, { viewport }) {
  await page.evaluate(() => [localStorage, sessionStorage].forEach((one) => one.clear()));
  page.lastNavigation = Date.now();
  await page.goto("about:blank");
  page.removeAllListeners("websocket");
  await page.unrouteAll();
  await page.mouse.move(0, 0);
  await page.setViewportSize(viewport);
  const devtools = await page.context().newCDPSession(page);
  for (const host of hosts) await devtools.send("Storage.clearDataForOrigin", { origin: `http://${host}`, storageTypes: "all" });
  await devtools.detach();
}

// Starts another server with the same datasets.
export function serve(...options) {
  return serveFolder(path.join(scratch, "datasets"), ...options);
}

export async function serveFolder(folder, ...options) {
  const other = new Server(program, folder, viewer, options);
  await other.start();
  hosts.add(new URL(other.page).host);
  others.push(other);
  return other;
}

// Creates a token with this name, adds it to `file` and returns it.
export function newToken(name, file) {
  return execFileSync(program, ["token", name, "--append", file], { encoding: "utf8" }).trim();
}

export async function finish() {
  await browser.close();
  for (const one of [server, ...others]) await one.stop();
  process.exit(failures > 0 ? 1 : 0);
}

// Turns off, unless the address sets it, view-dependent detail, so that only the settings determine the surface, and
// ambient occlusion, which costs more than all else without a graphics card.
export async function open(page, hash, where = server) {
  const unless = (name) => (hash.includes(name) ? "" : `&${name}=false`);
  await page.goto(`${where.page}${hash || "#"}${unless("follow_view")}${unless("occlusion")}`);
}

// The tag name and first class of the focused element.
export function atKeyboard(page) {
  return page.evaluate(() => {
    const { localName, classList } = document.activeElement;
    return [localName, ...[...classList].slice(0, 1)].join(".");
  });
}

// Waits until the notice matches `words`.
export function notice(page, words) {
  return page.waitForFunction((pattern) => {
    const element = document.querySelector(".notice");
    return element && !element.hidden && new RegExp(pattern).test(element.textContent);
  }, words.source);
}

// Waits for the final step; returns the facts in the status bar and the certificate.
export async function complete(page, isIt = () => true) {
  const until = Date.now() + patience;
  while (Date.now() < until) {
    const shown = await page.evaluate(() => {
      const text = (selector) => document.querySelector(selector)?.textContent ?? "";
      return {
        state: text(".state b"),
        triangles: Number(text(".fact.triangles b").replace(/\D/g, "")),
        digest: text(".certificate").match(/[0-9a-f]{32}/)?.[0],
      };
    });
    if (shown.state === "Complete" && shown.digest && isIt(shown)) return shown;
    await page.waitForTimeout(100);
  }
  throw new Error(`The surface did not become complete in ${patience / 1000} s.`);
}

// The fraction of the picture with the color of a surface: bright, with more red than blue.
export async function surfacePixels(page) {
  const [share] = await surfaceShares(page, [await page.locator(".stage canvas").boundingBox()]);
  return { share };
}

// The same of several parts of one screenshot.
export async function surfaceShares(page, boxes) {
  const png = (await page.screenshot({ timeout: patience })).toString("base64");
  const { width } = page.viewportSize();
  return reader.evaluate(async ([data, parts, pageWidth]) => {
    const image = new Image();
    image.src = `data:image/png;base64,${data}`;
    await image.decode();
    const canvas = document.createElement("canvas");
    canvas.width = image.width;
    canvas.height = image.height;
    const context = canvas.getContext("2d", { willReadFrequently: true });
    context.drawImage(image, 0, 0);
    const ratio = image.width / pageWidth;
    return parts.map((box) => {
      const [x, y, w, h] = [box.x, box.y, box.width, box.height].map((one) => Math.round(one * ratio));
      const { data: rgba } = context.getImageData(x, y, w, h);
      let count = 0;
      for (let i = 0; i < rgba.length; i += 4) {
        if (rgba[i] > 80 && rgba[i] > rgba[i + 2] + 15) ++count;
      }
      return (4 * count) / rgba.length;
    });
  }, [png, boxes, width]);
}

// The pixels of the picture that the page saves: red, green, blue, 255.
export async function savedPicture(page) {
  if (await page.locator(".actions").isHidden()) await page.click('summary:has-text("Export")');
  const coming = page.waitForEvent("download");
  await page.click('.action:has-text("Picture")');
  const png = readFileSync(await (await coming).path()).toString("base64");
  const { width, height, bytes } = await reader.evaluate(async (data) => {
    const bitmap = await createImageBitmap(await (await fetch(`data:image/png;base64,${data}`)).blob());
    const canvas = new OffscreenCanvas(bitmap.width, bitmap.height);
    const context = canvas.getContext("2d");
    context.drawImage(bitmap, 0, 0);
    const { data: rgba } = context.getImageData(0, 0, canvas.width, canvas.height);
    let bytes = "";
    for (let i = 0; i < rgba.length; i += 8192) bytes += String.fromCharCode(...rgba.subarray(i, i + 8192));
    return { width: canvas.width, height: canvas.height, bytes: btoa(bytes) };
  }, png);
  return { width, height, rgba: Buffer.from(bytes, "base64") };
}

// Runs the server program silently and returns its output.
export function run(...words) {
  return execFileSync(program, [...words, "--quiet"], { encoding: "utf8", stdio: ["ignore", "pipe", "ignore"] });
}

function prepareDatasets() {
  const folder = path.join(scratch, "datasets");
  rmSync(folder, { recursive: true, force: true });
  mkdirSync(folder, { recursive: true });
  for (const [kind, size] of [["head", "65"], ["gyroid", "33"]]) {
    const volume = path.join(scratch, `${kind}.nrrd`);
    run("generate", kind, "--size", size, "-o", volume);
    run("prepare", volume, "--name", kind, "-o", path.join(folder, `${kind}.mtd`));
  }
}
