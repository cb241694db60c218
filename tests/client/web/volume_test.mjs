// The volume in the viewer, compared with numbers: the largest value along axes, and silhouettes of surfaces.
//
//   node volume_test.mjs SERVER_PROGRAM VIEWER_FOLDER SCRATCH_FOLDER
import assert from "node:assert/strict";
import { mkdirSync, rmSync, writeFileSync } from "node:fs";
import path from "node:path";

import { examine } from "./axe.mjs";
import { complete, finish, newToken, open, run, savedPicture, scratch, serveFolder, test } from "./in_a_browser.mjs";
import { samplesOf, unitSpace, writeNrrd } from "./made_volumes.mjs";

const size = 33;
const middle = (size - 1) / 2;
const folder = path.join(scratch, "volumes");
rmSync(folder, { recursive: true, force: true });
mkdirSync(folder, { recursive: true });
const noise = Uint8Array.from(samplesOf(size, (x, y, z) => 40 + Math.floor(170 * fraction(Math.sin(x * 12.9898 + y * 78.233 + z * 37.719) * 43758.5453))));
const shells = samplesOf(size, (x, y, z) => 1000 * Math.exp(-((Math.hypot(x - middle, y - middle, z - middle) / 9) ** 2)) + 40 * Math.cos(x / 3) * Math.sin(y / 2));
write("noise", noise);
write("blob", shells);
prepareParts();
const volumes = await serveFolder(folder);

for (const axis of [0, 1, 2]) await test(`Volume.MaximumAlong${"XYZ"[axis]}IsThatOfTheSamples`, (page) => comparesMaximum(page, axis));
await test("Volume.AStepHasTheSilhouetteOfTheSurface", comparesSilhouettes);
await test("Volume.EndsAtOpaqueSurfacesAndShowsThroughTranslucentOnes", comparesOrder);
await test("Volume.IsCutByClipAndCrop", isCut);
await test("Volume.LabelsColorItAndHiddenOnesAreTransparent", showsLabels);
await test("Volume.ReturnsWithALostContext", returns);
await test("Volume.OpacitiesAreEditedInThePanel", edits);
await test("Volume.IsRefusedWithSurfacesOnly", isRefused);
await finish();

// ----

// The picture has eight pixels a sample, and each sample is in the middle of one.
async function comparesMaximum(page, axis) {
  const { width, height, rgba } = await picture(page, axis, 8, "dataset=noise&volume=maximum&visible=false&level=127.5&window_width=255");
  const [right, down] = sidesOf(axis);
  for (let j = 1; j < size - 1; ++j) {
    for (let i = 1; i < size - 1; ++i) { // Rays through samples on the border may miss the data.
      let largest = 0;
      for (let k = 0; k < size; ++k) {
        const index = [0, 0, 0];
        index[axis] = k;
        index[right.axis] = right.sign > 0 ? i : size - 1 - i;
        index[down.axis] = down.sign > 0 ? j : size - 1 - j;
        largest = Math.max(largest, noise[index[0] + size * (index[1] + size * index[2])]);
      }
      const at = 4 * (width * (Math.floor(height / 2) + 8 * (j - middle)) + Math.floor(width / 2) + 8 * (i - middle));
      const color = [...rgba.subarray(at, at + 3)];
      assert.ok(color.every((value) => Math.abs(value - largest) <= 1), `at ${i}, ${j}: ${color} is ${largest}`);
    }
  }
}

async function comparesSilhouettes(page) {
  const of = (what) => picture(page, 1, 12, `dataset=blob&isovalue=300&error=0&${what}`);
  const none = await of("visible=false");
  const surface = shownIn(await of("visible=true"), none);
  const volume = shownIn(await of("visible=false&volume=on&opacities=300:0,300:1&volume_shading=false&level=0&window_width=1"), none);
  assert.ok(count(surface) > 5000, `the surface is seen: ${count(surface)} pixels`);
  const isWithin = (one, other) => one.every((is, at) => !is || isNear(other, at, none.width));
  assert.ok(isWithin(surface, volume), "the volume covers the surface's silhouette within a pixel");
  assert.ok(isWithin(volume, surface), "the surface covers the volume's silhouette within a pixel");
}

