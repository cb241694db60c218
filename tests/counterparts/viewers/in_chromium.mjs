// Runs Chromium with the pages of this folder. Environment: CHROMIUM, the program; PAGES_PORT, the port that serves the
// pages; CERTIFICATE_HASH, the hash of the accepted key; PICTURES, a folder for screenshots.
import { readFile } from "node:fs/promises";
import { createServer } from "node:http";
import path from "node:path";
import { fileURLToPath } from "node:url";

import { chromium } from "playwright-core";

const here = path.dirname(fileURLToPath(import.meta.url));
const folders = {
  cesium: "node_modules/cesium/Build/Cesium",
  draco: "node_modules/three/examples/jsm/libs/draco",
};
const types = { ".css": "text/css", ".html": "text/html", ".js": "text/javascript", ".json": "application/json", ".wasm": "application/wasm" };

const pages = createServer(async (request, response) => {
  const [first, ...rest] = decodeURIComponent(new URL(request.url, "http://host").pathname).slice(1).split("/");
  const file = first in folders ? path.join(here, folders[first], ...rest) : path.join(here, "built", first, ...rest);
  try {
    const bytes = await readFile(file);
    response.setHeader("Content-Type", types[path.extname(file)] ?? "application/octet-stream").end(bytes);
  } catch {
    response.writeHead(404).end();
  }
});

export const origin = `http://127.0.0.1:${process.env.PAGES_PORT}`;
const patience = Number(process.env.PATIENCE ?? 120_000); // Enough for a busy machine without a graphics card.

// Calls `look` with an empty page and a list of failures, and expects the list to stay empty. A response with
// Retry-After is not a failure.
export async function inChromium(look) {
  await new Promise((ready) => pages.listen(Number(process.env.PAGES_PORT), "127.0.0.1", ready));
  const browser = await chromium.launch({
    executablePath: process.env.CHROMIUM,
    args: [
      "--no-sandbox",
      "--use-gl=angle",
      "--use-angle=swiftshader",
      "--enable-unsafe-swiftshader",
      `--ignore-certificate-errors-spki-list=${process.env.CERTIFICATE_HASH}`,
    ],
  });
  try {
    const page = await browser.newPage({ viewport: { width: 640, height: 480 } });
    page.setDefaultTimeout(patience);
    const failure = [];
    page.on("pageerror", (error) => failure.push(error.message));
    page.on("response", (answer) => {
      if (answer.status() >= 400 && answer.status() !== 503) failure.push(`${answer.status()} ${answer.url()}`);
    });
    await look(page, failure);
    if (failure.length > 0) throw new Error(failure.join("\n"));
  } finally {
    await browser.close();
    pages.close();
  }
}

// Waits until `isSo` has held for a second without interruption.
export async function settled(page, isSo) {
  const until = Date.now() + patience;
  for (let since = 0; since < 10; ) {
    if (Date.now() > until) throw new Error(`Not settled after ${patience / 1000} s.`);
    await page.waitForTimeout(100);
    since = (await isSo()) ? since + 1 : 0;
  }
}

export function picture(page, name) {
  return page.screenshot({ path: path.join(process.env.PICTURES, `${name}.png`) });
}
