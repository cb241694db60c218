// Families of datasets as a person meets them: labels of a segmentation, times and fields of a simulation.
//
//   node family_test.mjs SERVER_PROGRAM VIEWER_FOLDER SCRATCH_FOLDER
import assert from "node:assert/strict";
import { mkdirSync, rmSync, writeFileSync } from "node:fs";
import path from "node:path";

import { complete, finish, open, patience, run, scratch, serveFolder, surfacePixels, test } from "./in_a_browser.mjs";

const size = 33;
const folder = path.join(scratch, "families");
rmSync(folder, { recursive: true, force: true });
mkdirSync(folder, { recursive: true });
prepareLabels();
const families = await serveFolder(folder);

await test("ShowsTheLabelsOfASegmentation", showsLabels);
await test("LoadsNoLabelThatIsHidden", loadsWhatIsShown);
await finish();

// ----

async function showsLabels(page) {
  await open(page, "", families);
  await complete(page);
  assert.equal(await page.locator(".dataset").count(), 1, "a family is one entry");
  assert.match(await page.textContent(".dataset-facts"), /3 labels/);
  assert.deepEqual(await page.locator(".label-name").allTextContents(), ["label 2", "label 5", "label 9"]);
  await settled(page);
  const all = (await surfacePixels(page)).share;
  await page.click('.eye[aria-label="Show label 5"]');
  await page.waitForFunction(() => document.querySelector(".labels-count").textContent === "2 of 3 shown");
  await page.click('.labels-head button:has-text("None")');
  await page.waitForTimeout(500);
  assert((await surfacePixels(page)).share < all / 10, "nothing is shown");
  await page.click('.labels-head button:has-text("All")');
  await settled(page);
  await page.waitForFunction(() => /surfaces=0\.5,[0-9a-f]{6},,,,seg\.label5;/.test(location.hash));
}

async function loadsWhatIsShown(page) {
  let streams = 0;
  page.on("websocket", () => ++streams);
  await open(page, "#dataset=seg.label2&isovalue=0.5&surfaces=0.5,ff0000,,,hidden,seg.label5;0.5,00ff00,,,hidden,seg.label9", families);
  await complete(page);
  await page.waitForSelector('.dataset img[src^="data:image/png"]', { timeout: patience });
  assert.equal(streams, 2, "one surface is shown, over one connection; small pictures have another");
  await page.click('.eye[aria-label="Show label 9"]');
  await settled(page);
  assert.equal(streams, 3);
}

// Until nothing comes any more, of no surface.
function settled(page) {
  return page.waitForFunction(() => document.querySelectorAll(".label-row.is-coming").length === 0 &&
    document.querySelector(".state b")?.textContent === "Complete", null, { timeout: patience });
}

// Three balls in a row.
function prepareLabels() {
  const samples = new Uint8Array(size ** 3);
  for (let z = 0, i = 0; z < size; ++z) {
    for (let y = 0; y < size; ++y) {
      for (let x = 0; x < size; ++x, ++i) {
        [[2, 6], [5, 16], [9, 26]].forEach(([label, at]) => {
          if (Math.hypot(x - at, y - 16, z - 16) < 5.2) samples[i] = label;
        });
      }
    }
  }
  const file = path.join(scratch, "seg.nrrd");
  writeVolume(file, "uint8", Buffer.from(samples.buffer));
  run("prepare", file, "--label", "all", "--name", "seg", "-o", folder);
}

function writeVolume(file, type, bytes) {
  const header = `NRRD0004\ntype: ${type}\ndimension: 3\nsizes: ${size} ${size} ${size}\nendian: little\nencoding: raw\n\n`;
  writeFileSync(file, Buffer.concat([Buffer.from(header), bytes]));
}
