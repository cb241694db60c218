// Shared by tests of the viewer in a real browser with a real server. A test file imports this, calls test() for each
// test and finish() at its end, and is run as
//
//   node FILE SERVER_PROGRAM VIEWER_FOLDER SCRATCH_FOLDER
//
// Exits with 77 and a warning if something is not installed and nothing was tested.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { existsSync, mkdirSync, rmSync } from "node:fs";
import { createRequire } from "node:module";
import path from "node:path";

import { Server } from "./viewer_host.mjs";

const [program, viewer, scratchFolder] = process.argv.slice(2);
const chromiumPath = process.env.CHROMIUM ?? "/usr/bin/chromium";
export const scratch = scratchFolder;
export const patience = Number(process.env.PATIENCE ?? 120_000); // Enough for a loaded machine that draws in software.

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
const hosts = new Set([new URL(server.page).host]); // Hosts that a page may query.
const others = [];
const browser = await chromium.launch({
  executablePath: chromiumPath,
  args: ["--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"],
});
const reader = await browser.newPage(); // Reads pictures.
let failures = 0;

// `device`: the simulated screen.
export async function test(name, act, device = {}) {
  if (process.env.ONLY && !new RegExp(process.env.ONLY).test(name)) return; // To run single tests.
  const page = await browser.newPage({ viewport: { width: 900, height: 640 }, ...device });
  page.setDefaultTimeout(patience);
  const failure = [];
  page.on("console", (message) => {
    // The browser reports failed connections while the server is away, also for the page's icon.
    const isAway = /WebSocket|ERR_CONNECTION_REFUSED/.test(message.text());
    const isExpected = (page.mayLoseItsConnection && isAway) || page.maySay?.test(message.text());
    if (message.type() === "error" && !isExpected) failure.push(message.text());
  });
  page.on("pageerror", (error) => failure.push(error.message));
  page.on("request", (request) => {
    const { host, protocol } = new URL(request.url());
    const isLocal = hosts.has(host) || protocol === "data:" || protocol === "blob:";
    if (!isLocal) failure.push(`It asks for ${request.url()}.`);
  });
  try {
    await act(page);
    assert.deepEqual(failure, [], "nothing is said on the console");
    console.log(`ok   ${name}`);
  } catch (error) {
    ++failures;
    console.log(`FAIL ${name}: ${error.stack}\n${failure.join("\n")}`);
    await page.screenshot({ path: path.join(scratch, `${name}.png`) }).catch(() => {});
  }
  await page.close();
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

// Adds a token of this name to `file` and returns it.
export function newToken(name, file) {
  return execFileSync(program, ["token", name, "--append", file], { encoding: "utf8" }).trim();
}

export async function finish() {
  await browser.close();
  for (const one of [server, ...others]) await one.stop();
  process.exit(failures > 0 ? 1 : 0);
}

// View-dependent detail is off unless the address enables it, so that surfaces depend only on the settings.
export async function open(page, hash, where = server) {
  await page.goto(where.page + (/follow_view/.test(hash) ? hash : `${hash || "#"}&follow_view=false`));
}

// Returns the focused element's name and first class.
export function atKeyboard(page) {
  return page.evaluate(() => {
    const { localName, classList } = document.activeElement;
    return [localName, ...[...classList].slice(0, 1)].join(".");
  });
}

// Waits for a notice with this text.
export function notice(page, words) {
  return page.waitForFunction((pattern) => {
    const element = document.querySelector(".notice");
    return !element.hidden && new RegExp(pattern).test(element.textContent);
  }, words.source);
}

// Waits for the final step; returns the text of status bar and certificate.
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

// Returns the share of the picture with a surface's color: light, and more red than blue.
export async function surfacePixels(page) {
  const box = await page.locator(".stage canvas").boundingBox();
  const png = (await page.screenshot({ clip: box, timeout: patience })).toString("base64");
  return reader.evaluate(async (data) => {
    const image = new Image();
    image.src = `data:image/png;base64,${data}`;
    await image.decode();
    const canvas = document.createElement("canvas");
    canvas.width = image.width;
    canvas.height = image.height;
    const context = canvas.getContext("2d");
    context.drawImage(image, 0, 0);
    const { data: rgba } = context.getImageData(0, 0, canvas.width, canvas.height);
    let count = 0;
    for (let i = 0; i < rgba.length; i += 4) {
      if (rgba[i] > 80 && rgba[i] > rgba[i + 2] + 15) ++count;
    }
    return { share: (4 * count) / rgba.length };
  }, png);
}

// Runs the server program to its end, silently; returns its output.
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