async function comparesOrder(page) {
  const of = (what) => picture(page, 1, 12, `dataset=blob&isovalue=300&${what}`);
  const inside = "volume=on&opacities=600:0,600:1";
  const [none, opaque, covered] = [await of("visible=false"), await of("opacity=1"), await of(inside)];
  const surface = shownIn(opaque, none);
  const within = surface.map((is, at) => is && [-3, 3].every((by) => surface[at + by] && surface[at + by * none.width]));
  assert.ok(largestDifference(opaque, covered, within) <= 4, "an opaque surface hides what is inside");
  const [glass, through] = [await of("opacity=0.3"), await of(`opacity=0.3&${inside}`)];
  assert.ok(largestDifference(glass, through, within) > 40, "it is seen through a translucent one");
  const outside = "opacity=0.3&volume=on&opacities=150:0,150:1,250:1,250:0";
  const [fog, red] = [await of(outside), await of(`${outside}&color=ff0000`)];
  assert.ok(largestDifference(fog, red, within) <= 4, "opaque parts in front hide a translucent surface");
}

async function isCut(page) {
  const of = (what) => picture(page, 1, 12, `dataset=blob&visible=false&opacities=300:0,300:1&filled=false&${what}`);
  const none = await of("volume=off");
  const whole = count(shownIn(await of("volume=on"), none));
  const half = count(shownIn(await of("volume=on&clip=x&clip_at=0.5"), none));
  const quarter = count(shownIn(await of(`volume=on&crop=0,0,0,${middle},32,${middle}`), none));
  assert.ok(Math.abs(half / whole - 0.5) < 0.05, `${half} of ${whole} pixels`);
  assert.ok(Math.abs(quarter / whole - 0.25) < 0.05, `${quarter} of ${whole} pixels`);
}

// Seen from the end of y, x grows to the left. The part above z = 24 has no label.
async function showsLabels(page) {
  const of = async (what, surfaces = ["ff0000,,,", "00ff00,,,"]) => {
    const labels = surfaces.map((look, at) => `0.5,${look},parts.label${at + 1}`).join(";");
    return picture(page, 1, 12, `dataset=blob&visible=false&volume=on&opacities=300:0,300:1&volume_shading=false&level=0&window_width=1&surfaces=${labels}&${what}`);
  };
  const none = await of("volume=off", ["ff0000,,,hidden", "00ff00,,,hidden"]);
  const seen = (shown) => {
    const mask = shownIn(shown, none);
    const { rgba, width } = shown;
    const counts = { red: 0, green: 0, white: 0, other: 0 };
    const places = { red: [Infinity, 0], green: [Infinity, 0] };
    mask.forEach((is, at) => {
      if (!is) return;
      const color = [...rgba.subarray(4 * at, 4 * at + 3)];
      const isNearly = (other) => color.every((value, i) => Math.abs(value - other[i]) <= 2);
      const name = Object.entries({ red: [255, 0, 0], green: [0, 255, 0], white: [255, 255, 255] }).find(([, other]) => isNearly(other))?.[0] ?? "other";
      ++counts[name];
      if (name in places) places[name] = [Math.min(places[name][0], at % width), Math.max(places[name][1], at % width)];
    });
    return { ...counts, places };
  };
  const plain = seen(await of("volume_labels=off&labels=none", []));
  const both = seen(await of("volume_labels=color"));
  assert.ok(both.red > 5000 && both.green > 5000 && both.white > 500, `both labels and the rest: ${JSON.stringify(both)}`);
  assert.ok(both.other < 0.06 * plain.white, `edges alone have other colors: ${JSON.stringify(both)}`);
  assert.ok(Math.abs(both.red + both.green + both.white + both.other - plain.white - plain.other) <= 0.01 * plain.white, "the silhouette is that of the volume");
  assert.ok(both.places.green[1] < both.places.red[0] && both.places.red[0] - both.places.green[1] <= 3, `nearest samples: ${JSON.stringify(both.places)}`);
  const only = seen(await of("volume_labels=only"));
  assert.ok(only.white === 0 && only.red >= both.red && only.green >= both.green, `without the rest: ${JSON.stringify(only)}`);
  for (const mode of ["color", "only"]) {
    const hidden = seen(await of(`volume_labels=${mode}`, ["ff0000,,,", "00ff00,,,hidden"]));
    assert.ok(hidden.green === 0 && hidden.red >= both.red, `without the hidden label: ${JSON.stringify(hidden)}`);
  }
}

async function returns(page) {
  const before = await picture(page, 1, 12, "dataset=blob&visible=false&volume=on&opacities=300:0,300:1");
  await page.evaluate(async () => {
    const context = document.querySelector(".stage canvas").getContext("webgl2").getExtension("WEBGL_lose_context");
    context.loseContext();
    await new Promise((resolve) => setTimeout(resolve, 200));
    context.restoreContext();
    await new Promise((resolve) => setTimeout(resolve, 200));
  });
  const after = await savedPicture(page);
  assert.ok(largestDifference(before, after, new Array(before.rgba.length / 4).fill(true)) <= 2, "the picture is the same");
}

