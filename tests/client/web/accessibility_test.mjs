// What axe-core finds in the page: nothing serious, dark and light, wide and narrow, with all that can be
// open open.
//
//   node accessibility_test.mjs SERVER_PROGRAM VIEWER_FOLDER SCRATCH_FOLDER
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { createRequire } from "node:module";

import { complete, finish, open, patience, test } from "./in_a_browser.mjs";

const installed = createRequire(new URL("../../../client/web/package.json", import.meta.url));
const axe = readFileSync(installed.resolve("axe-core"), "utf8");
const everything = "#dataset=head&isovalue=300.5&error=2&opacity=0.5&surfaces=900.5,3060ff,1&slice=y&region=ball:32,32,32,8=0";

for (const theme of ["dark", "light"]) {
  for (const [width, height] of [[1600, 1000], [390, 844]]) {
    await test(`HasNothingThatKeepsPeopleOut_${theme}_${width}`, async (page) => {
      await page.setViewportSize({ width, height });
      await open(page, `${everything}&theme=${theme}`);
      await complete(page);
      await page.evaluate(() => document.querySelectorAll("details").forEach((one) => (one.open = true)));
      const canvas = await page.locator(".stage canvas").boundingBox();
      await page.mouse.click(canvas.x + 0.5 * canvas.width, canvas.y + 0.42 * canvas.height); // Beside the handles.
      await page.waitForSelector(".picked:not([hidden])", { timeout: patience });
      await page.click(".seal");
      await page.evaluate(() => (document.getElementById("tooltip").style.display = "none"));
      await examine(page);
      await page.keyboard.press("Escape");
      await page.focus(".stage canvas");
      await page.keyboard.press("?");
      await examine(page);
    });
  }
}
await finish();

async function examine(page) {
  // The page's policy forbids scripts from elsewhere; what is evaluated is none.
  await page.evaluate(axe);
  const { violations } = await page.evaluate(() => window.axe.run());
  const serious = violations.filter(({ impact }) => impact === "serious" || impact === "critical");
  const words = serious.map(({ id, help, nodes }) => `${id}: ${help}: ${nodes.slice(0, 4).map(({ html, failureSummary }) => `${html.slice(0, 160)} ${failureSummary}`).join(" | ")}`);
  assert.deepEqual(words, []);
  console.log(`     ${violations.length} lesser findings: ${violations.map(({ id }) => id).join(", ")}`);
}
