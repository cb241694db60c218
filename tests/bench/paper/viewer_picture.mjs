// Saves the viewer's picture at an address, drawn by Chromium without a graphics card: a part of paper.sh.
//
//   node viewer_picture.mjs SERVER_PROGRAM VIEWER_FOLDER DATASET_FOLDER ADDRESS OUTPUT.png
import { createRequire } from "node:module";

import { Server } from "../../client/web/viewer_host.mjs";

const [program, viewer, datasets, address, output] = process.argv.slice(2);
const installed = createRequire(new URL("../../../client/web/package.json", import.meta.url));
const { chromium } = installed("playwright-core");
const server = new Server(program, datasets, viewer);
await server.start();
const browser = await chromium.launch({
  executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium",
  args: ["--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"],
});
try {
  const page = await browser.newPage({ viewport: { width: 835, height: 570 } });
  page.setDefaultTimeout(300_000);
  await page.goto(`${server.page}#${address}`);
  await page.waitForSelector(".dataset");
  await page.click('summary:has-text("Export")');
  const coming = page.waitForEvent("download"); // Comes when all samples are there.
  await page.click('.action:has-text("Picture")');
  await (await coming).saveAs(output);
} finally {
  await browser.close();
  await server.stop();
}