async function edits(page) {
  await open(page, "#dataset=noise&visible=false", volumes);
  await page.click("summary:text-is('Volume')");
  await page.click("button:text-is('Fluorescence')");
  await page.waitForFunction(() => /volume=on/.test(location.hash));
  const points = page.locator(".opacity-point");
  assert.equal(await points.count(), 2);
  await points.nth(1).focus();
  await page.keyboard.press("ArrowLeft");
  await page.waitForFunction(() => /opacities=[^&]*,/.test(location.hash));
  const plot = await page.locator(".opacities").boundingBox();
  await page.mouse.click(plot.x + plot.width / 2, plot.y + 5);
  assert.equal(await points.count(), 3, "a click adds a point");
  await examine(page);
  await page.keyboard.press("Delete");
  await page.keyboard.press("Control+z");
  await points.nth(1).dblclick();
  assert.equal(await points.count(), 2, "a double click removes it");
  await page.click("button:text-is('Maximum') >> nth=0");
  await page.waitForFunction(() => /volume=maximum/.test(location.hash));
}

async function isRefused(page) {
  const tokens = path.join(scratch, "tokens");
  writeFileSync(tokens, "");
  const token = newToken("guest", tokens);
  const surfacesOnly = await serveFolder(folder, "--tokens", tokens, "--surfaces-only");
  await open(page, `#dataset=blob&volume=on&token=${token}`, surfacesOnly);
  await complete(page);
  const section = page.locator("details", { has: page.locator("summary:text-is('Volume')") });
  assert.match(await section.locator("p.hint:visible").first().textContent(), /surfaces only/);
  assert.equal(await section.locator(".opacity-point:visible").count(), 0);
}

// ----

function write(name, samples) {
  const file = path.join(scratch, `${name}.nrrd`);
  writeNrrd(file, size, samples, unitSpace);
  run("prepare", file, "--name", name, "-o", path.join(folder, `${name}.mtd`));
}

// The blob's lower part in two labels.
function prepareParts() {
  const parts = Uint8Array.from(samplesOf(size, (x, y, z) => (shells[x + size * (y + size * z)] > 100 && z < 24 ? (x < middle ? 1 : 2) : 0)));
  const file = path.join(scratch, "parts.nrrd");
  writeNrrd(file, size, parts, unitSpace);
  run("prepare", file, "--label", "all", "-o", folder);
}

function fraction(value) {
  return value - Math.floor(value);
}

// The world axes to the right and down of the picture, seen from the positive end of `axis`.
function sidesOf(axis) {
  return [
    [{ axis: 1, sign: 1 }, { axis: 2, sign: -1 }],
    [{ axis: 0, sign: -1 }, { axis: 2, sign: -1 }],
    [{ axis: 0, sign: 1 }, { axis: 1, sign: -1 }],
  ][axis];
}

// Returns the complete scene in a parallel projection along an axis, with `zoom` pixels a sample; the sample in the middle of
// the data is in the middle of a pixel.
async function picture(page, axis, zoom, settings) {
  if (!page.url().startsWith(volumes.page)) await open(page, "", volumes);
  const scene = await page.locator(".stage canvas").boundingBox();
  const distance = scene.height / zoom / 2 / Math.tan((35 / 2 / 180) * Math.PI);
  const target = [middle, middle, middle];
  sidesOf(axis).forEach(({ axis: side, sign }, at) => (target[side] -= (sign * ([scene.width, scene.height][at] % 2 === 0 ? 0.5 : 0)) / zoom));
  const eye = [...target];
  eye[axis] += distance;
  const view = `projection=orthographic&axes=false&occlusion=false&eye=${eye}&target=${target}&up=${axis === 2 ? "y" : "z"}`;
  await page.evaluate((hash) => (location.hash = hash), `${settings}&${view}&follow_view=false`);
  await page.waitForFunction(() => document.querySelector(".dataset"));
  return savedPicture(page);
}

// Above the legend, returns which pixels differ.
function shownIn({ rgba, width, height }, none) {
  return Array.from({ length: width * (height - 60) }, (_, at) => [0, 1, 2].some((i) => Math.abs(rgba[4 * at + i] - none.rgba[4 * at + i]) > 12));
}

function count(mask) {
  return mask.filter(Boolean).length;
}

function isNear(mask, at, width) {
  return [-1, 0, 1].some((dy) => [-1, 0, 1].some((dx) => mask[at + dy * width + dx]));
}

function largestDifference(one, other, mask) {
  return one.rgba.reduce((most, value, at) => (mask[at >> 2] ? Math.max(most, Math.abs(value - other.rgba[at])) : most), 0);
}
