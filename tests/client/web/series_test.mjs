// Series of datasets in the viewer: labels of a segmentation, times and fields of a simulation.
//
//   node series_test.mjs SERVER_PROGRAM VIEWER_FOLDER SCRATCH_FOLDER
import assert from "node:assert/strict";
import { cpSync, mkdirSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import path from "node:path";

import { examine } from "./axe.mjs";
import { complete, finish, notice, open, patience, run, scratch, serveFolder, surfacePixels, test } from "./in_a_browser.mjs";
import { samplesOf, unitSpace, writeNrrd, writeVti } from "./made_volumes.mjs";

const size = 33;
const folder = path.join(scratch, "series");
rmSync(folder, { recursive: true, force: true });
mkdirSync(folder, { recursive: true });
prepareLabels();
prepareCells();
prepareHundreds();
prepareTimes();
const series = await serveFolder(folder);

await test("ShowsTheLabelsOfASegmentation", showsLabels);
await test("LoadsNoHiddenLabels", loadsWhatIsShown);
await test("NamesAClickedLabelAndIsolatesOne", namesAndIsolates);
await test("RenamesLabelsAndKeepsNotes", renames);
await test("SearchesSortsAndZoomsToLabels", findsLabels);
await test("SelectsSeveralLabels", selectsSeveral);
await test("SavesATableOfVisibleLabels", savesTable);
await test("SavesSimplifiedLabelsWhereSamplesAreShown", savesSimplified);
await test("ShowsHundredsOfLabelsWithFewRequests", showsHundreds);
await test("SlicesShowTheImageOfLabels", showsImage);
await test("ShowsLabelsBesideTheSurfaceOfAnImage", showsBeside);
await test("LabelsReplaceEachOtherInFrames", replacesLabels);
await test("PlaysTimesColoredByAnotherField", playsTimes);
await test("OverlaysAnotherField", overlays);
await test("ShowsOneTimeAtOnce", showsOneTime);
await test("SavesAPictureOfEachTime", savesTimes);
await test("SavesAVideoOfEvenTimes", savesVideo);
await test("StopsRecordingAtAMissingTime", failsAFilm);
await test("TimeControlsDoNotCoverTheSurfaceOnPhones", leavesRoom, { viewport: { width: 390, height: 800 }, hasTouch: true, isMobile: true });
await test("NoticesDatasetsThatAreServedLater", noticesNewDatasets); // The last: it adds one.
await finish();

// ----

async function showsLabels(page) {
  await open(page, "#dataset=seg", series);
  await complete(page);
  assert.equal(await page.locator(".dataset").count(), 5, "a series is one entry");
  assert.deepEqual(await page.locator(".label-name").allTextContents(), ["label 2", "label 5", "label 9"]);
  await settled(page);
  const cut = await page.evaluate(() => {
    const { right } = document.querySelector(".facts").getBoundingClientRect();
    return [...document.querySelectorAll(".fact span")].filter((one) => one.getBoundingClientRect().right > right + 1).map((one) => one.textContent);
  });
  assert.deepEqual(cut, [], "no fact is cut off beside the badge");
  await examine(page);
  const all = (await surfacePixels(page)).share;
  await page.click('.eye[aria-label="Show label 5"]');
  await page.waitForFunction(() => document.querySelector(".labels-count").textContent === "2 of 3 shown");
  await page.click('.labels-head button:has-text("None")');
  await page.waitForTimeout(500);
  assert((await surfacePixels(page)).share < all / 10, "nothing is shown");
  await page.click('.labels-head button:has-text("All")');
  await settled(page);
  await page.waitForFunction(() => location.hash.includes("labels=2-9") && !location.hash.includes("surfaces="));
  await page.locator('[aria-label="Opacity of label 5"]').fill("0.4");
  assert(await page.locator('.labels-head span:text-is("mixed")').isVisible());
  assert.equal(await page.getAttribute('[aria-label="Opacity of all labels"]', "aria-valuetext"), "mixed");
  await page.locator('[aria-label="Opacity of all labels"]').fill("0.7");
  assert(await page.locator('.labels-head span:text-is("mixed")').isHidden());
  await page.click('button:has-text("Reset all settings")');
  await page.waitForFunction(() => document.querySelector(".labels-count").textContent === "3 of 3 shown");
  assert.equal(await page.getAttribute('[aria-label="Opacity of all labels"]', "aria-valuetext"), "100 %");
}

async function loadsWhatIsShown(page) {
  let streams = 0;
  page.on("websocket", () => ++streams);
  await open(page, "#dataset=seg.label2&isovalue=0.5&surfaces=0.5,ff0000,,,hidden,seg.label5;0.5,00ff00,,,hidden,seg.label9", series);
  await complete(page);
  await page.waitForSelector('.dataset img[src^="blob:"]', { timeout: patience });
  assert.equal(streams, 2, "one surface is shown, over one connection beside that of queries");
  await page.click('.eye[aria-label="Show label 9"]');
  await settled(page);
  assert.equal(streams, 2, "another one uses the free connection");
}

async function namesAndIsolates(page) {
  await open(page, "#dataset=seg&axes=false&eye=16,-60,16&target=16,16,16", series);
  await complete(page);
  await settled(page);
  const canvas = await page.locator(".stage canvas").boundingBox();
  await page.mouse.click(canvas.x + canvas.width / 2, canvas.y + canvas.height / 2); // The ball in the middle.
  await page.waitForSelector(".picked:not([hidden])", { timeout: patience });
  assert.equal(await page.textContent(".picked-label"), "label 5");
  assert.deepEqual(await page.locator(".label-row.is-selected .label-name").allTextContents(), ["label 5"]);
  await page.click('[aria-label="Show only label 9"]');
  await page.waitForFunction(() => document.querySelector(".labels-count").textContent === "1 of 3 shown");
  assert.deepEqual(await page.locator('.eye[aria-pressed="true"]').evaluateAll((all) => all.map((one) => one.ariaLabel)), ["Show label 9"]);
}

async function renames(page) {
  await open(page, "#dataset=seg&axes=false&eye=16,-60,16&target=16,16,16", series);
  await complete(page);
  await settled(page);
  await page.dblclick('.label-name:text-is("label 5")');
  await page.fill('[aria-label="Name of label 5"]', "core; left");
  await page.press('[aria-label="Name of label 5"]', "Enter");
  assert.deepEqual(await page.locator(".label-name").allTextContents(), ["label 2", "core; left", "label 9"]);
  await open(page, "#dataset=seg&labels=2-9&label_names=5:core&axes=false&eye=16,-60,16&target=16,16,16", series);
  await complete(page);
  await settled(page);
  assert.doesNotMatch(await page.textContent("body"), /No dataset named/, "an edited address may name a series");
  const canvas = await page.locator(".stage canvas").boundingBox();
  const [x, y] = [canvas.x + canvas.width / 2, canvas.y + canvas.height / 2];
  const hovers = (name) => page.waitForFunction((text) => document.querySelector(".label-hover:not([hidden])")?.textContent === text, name, { timeout: patience });
  await page.mouse.move(x, y);
  await hovers("core");
  await page.mouse.click(x, y);
  await page.fill('[aria-label="Note on A"]', "the middle");
  await page.press('[aria-label="Note on A"]', "Enter");
  assert.equal(await page.textContent(".picked-label"), "core");
  assert.doesNotMatch(await page.textContent(".picked"), /gradient/, "the field of a label says nothing");
  await page.click('.label-name:text-is("label 9")');
  await page.mouse.move(x, y);
  await hovers("label 9");
  await page.mouse.click(x, y);
  await page.waitForSelector('.picked-label b:text-is("label 9")', { timeout: patience });
  await page.waitForFunction(() => decodeURIComponent(location.hash).replaceAll("+", " ").includes("the middle;"), null, { timeout: patience });
  assert((await tableOf(page)).some(([label, name]) => label === "5" && name === "core"));
}

// Clicks the button of the table; returns its rows, without the header.
async function tableOf(page) {
  const [download] = await Promise.all([
    page.waitForEvent("download", { timeout: patience }), page.click('button:has-text("(CSV)")'),
  ]);
  const [header, ...rows] = readFileSync(await download.path(), "utf8").trim().split("\r\n").map((line) => line.split(","));
  assert.deepEqual(header.slice(0, 2), ["label", "name"]);
  return rows;
}

async function selectsSeveral(page) {
  await open(page, "#dataset=cells&labels=1-30&axes=false", series);
  await complete(page);
  await settled(page);
  const name = (label) => page.locator(`.label-name:text-is("label ${label}")`);
  const selected = async () => (await page.locator('.label-name[aria-pressed="true"]').allTextContents()).map((text) => Number(text.slice(6)));
  const shown = (count) => page.waitForFunction((n) => document.querySelector(".labels-count").textContent === `${n} of 30 shown`, count);
  await name(3).click();
  await name(6).click({ modifiers: ["Shift"] });
  assert.deepEqual(await selected(), [3, 4, 5, 6]);
  await name(5).click({ modifiers: ["ControlOrMeta"] });
  assert.deepEqual(await selected(), [3, 4, 6]);
  // A control of a selected label changes all selected ones, that of another label only that one.
  await page.click('[aria-label="Show only label 4"]');
  await shown(3);
  await page.click('.eye[aria-label="Show label 3"]');
  await shown(0);
  await page.click('.eye[aria-label="Show label 6"]');
  await shown(3);
  await page.click('.eye[aria-label="Show label 5"]');
  await shown(4);
  await page.locator('[aria-label="Color of label 6"]').fill("#ff0000");
  const colors = await Promise.all([3, 4, 5, 6].map((label) => page.inputValue(`[aria-label="Color of label ${label}"]`)));
  assert.deepEqual(colors.map((color) => color === "#ff0000"), [true, true, false, true]);
  await settled(page);
  assert.deepEqual((await tableOf(page)).map(([label]) => label), ["3", "4", "6"]);
  await name(6).focus();
  for (const key of ["ArrowDown", "Shift+ArrowDown", "Shift+ArrowDown"]) await page.keyboard.press(key);
  assert.deepEqual(await selected(), [7, 8, 9]);
  await page.keyboard.press("Space");
  assert.deepEqual(await selected(), [7, 8]);
  await page.keyboard.press("ControlOrMeta+a");
  assert.equal((await selected()).length, 30);
  await page.keyboard.press("Escape");
  assert.deepEqual(await selected(), []);
}

async function showsImage(page) {
  await open(page, "#dataset=hundreds&labels=8&layout=four&axes=false", series);
  await settled(page);
  const values = (pattern) => page.waitForFunction((text) => [...document.querySelectorAll(".slice-view")]
    .every((one) => new RegExp(text).test(one.getAttribute("aria-label"))), pattern, { timeout: patience });
  await values(": 2[01](, label \\d+)?\\. Click"); // The sample at the center.
  await page.click('button:text-is("Fit")');
  await page.waitForFunction(() => /cross=[23],[89],[23](&|$)/.test(location.hash), null, { timeout: patience });
  await values(": [23], label 8\\. Click"); // The crosshair is in the label.
  await page.click('summary:has-text("Slices")');
  await page.selectOption('[aria-label="Samples of"]', "stain");
  await page.waitForFunction(() => /samples_of=stain/.test(location.hash));
  // All three slices show the value at the crosshair.
  await page.evaluate(() => (location.hash = location.hash.replace(/cross=[^&]*/, "cross=7.25,8,3")));
  await values(": 7\\.25(, label \\d+)?\\. Click");
  const [list, row] = await Promise.all([".labels", '.label-name:text-is("label 8")'].map((one) => page.locator(one).boundingBox()));
  assert(Math.abs(row.y - list.y) < 20, "the list begins at the shown label");
  // Clicks on a slice show the image's value.
  await open(page, "#dataset=hundreds&labels=300&slice=z&eye=20.5,20.5,120&target=20.5,20.5,20.5&up=y&axes=false", series);
  await settled(page);
  const canvas = await page.locator(".stage canvas").boundingBox();
  await page.waitForFunction(() => document.querySelector(".legend:not([hidden])"), null, { timeout: patience });
  await page.waitForTimeout(500); // The slice arrives.
  await page.mouse.click(canvas.x + canvas.width / 2, canvas.y + canvas.height / 2);
  await page.waitForFunction(() => /^Value 20\.\d/.test(document.querySelector(".picked .field")?.textContent), null, { timeout: patience });
}

async function showsBeside(page) {
  await open(page, "#dataset=stain&isovalue=30&axes=false&layout=four&cross=3,8,3", series);
  await settled(page);
  assert.deepEqual(await page.locator('[aria-label="Labels beside the surfaces"] option').allTextContents(),
    ["No labels", "cells (30)", "hundreds (300)", "seg (3)"]);
  assert.equal(await page.locator(".labels-table").isVisible(), false);
  await page.selectOption('[aria-label="Labels beside the surfaces"]', "hundreds");
  await settled(page);
  assert.equal(await page.textContent(".labels-count"), "24 of 300 shown");
  assert.equal(await page.locator(".surface-row").count(), 1, "labels have their own list");
  assert.match(page.url(), /[&#]labels=hundreds:1-24(&|$)/);
  assert(page.url().length < 220, page.url());
  await page.click('.label-name:text-is("label 8")');
  // Slices have the labels' contours and names.
  await page.waitForFunction(() => [...document.querySelectorAll(".slice-view")]
    .every((one) => /: 3, label 8\. Click/.test(one.getAttribute("aria-label"))), null, { timeout: patience });
  await examine(page);
  await page.click('summary:has-text("Surfaces")');
  await page.click('button:text-is("Add a surface")');
  await page.waitForFunction(() => document.querySelectorAll(".surface-row").length === 2 && /surfaces=/.test(location.hash));
  await settled(page);
  const opened = page.url();
  await open(page, opened.slice(opened.indexOf("#")), series);
  await settled(page);
  assert.equal(page.url(), opened);
  assert.equal(await page.textContent(".labels-count"), "24 of 300 shown");
  await page.selectOption('[aria-label="Labels beside the surfaces"]', "");
  await page.waitForFunction(() => !/labels=/.test(location.hash));
  assert.equal(await page.locator(".surface-row").count(), 2);
  // Labels that are shown alone get the image.
  await open(page, "#dataset=hundreds&labels=2,9&axes=false", series);
  await settled(page);
  await page.click('button:has-text("Add a surface of stain")');
  await page.waitForFunction(() => /dataset=stain&labels=hundreds:2,9&/.test(location.hash));
  await settled(page);
  assert.deepEqual(await page.locator(".labels-count").first().textContent(), "2 of 300 shown");
  assert.equal(await page.inputValue('[aria-label="Labels beside the surfaces"]'), "hundreds");
  await page.click('[aria-label="Remove surface 1"]');
  await page.waitForFunction(() => /dataset=hundreds.label1&labels=2,9/.test(location.hash));
}

async function findsLabels(page) {
  await open(page, "#dataset=cells&axes=false", series);
  await complete(page);
  await settled(page);
  const names = () => page.locator(".label-row:not([hidden]) .label-name").allTextContents();
  assert.equal((await names()).length, 30);
  assert.match(await page.textContent(".labels-count"), /^24 of 30 shown$/);
  assert.match(await page.getAttribute('.label-name:text-is("label 17")', "title"), /^label 17: \d+ samples$/);
  await page.selectOption('[aria-label="Order of the labels"]', "size");
  assert.equal((await names())[0], "label 17", "the largest one is the first");
  await page.fill('[aria-label="Search labels"]', "17");
  assert.deepEqual(await names(), ["label 17"]);
  await page.click('.label-name:text-is("label 17")');
  await page.waitForFunction(([x, y, z]) => {
    const [a, b, c] = (new URLSearchParams(location.hash.slice(1)).get("target") ?? "").split(",").map(Number);
    return Math.hypot(a - x, b - y, c - z) < 0.1;
  }, cellAt(17), { timeout: patience });
  const canvas = await page.locator(".stage canvas").boundingBox();
  await page.mouse.move(canvas.x + canvas.width / 2, canvas.y + canvas.height / 2);
  await page.waitForFunction(() => document.querySelector(".label-hover:not([hidden])")?.textContent === "label 17", null, { timeout: patience });
  await page.fill('[aria-label="Search labels"]', "no such label");
  assert.deepEqual(await names(), []);
  await page.click('.labels-head button:has-text("All")');
  await settled(page);
  await page.waitForFunction(() => /6 more surfaces were checked in the same way/.test(document.querySelector(".certificate").textContent));
  assert.equal(await page.locator(".certificate h3").count(), 24);
}

async function savesTable(page) {
  await open(page, "#dataset=seg", series);
  await complete(page);
  await settled(page);
  const rows = await tableOf(page);
  assert.deepEqual(rows.map(([label]) => label), ["2", "5", "9"]);
  for (const [, , samples, samplesVolume, volume, bound] of rows) {
    const ball = (4 / 3) * Math.PI * 5.2 ** 3;
    assert(Math.abs(Number(volume) - ball) < Number(bound) + 0.1 * ball, `${volume} ± ${bound} of ${ball}`);
    assert.equal(samples, samplesVolume, "a sample has volume 1");
  }
  await page.evaluate(() => (location.hash = "#dataset=seg&labels=2,9"));
  await complete(page);
  await settled(page);
  const [first, hidden, last] = await tableOf(page);
  for (const [i, one] of [first, hidden, last].entries()) assert.deepEqual(one.slice(0, 4), rows[i].slice(0, 4), "the samples");
  assert.deepEqual([first, hidden, last].map(([, , , , volume]) => volume !== ""), [true, false, true], "not of the hidden surface");
}

async function savesSimplified(page) {
  await open(page, "#dataset=seg&axes=false&error=0.5", series);
  await complete(page);
  await settled(page);
  await page.click('summary:has-text("Export")');
  const trianglesOf = async () => {
    const [download] = await Promise.all([page.waitForEvent("download", { timeout: patience }), page.click('button:text-is("GLB")')]);
    const bytes = readFileSync(await download.path());
    const { accessors, nodes } = JSON.parse(bytes.toString("utf8", 20, 20 + bytes.readUInt32LE(12)));
    assert.deepEqual(nodes.map(({ name }) => name), ["label 2", "label 5", "label 9"]);
    return accessors.filter(({ type }) => type === "SCALAR").reduce((sum, { count }) => sum + count / 3, 0);
  };
  const simplified = await trianglesOf();
  await notice(page, /^Saved [\d\s]+ triangles\.$/);
  await page.evaluate(() => (location.hash = `${location.hash}&simplify=false`));
  await settled(page);
  await page.waitForTimeout(500);
  const shown = await trianglesOf();
  assert(simplified < shown / 2, `${simplified} of ${shown} triangles`);
}

async function noticesNewDatasets(page) {
  await open(page, "#dataset=stain&axes=false&labels=later:", series);
  await settled(page);
  const beside = () => page.textContent('[aria-label="Labels beside the surfaces"] option:checked');
  assert.equal(await beside(), "later: not on this server yet");
  run("prepare", path.join(scratch, "seg.nrrd"), "--label", "all", "--name", "later", "-o", path.join(folder, "later"));
  series.process.kill("SIGHUP");
  await page.waitForFunction(() => document.querySelector(".labels-count").textContent === "3 of 3 shown", null, { timeout: patience });
  assert.equal(await beside(), "later (3)");
  await settled(page);
  await page.waitForFunction(() => /[&#]labels=later:2-9(&|$)/.test(location.hash));
}

// Sets labels by messages; `shown` events have the visible ones, at their places.
async function replacesLabels(page) {
  const around = `${series.page}around.html`;
  await page.route(around, (route) => route.fulfill({ contentType: "text/html", body:
    '<title>around</title><iframe src="/?embed#dataset=seg&labels=5&follow_view=false" width="700" height="500"></iframe>' }));
  await page.goto(around);
  await page.evaluate(() => {
    const viewer = document.querySelector("iframe").contentWindow;
    window.heard = [];
    window.addEventListener("message", ({ data }) => window.heard.push(data));
    window.say = (message) => viewer.postMessage(message, location.origin);
    window.asking = setInterval(() => window.say({ multitetra: "get", id: "first" }), 300);
  });
  const set = async (state, places) => {
    await page.evaluate((words) => {
      window.heard.splice(0);
      window.say({ multitetra: "set", id: "set", state: words });
    }, state);
    await page.waitForFunction((all) => all.every((at) => window.heard.some(({ surface, isFinal }) => surface === at && isFinal)), places, { timeout: patience });
    const heard = await page.evaluate(() => window.heard);
    const shown = heard.filter(({ multitetra }) => multitetra === "shown").map(({ surface }) => surface);
    const { state: { dataset, visible, surfaces, isovalue, color, labels } } = heard.find(({ id }) => id === "set");
    return { shown: [...new Set(shown)].sort(), dataset, isovalue, color, labels, visible: [visible, ...surfaces.map((one) => one.visible)] };
  };
  await page.waitForFunction(() => window.heard.some(({ surface, isFinal }) => surface === 1 && isFinal), null, { timeout: patience });
  await page.evaluate(() => clearInterval(window.asking));
  assert.deepEqual(await page.evaluate(() => window.heard.filter(({ surface }) => surface === 0)), [], "the first one is hidden");
  const two = await set({ labels: "2,9" }, [0, 2]);
  assert.deepEqual(two, { shown: [0, 2], dataset: "seg.label2", isovalue: 0.5, color: two.color, labels: "", visible: [true, false, true] });
  const { surfaces } = await page.evaluate(() => window.heard.find(({ id }) => id === "set").state);
  assert.deepEqual((await set({ surfaces: [surfaces[1]] }, [1])).shown, [1], "the label that moved is reported at its place");
  const other = await set({ dataset: "flow" }, [0]);
  assert.deepEqual(other, { shown: [0], dataset: "flow", isovalue: null, color: "#e0cdb4", labels: "", visible: [true] });
  assert.deepEqual((await set({ labels: "9", dataset: "seg" }, [2])).visible, [false, false, true]);
}

// Such as another channel: with its suggested isovalue, at the same time.
async function overlays(page) {
  await open(page, "#dataset=flow&isovalue=0.5&error=2&occlusion=false&t=1", series);
  await complete(page);
  await page.click('summary:has-text("Surfaces")');
  await page.click('button:has-text("Add a surface")');
  assert(await page.locator('select[aria-label="Data of surface 1"]').isHidden());
  await page.selectOption('select[aria-label="Data of surface 2"]', { label: "heat" });
  await page.waitForFunction(() => /surfaces=[^&]*,flow\.heat[^&]*/.test(location.hash));
  await page.waitForFunction(() => /triangles/.test(document.querySelectorAll(".surface-state")[1]?.textContent), null, { timeout: patience });
  assert.equal(await page.textContent(".times .time"), "1 s");
  await page.locator(".times input").fill("0");
  await settled(page);
  assert.equal(await page.locator('select[aria-label="Data of surface 2"] option:checked').textContent(), "heat", "at all times");
  await page.selectOption('select[aria-label="Data of surface 2"]', { label: "The same data" });
  await page.waitForFunction(() => /surfaces=/.test(location.hash) && !location.hash.includes("heat"));
  const isovalue = await page.evaluate(() => parseFloat(/surfaces=([^,]*)/.exec(location.hash)[1]));
  assert.notEqual(isovalue, 0.5, "not that of the first surface");
}

async function playsTimes(page) {
  await open(page, "#dataset=flow&isovalue=0.5&error=1&occlusion=false&speed=20", series);
  const first = await complete(page);
  assert.equal(await page.textContent(".times .time"), "0 s");
  assert.match(await page.textContent('.dataset[aria-pressed="true"]'), /4 times, 2 fields/);
  await page.click('summary:has-text("Color by a field")');
  await page.selectOption('select[aria-label="Color the surfaces by"]', { label: "heat" });
  await page.waitForSelector(".legend:not([hidden])");
  await complete(page);
  await examine(page);
  await page.focus(".stage canvas");
  await page.keyboard.press(" ");
  for (const time of ["0.5 s", "1.5 s", "0 s"]) {
    await page.waitForFunction((text) => document.querySelector(".times .time").textContent === text, time, { timeout: patience, polling: 10 });
  }
  await page.keyboard.press(" ");
  await page.waitForFunction(() => location.hash.includes("&t=") && !location.hash.includes("playing"));
  await page.keyboard.press(".");
  await page.locator(".times input").fill("0");
  const again = await complete(page, ({ digest }) => digest === first.digest);
  assert.equal(again.triangles, first.triangles);
  assert.match(await page.evaluate(() => location.hash), /isovalue=0\.5/);
}

// Two surfaces, one of which grows with time: both rows of facts must belong to the same time.
async function showsOneTime(page) {
  const state = "isovalue=0.5&error=1&simplify=false&occlusion=false&surfaces=0.8,7fb3d5&speed=30&playing=true";
  await open(page, `#dataset=flow&${state}`, series);
  await page.waitForFunction(() => document.querySelector(".times .pace")?.textContent.endsWith(" of"), null, { timeout: patience });
  const together = await page.evaluate(async () => {
    const seen = new Set();
    for (let frame = 0; frame < 60; ++frame) {
      await new Promise(requestAnimationFrame);
      const [first, second] = [...document.querySelectorAll(".surface-state")].map(({ textContent }) => parseInt(textContent.replace(/\D/g, "")));
      seen.add(`${first} ${second}`);
    }
    return seen.size;
  });
  assert(together >= 2 && together <= 4, `${together} pairs of surfaces were seen of 4 times`);
}

async function savesTimes(page) {
  await open(page, "#dataset=flow&isovalue=0.5&error=2&occlusion=false&axes=false&t=1&eye=16,-120,16&target=16,16,16", series);
  await complete(page);
  await page.click('summary:has-text("Export")');
  const [download] = await Promise.all([
    page.waitForEvent("download", { timeout: patience }),
    page.click('button:has-text("Times: PNGs")'),
  ]);
  const bytes = readFileSync(await download.path());
  const frames = storedFiles(bytes);
  assert.deepEqual(frames.map(({ name }) => name), ["time_0000.png", "time_0001.png", "time_0002.png", "time_0003.png"]);
  const seen = [];
  for (const { content } of frames) seen.push(await page.evaluate(lookAt, content.toString("base64")));
  for (const [i, { share, words }] of seen.entries()) {
    assert(i === 0 || share > 1.1 * seen[i - 1].share, `the ball grows from frame to frame: ${seen.map((one) => one.share)}`);
    assert(words !== "" && seen.every((other, at) => at === i || other.words !== words), "each frame has its time written on it");
  }
  await page.waitForFunction(() => document.querySelector(".times .time").textContent === "1 s" && /[&#]t=1(&|$)/.test(location.hash), null, { timeout: patience });
}

// Each time is visible for equally long, however long it took to arrive.
async function savesVideo(page) {
  await open(page, "#dataset=flow&isovalue=0.5&error=2&occlusion=false&speed=2", series);
  await complete(page);
  await page.click('summary:has-text("Export")');
  const [download] = await Promise.all([
    page.waitForEvent("download", { timeout: patience }),
    page.click('button:has-text("Times: video")'),
  ]);
  const [, name, ending] = download.suggestedFilename().match(/^(.*)\.(mp4|webm)$/);
  assert.equal(name, "flow_ball_0.5");
  const bytes = readFileSync(await download.path()).toString("base64");
  const other = await page.context().browser().newPage(); // Without the viewer's content security policy.
  const { duration, isSeen } = await other.evaluate(async ([base64, type]) => {
    const video = document.createElement("video");
    video.src = `data:${type};base64,${base64}`;
    await new Promise((resolve, reject) => Object.assign(video, { onloadeddata: resolve, onerror: () => reject(new Error(video.error.message)) }));
    return { duration: video.duration, isSeen: video.videoWidth > 100 };
  }, [bytes, ending === "mp4" ? "video/mp4" : "video/webm"]);
  await other.close();
  assert(isSeen && Math.abs(duration - 2) < 0.01, `4 times at 2 a second take ${duration} s`);
  const eye = await (await page.waitForFunction(() => /eye=[^&]*/.exec(location.hash)?.[0])).jsonValue();
  await page.click('button:has-text("Turn: video")');
  await notice(page, /Filming: \d+ %/);
  await page.focus(".stage canvas");
  await page.keyboard.press("Escape");
  await notice(page, /Filming was canceled/);
  await page.waitForFunction((before) => location.hash.includes(before), eye); // The camera is back.
}

// The samples of one time are damaged on disk: no frame shows another time in its place.
async function failsAFilm(page) {
  const damaged = path.join(scratch, "damaged");
  rmSync(damaged, { recursive: true, force: true });
  cpSync(folder, damaged, { recursive: true });
  const other = await serveFolder(damaged);
  const file = path.join(damaged, "flow.ball.t0003.mtd");
  const bytes = readFileSync(file);
  writeFileSync(file, bytes.fill(0x55, Math.round(0.2 * bytes.length), Math.round(0.8 * bytes.length)), { flag: "r+" });
  await open(page, "#dataset=flow&isovalue=0.5&error=2&occlusion=false&t=1", other);
  await complete(page);
  await page.click('summary:has-text("Export")');
  await page.click('button:has-text("Times: PNGs")');
  await notice(page, /Recording failed: the surface at 1\.5 s was not received/);
  await page.waitForFunction(() => document.querySelector(".times .time").textContent === "1 s", null, { timeout: patience });
}

// Reads a ZIP archive with uncompressed files by its directory at the end.
function storedFiles(bytes) {
  const files = [];
  let at = bytes.readUInt32LE(bytes.lastIndexOf("PK\x05\x06", undefined, "latin1") + 16);
  while (bytes.readUInt32LE(at) === 0x02014b50) {
    const [size, nameSize, extra, comment, begin] = [bytes.readUInt32LE(at + 24), ...[28, 30, 32].map((k) => bytes.readUInt16LE(at + k)), bytes.readUInt32LE(at + 42)];
    const from = begin + 30 + bytes.readUInt16LE(begin + 26) + bytes.readUInt16LE(begin + 28);
    files.push({ name: bytes.toString("latin1", at + 46, at + 46 + nameSize), content: bytes.subarray(from, from + size) });
    at += 46 + nameSize + extra + comment;
  }
  return files;
}

// The fraction of a picture with a surface's color, and the pixels at the upper left that are not background.
async function lookAt(data) {
  const image = new Image();
  image.src = `data:image/png;base64,${data}`;
  await image.decode();
  const context = new OffscreenCanvas(image.width, image.height).getContext("2d");
  context.drawImage(image, 0, 0);
  const rgba = context.getImageData(0, 0, image.width, image.height).data;
  let count = 0;
  for (let i = 0; i < rgba.length; i += 4) if (rgba[i] > 80 && rgba[i] > rgba[i + 2] + 15) ++count;
  const corner = context.getImageData(0, 0, 120, 40).data;
  const inked = [...corner.keys()].filter((i) => i % 4 === 0 && Math.abs(corner[i] - corner[0]) > 60);
  return { share: (4 * count) / rgba.length, words: inked.join() };
}

async function leavesRoom(page) {
  await open(page, "#dataset=flow&isovalue=0.5&error=2&occlusion=false", series);
  await complete(page);
  const [stage, times, ...corners] = await page.evaluate(() =>
    [".stage", ".times", ".scale-bar", ...[1, 2, 3, 4, 5, 6].map((n) => `.orientation .end:nth-of-type(${n})`)]
      .flatMap((one) => [...document.querySelectorAll(one)].map((found) => found.getBoundingClientRect().toJSON())));
  assert(times.bottom <= stage.bottom && times.top > stage.bottom - 0.25 * stage.height, "the times lie at the lower edge");
  for (const corner of corners) assert(corner.bottom <= times.top, "nothing lies below the times");
}

async function showsHundreds(page) {
  const requests = []; // The requests on the connection for coarse previews.
  page.on("websocket", (socket) => {
    const sent = [];
    socket.on("framesent", ({ payload }) => {
      sent.push(payload);
      if (sent.length === 1 && payload.includes("previews")) requests.push(sent);
    });
  });
  await open(page, "#dataset=hundreds&labels=1-300&axes=false", series);
  await page.waitForFunction(() => document.querySelector(".fact.triangles span")?.textContent.endsWith("of 300 surfaces"), null, { timeout: patience });
  assert.equal(requests.length, 1);
  assert(requests[0].length < 6, `${requests[0].length} messages for the previews of 300 labels`);
  await page.click('[aria-label="Show only label 9"]');
  await page.waitForFunction(() => document.querySelector(".labels-count").textContent === "1 of 300 shown");
  await settled(page);
}

// Waits until no surface is loading.
function settled(page) {
  return page.waitForFunction(() => document.querySelectorAll(".label-row.is-coming").length === 0 &&
    document.querySelector(".state b")?.textContent === "Complete", null, { timeout: patience });
}

// Three balls in a row.
function prepareLabels() {
  const balls = [[2, 6], [5, 16], [9, 26]];
  const labelAt = (x, y, z) => balls.find(([, at]) => Math.hypot(x - at, y - 16, z - 16) < 5.2)?.[0] ?? 0;
  const file = path.join(scratch, "seg.nrrd");
  writeNrrd(file, size, Uint8Array.from(samplesOf(size, labelAt)), unitSpace);
  run("prepare", file, "--label", "all", "--name", "seg", "-o", folder);
}

// The center of the ball of a label from 1 to 30.
function cellAt(label) {
  const i = label - 1;
  return [4 + 6 * (i % 5), 6 + 10 * (Math.floor(i / 5) % 3), 10 + 12 * Math.floor(i / 15)];
}

// Thirty small balls; the seventeenth is larger.
function prepareCells() {
  const balls = Array.from({ length: 30 }, (_, i) => [i + 1, ...cellAt(i + 1), i + 1 === 17 ? 2.9 : 2.2]);
  const labelAt = (x, y, z) => balls.find(([, a, b, c, radius]) => Math.hypot(x - a, y - b, z - c) < radius)?.[0] ?? 0;
  const file = path.join(scratch, "cells.nrrd");
  writeNrrd(file, size, Uint8Array.from(samplesOf(size, labelAt)), unitSpace);
  run("prepare", file, "--label", "all", "--name", "cells", "-o", folder);
}

// Three hundred balls, and an image on their grid: the place along x.
function prepareHundreds() {
  const [side, pitch] = [42, 6];
  const labelAt = (...place) => {
    const [x, y, z] = place.map((v) => Math.floor(v / pitch));
    const label = 1 + x + 7 * (y + 7 * z);
    return label <= 300 && Math.hypot(...place.map((v) => (v % pitch) - 2.5)) < 2.4 ? label : 0;
  };
  const file = path.join(scratch, "hundreds.nrrd");
  writeNrrd(file, side, Uint16Array.from(samplesOf(side, labelAt)), unitSpace);
  run("prepare", file, "--label", "all", "--name", "hundreds", "-o", folder);
  const image = path.join(scratch, "stain.nrrd");
  writeNrrd(image, side, Float32Array.from(samplesOf(side, (x) => x)), unitSpace);
  run("prepare", image, "-o", path.join(folder, "stain.mtd"));
}

// A growing ball, and another field in the same place, at four times.
function prepareTimes() {
  const files = [0, 1, 2, 3].map((time) => {
    const file = path.join(scratch, `flow_${time}.vti`);
    const ball = samplesOf(size, (x, y, z) => 1.5 - Math.hypot(x - 16, y - 16, z - 16) / (7 + 2 * time));
    const heat = samplesOf(size, (x, y) => (x + y) * (1 + time));
    writeVti(file, size, { ball, heat });
    return file;
  });
  run("prepare", ...files, "--time-series", "flow", "--field", "all", "--times", "0:0.5", "--time-unit", "s", "-o", folder);
}
