// Takes the pictures of the README: the viewer as a person meets it.
//
//   node pictures.mjs SERVER_PROGRAM VIEWER_FOLDER DATASETS_FOLDER OUTPUT_FOLDER
//
// The folder of datasets holds visible-female-head (see the README), head-phantom (`generate head
// --size 256 --noise 30 --seed 7`) and gyroid (`generate gyroid --size 65`).
import { createRequire } from "node:module";
import path from "node:path";

import { Server } from "./viewer_host.mjs";

const [program, viewer, datasets, output] = process.argv.slice(2);
const patience = 300_000;
const pictures = {
  viewer: ["#dataset=visible-female-head&isovalue=-300.5", 1120, 720],
  viewer_scene: [
    "#dataset=visible-female-head&isovalue=-300.5&error=2&opacity=0.35&colour=e8b89a&surfaces=400.5,f0e6d2&clip=z" +
      "&clipAt=0.66&clipFlipped=true&level=40&windowWidth=400&axes=false&eye=470,-110,1960&target=256,235,1610", 1120, 720,
  ],
  viewer_narrow: ["#dataset=visible-female-head&isovalue=300.5&error=2", 360, 740],
  viewer_light: ["#dataset=gyroid&theme=light&colouring=tiles&error=2&region=ball:32,20,40,16=0", 1120, 720],
};

const installed = createRequire(new URL("../../../client/web/package.json", import.meta.url));
const { chromium } = installed("playwright-core");
const server = new Server(program, datasets, viewer);
await server.start();
const browser = await chromium.launch({
  executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium",
  args: ["--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"],
});
for (const [name, [hash, width, height]] of Object.entries(pictures)) {
  const page = await browser.newPage({ viewport: { width, height }, colorScheme: "dark" });
  page.setDefaultTimeout(patience);
  await page.goto(server.page + hash);
  await page.waitForFunction(
    () =>
      document.querySelector(".state b")?.textContent === "Complete" &&
      ![...document.querySelectorAll(".surface-state")].slice(1).some(({ textContent }) => textContent === "" || textContent.endsWith("…")) &&
      document.querySelectorAll('.dataset img[src^="data:image/png"]').length >= Math.min(2, innerWidth / 300),
    null, { polling: 500 },
  );
  if (name === "viewer_light") {
    await page.click(".seal");
    await page.click('summary:has-text("Finer")');
  }
  await page.mouse.move(width / 2, 4);
  await page.waitForTimeout(name === "viewer_scene" ? 30_000 : 1000); // What is drawn at rest is drawn on the processor.
  await page.screenshot({ path: path.join(output, `${name}.png`), timeout: patience });
  console.log(name, await page.innerText(".facts"));
  await page.close();
}
await browser.close();
await server.stop();
process.exit(0);
