// What axe-core finds in the page: nothing serious, dark and light, wide and narrow, with all that can be
// open open.
//
//   node accessibility_test.mjs SERVER_PROGRAM VIEWER_FOLDER SCRATCH_FOLDER
import { examine } from "./axe.mjs";
import { complete, finish, open, patience, test } from "./in_a_browser.mjs";

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
