// axe-core finds nothing serious in the page, dark and light, wide and narrow, with everything open. On a phone,
// buttons are large enough for fingers and the surface has enough space.
//
//   node accessibility_test.mjs SERVER_PROGRAM VIEWER_FOLDER SCRATCH_FOLDER
import assert from "node:assert/strict";
import path from "node:path";

import { examine } from "./axe.mjs";
import { complete, finish, notice, open, patience, scratch, test } from "./in_a_browser.mjs";

const everything = "#dataset=head&isovalue=300.5&error=2&surfaces=900.5,3060ff,1&slice=y&region=ball:32,32,32,8=0";

for (const [width, height] of [[1600, 1000], [390, 844]]) {
  await test(`HasNoAccessibilityViolations_${width}`, async (page) => {
    await page.setViewportSize({ width, height });
    await open(page, `${everything}&theme=dark`);
    await complete(page);
    await page.evaluate(() => document.querySelectorAll("details").forEach((one) => (one.open = true)));
    const canvas = await page.locator(".stage canvas").boundingBox();
    await page.mouse.click(canvas.x + 0.5 * canvas.width, canvas.y + 0.42 * canvas.height); // Not on a handle.
    await page.waitForSelector(".picked:not([hidden])", { timeout: patience });
    await page.click(".seal");
    await page.evaluate(() => (document.getElementById("tooltip").style.display = "none"));
    await examine(page);
    await setTheme(page, "light");
    await examine(page);
    await page.keyboard.press("Escape");
    await page.focus(".stage canvas");
    await page.keyboard.press("?");
    await examine(page);
    await setTheme(page, "dark");
    await examine(page);
  });
}

async function setTheme(page, theme) {
  await page.evaluate((word) => (location.hash = `${location.hash.replace(/&theme=[^&]*/, "")}&theme=${word}`), theme);
  await page.waitForFunction((word) => document.documentElement.dataset.theme === word, theme);
}

const telephone = { viewport: { width: 390, height: 844 }, hasTouch: true, isMobile: true };
await test("TouchTargetsAreLargeEnough", async (page) => {
  await open(page, everything);
  await complete(page);
  await page.evaluate(() => document.querySelectorAll("details").forEach((one) => (one.open = true)));
  const small = await page.evaluate(() => [...document.querySelectorAll("button, input, select, summary")].flatMap((one) => {
    const hit = one.closest(".toggle") ?? one; // Its label is clickable, too.
    const { width, height } = hit.getBoundingClientRect();
    const isAnAxis = one.closest(".orientation"); // The buttons "Front", "Side" and "Top" do the same.
    return isAnAxis || width === 0 || (width >= 43.5 && height >= 43.5) ? [] : [`${hit.outerHTML.slice(0, 120)}: ${width} x ${height}`];
  }));
  assert.deepEqual(small, []);
  const cutOff = await page.evaluate(() => [...document.querySelectorAll(".tools button, .seal")]
    .filter((one) => one.getBoundingClientRect().right > innerWidth || one.scrollWidth > one.clientWidth).map(({ textContent }) => textContent));
  assert.deepEqual(cutOff, [], "nothing is cut off");
  const canvas = await page.locator(".stage canvas").boundingBox();
  await page.touchscreen.tap(canvas.x + 0.5 * canvas.width, canvas.y + 0.42 * canvas.height);
  await page.waitForSelector(".picked:not([hidden])", { timeout: patience });
  const picked = await page.locator(".picked").boundingBox();
  assert(picked.height <= 0.3 * canvas.height, `${picked.height} of ${canvas.height}`);
  assert(picked.y >= canvas.y + 0.5 * canvas.height, "the middle is free");
  const below = await page.evaluate(() => [...document.querySelectorAll(".orientation .end, .scale-bar")]
    .filter((one) => getComputedStyle(one).visibility === "visible")
    .filter((one) => {
      const [a, b] = [one, document.querySelector(".picked")].map((it) => it.getBoundingClientRect());
      return a.left < b.right && b.left < a.right && a.top < b.bottom && b.top < a.bottom;
    }).map(({ className }) => className));
  assert.deepEqual(below, [], "nothing lies over what is told");
  await page.locator(".picked .close").tap();
  await page.locator(".seal").tap();
  const hidden = await page.evaluate(() => {
    const certificate = document.querySelector(".certificate");
    const { top, left, right, bottom } = certificate.getBoundingClientRect();
    const places = [...document.querySelectorAll(".orientation .end")].map((one) => one.getBoundingClientRect())
      .map((end) => [end.x + end.width / 2, end.y + end.height / 2]).filter(([x, y]) => x > left && x < right && y > top && y < bottom);
    return { top, ends: places.length, over: places.filter(([x, y]) => !certificate.contains(document.elementFromPoint(x, y))).length };
  });
  assert(hidden.top >= 0 && hidden.ends > 0, `the certificate begins in the picture: ${JSON.stringify(hidden)}`);
  assert.equal(hidden.over, 0, "the axes lie below the certificate");
  await showsANoticeBelowTheTools(page, 390);
}, telephone);
await test("NoticesDoNotOverlapTheTools", async (page) => {
  for (const width of [1600, 900, 390]) await showsANoticeBelowTheTools(page, width);
});
async function showsANoticeBelowTheTools(page, width) {
  await page.setViewportSize({ width, height: 844 });
  await page.goto("about:blank");
  await open(page, "#dataset=head&isovalue=99999");
  await notice(page, /no surface at isovalue 99999/);
  const { tools, met } = await page.evaluate(() => {
    const box = document.querySelector(".notice").getBoundingClientRect();
    const tools = [...document.querySelectorAll(".tools button")].map((one) => one.getBoundingClientRect());
    const met = tools.filter(({ left, right, top, bottom }) => left < box.right && right > box.left && top < box.bottom && bottom > box.top);
    return { tools: tools.filter(({ width }) => width > 0).length, met: met.length };
  });
  assert(tools > 4 && met === 0, `the notice lies over ${met} of ${tools} tools in a width of ${width}`);
}
for (const [layout, width] of [["surface", 390], ["four", 390], ["surface", 900]]) {
  await test(`LegendsDoNotOverlapTheTools_${layout}_${width}`, async (page) => {
    await open(page, `${everything}&color_by=gyroid&layout=${layout}`);
    await complete(page);
    await page.waitForFunction(() => document.querySelectorAll(".legend:not([hidden])").length === 2, null, { timeout: patience });
    const met = await page.evaluate(() => {
      const boxes = (selector) => [...document.querySelectorAll(selector)].map((one) => ({ one, box: one.getBoundingClientRect() }));
      const meets = (a, b) => a.left < b.right && b.left < a.right && a.top < b.bottom && b.top < a.bottom;
      const others = boxes(".tools button, .orientation .end, .turn-up:not([hidden]), .scale-bar");
      return boxes(".legend").flatMap(({ box }) => others.filter((other) => other.box.width > 0 && meets(box, other.box)).map(({ one }) => one.outerHTML.slice(0, 80)));
    });
    assert.deepEqual(met, []);
    const outside = await page.evaluate(() => {
      const stage = document.querySelector(".stage").getBoundingClientRect();
      return [...document.querySelectorAll(".legend")].filter((one) => one.getBoundingClientRect().bottom > stage.bottom).length;
    });
    assert.equal(outside, 0, "they lie in the picture");
    await page.screenshot({ path: path.join(scratch, `legends_${layout}_${width}.png`) });
  }, width === 390 ? telephone : {});
}
await finish();
