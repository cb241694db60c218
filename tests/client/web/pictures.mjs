// Takes the README's picture of the viewer, and others.
//
//   node pictures.mjs SERVER_PROGRAM VIEWER_FOLDER DATASETS_FOLDER OUTPUT_FOLDER
//
// `viewer` shows the demo's volume and needs no other dataset. For the others the folder of datasets must contain
// visible-female-head (the whole CT), gyroid (`generate gyroid --size 65`), and frog (`prepare frogtissue.mhd --label
// all --name frog`). The demo's volume and generated data are prepared into it here. ONLY=name takes one picture;
// SIZE=390x844 and THEME=light change its size and theme.
import { execFileSync } from "node:child_process";
import { existsSync, mkdirSync, mkdtempSync, rmSync } from "node:fs";
import { createRequire } from "node:module";
import { tmpdir } from "node:os";
import path from "node:path";

import { samplesOf, writeNrrd, writeVti } from "./made_volumes.mjs";

import { Server } from "./viewer_host.mjs";

const [program, viewer, datasets, output] = process.argv.slice(2);
const patience = 300_000;
const pictures = {
  viewer: [
    "#dataset=visible_female_head&isovalue=-300.5&color=e0ac8d&opacity=0.5&min_component=20&material=skin" +
      "&surfaces=300.5,f3ead6,,,,,20,bone&axes=false&follow_view=false", 1120, 720,
  ],
  viewer_scene: [
    "#dataset=visible-female-head&isovalue=-300.5&error=2&opacity=0.35&color=e8b89a&surfaces=400.5,f0e6d2&clip=z" +
      "&clip_at=0.66&clip_flipped=true&level=40&window_width=400&axes=false&eye=470,-110,1960&target=256,235,1610" +
      "&color_by=dose&colors=viridis", 1120, 720,
  ],
  viewer_times: [
    "#dataset=flow&isovalue=0.3&error=0.1&color_by=flow.heat.t0000&colors=coolwarm&speed=5&playing=true", 1120, 720,
  ],
  viewer_labels: ["#dataset=frog&error=1&eye=-60,-290,560&target=240,225,95&axes=false", 1120, 720],
  viewer_narrow: ["#dataset=visible-female-head&isovalue=300.5&error=2", 360, 740],
  viewer_light: ["#dataset=gyroid&theme=light&coloring=tiles&error=2&region=ball:32,20,40,16=0", 1120, 720],
};

const installed = createRequire(new URL("../../../client/web/package.json", import.meta.url));
const { chromium } = installed("playwright-core");
prepareMade();
const server = new Server(program, datasets, viewer);
await server.start();
const browser = await chromium.launch({
  executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium",
  args: ["--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"],
});
for (const [name, [hash, ...usual]] of Object.entries(pictures)) {
  if (process.env.ONLY && process.env.ONLY !== name) continue;
  const [width, height] = process.env.SIZE?.split("x").map(Number) ?? usual;
  const page = await browser.newPage({ viewport: { width, height }, colorScheme: process.env.THEME ?? "dark" });
  page.setDefaultTimeout(patience);
  await page.goto(server.page + hash);
  await page.waitForFunction(
    () =>
      document.querySelector(".state b")?.textContent === "Complete" &&
      ![...document.querySelectorAll(".surface-state")].slice(1).some(({ textContent }) => textContent === "" || textContent.endsWith("…")) &&
      document.querySelectorAll(".label-row.is-coming").length === 0 &&
      document.querySelectorAll('.dataset img[src^="blob:"]').length >= Math.min(document.querySelectorAll(".dataset").length, 2, innerWidth / 300),
    null, { polling: 500 },
  );
  if (name === "viewer_light") {
    await page.click(".seal");
    await page.click('summary:has-text("Finer")');
  }
  if (name === "viewer_labels") await page.locator('input[aria-label="Opacity of label 13"]').fill("0.4"); // The skeleton.
  if (name === "viewer_times") { // In the middle of the playback.
    await page.waitForFunction(() => document.querySelector(".times .pace").textContent.endsWith(" of"), null, { polling: 200 });
    await page.waitForFunction(() => document.querySelector(".times .time").textContent === "0.7 s", null, { polling: 20 });
  }
  await page.mouse.move(width / 2, 4);
  await page.waitForTimeout(["viewer", "viewer_scene", "viewer_labels"].includes(name) ? 30_000 : 1000); // Rendering at rest takes long on the processor.
  await page.screenshot({ path: path.join(output, `${name}.png`), timeout: patience });
  console.log(name, await page.innerText(".facts"));
  await page.close();
}
await browser.close();
await server.stop();
process.exit(0);

// ----

// Two warm drops that orbit each other, at sixteen times; and a dose in the world of the head.
function prepareMade() {
  mkdirSync(datasets, { recursive: true });
  if (!existsSync(path.join(datasets, "visible_female_head.mtd"))) {
    const volume = new URL("../../../server/volume/demo/visible_female_head.nrrd", import.meta.url).pathname;
    run("prepare", volume, "-o", path.join(datasets, "visible_female_head.mtd"));
  }
  if (process.env.ONLY === "viewer") return;
  const folder = mkdtempSync(path.join(tmpdir(), "pictures-"));
  if (!existsSync(path.join(datasets, "flow.drops.t0000.mtd"))) {
    const files = Array.from({ length: 16 }, (_, time) => {
      const file = path.join(folder, `flow_${time}.vti`);
      writeVti(file, 65, flowAt((2 * Math.PI * time) / 16));
      return file;
    });
    run("prepare", ...files, "--time-series", "flow", "--field", "all", "--times", "0:0.1", "--time-unit", "s", "-o", datasets);
  }
  if (!existsSync(path.join(datasets, "dose.mtd"))) {
    const file = path.join(folder, "dose.nrrd");
    const dose = samplesOf(64, (x, y, z) => 60 * Math.exp(-Math.hypot(8 * x - 330, 8 * y - 90, 3.7 * z - 110) / 130));
    const space = "space dimension: 3\nspace directions: (8,0,0) (0,8,0) (0,0,3.7)\nspace origin: (0,0,1500)\n";
    writeNrrd(file, 64, dose, space);
    run("prepare", file, "--name", "dose", "-o", path.join(datasets, "dose.mtd"));
  }
  rmSync(folder, { recursive: true });
}

function flowAt(angle) {
  const drops = [0, 1, 2, 3, 4].map((i) => {
    const at = angle + (2 * Math.PI * i) / 5;
    return [32 + 15 * Math.cos(at), 32 + 15 * Math.sin(at), 32 + 11 * Math.sin(2 * at + i), 60 + 25 * Math.sin(angle + i)];
  });
  const near = (x, y, z, [a, b, c, width]) => Math.exp(-((x - a) ** 2 + (y - b) ** 2 + (z - c) ** 2) / width);
  return {
    drops: samplesOf(65, (x, y, z) => drops.reduce((sum, drop) => sum + near(x, y, z, drop), 0)),
    heat: samplesOf(65, (x, y, z) => 20 + 15 * Math.sin(x / 9 + angle) * Math.cos(y / 8) + (z - 32) / 2),
  };
}

function run(...words) {
  execFileSync(program, [...words, "--quiet"]);
}
