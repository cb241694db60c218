// The viewer in a real browser, against a real server: what a user sees.
//
//   node browser_test.mjs SERVER_PROGRAM VIEWER_FOLDER SCRATCH_FOLDER
import assert from "node:assert/strict";
import { mkdirSync, readFileSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import path from "node:path";

import {
  atKeyboard, complete, finish, notice, open, patience, run, scratch, serveFolder, server, surfacePixels, test,
} from "./in_a_browser.mjs";
import { samplesOf, writeNrrd } from "./made_volumes.mjs";

const moving = { reducedMotion: "no-preference" }; // As most users have it: the camera swings out.

await test("ShowsAndChecksASurface", showsASurface, { isFresh: true });
await test("ReceivesSamplesForSmallErrors", receivesSamples);
await test("ShowsDataWithNearlyRectangularAxes", showsRoundedAxes);
await test("KeepsASurfaceWhileDraggingTheIsovalue", followsADrag, moving);
await test("ControlsKeepTheirPositions", keepsItsControls);
await test("RefinesADraggedRegion", refinesARegion, moving);
await test("ShowsTheEstimatedSize", showsSizes);
await test("KeysChangeTheAddress", pressesKeys);
await test("ClipsTheSurface", clips);
await test("CropsToABox", crops);
await test("HandlesMoveAndRotateTheCut", dragsTheCut, moving);
await test("SavesFilesAndPictures", savesFiles);
await test("ResumesAfterAServerRestart", resumes);
await test("ReportsUnknownDatasets", reportsUnknownDataset);
await test("ReportsEmptySurfaces", reportsEmptySurface);
await test("BackRestoresTheIsovalue", goesBack);
await test("ClicksBesideTheSurfaceKeepThePickedPlace", keepsAPlace);
await test("DragsOneOfSeveralIsovalues", showsSeveral);
await test("ShowsSurfacesOfTwoDatasets", showsTwoDatasets);
await test("MeasuresAPickedPart", measuresAPart);
await test("HidesSmallComponentsLikeTheCommandLine", hidesSmallComponents);
await test("CountsTheTrianglesOfVisibleSurfaces", countsTriangles, { isFresh: true });
await test("UndoesAndRestoresBookmarks", undoes);
await test("ColorsASurfaceByAnotherField", colorsByAField);
await test("ExchangesMessagesWithTheEmbeddingPage", exchangesMessages);
await test("RunsTheExampleOfTheGuide", runsTheExample);
await test("HidesToolsInLowFrames", hidesTools);
await test("ShowsSamplesAndTheirValuesOnAPlane", showsASlice);
await test("ShowsTomographyInItsWindows", showsTomography);
await test("LinksThreeSlicesByACrosshair", linksSlices);
await test("RefinesNearbySurfacesToAPixel", refinesWhatIsNear);
await test("FollowsTheViewByDefault", followsTheView);
await test("PausesDetailInViewOnSlowLinks", pausesDetail, { isFresh: true });
await test("NamesErrorsByQuality", namesQualities);
await test("HidesAClickedPart", hidesAPart);
await test("KeepsNotesInTheAddress", keepsNotes);
await test("FrontViewFollowsTheUpDirection", showsTheFront);
await test("RejectsColorsOfAnotherWorld", refusesOtherWorlds);
await test("NumbersOfAxesAreLegible", keepsNumbersLegible, { viewport: { width: 400, height: 800 }, hasTouch: true, isMobile: true });
await finish();

// ----

async function showsASurface(page) {
  await page.addInitScript(() => {
    window.states = [];
    new MutationObserver(() => {
      const [word, label] = ["b", "span"].map((part) => document.querySelector(`.state ${part}`)?.textContent);
      if (word && word !== window.states.at(-1)?.[0]) window.states.push([word, label]);
      else if (word) window.states.at(-1)[1] = label;
    }).observe(document, { subtree: true, childList: true, characterData: true });
  });
  await open(page, "#dataset=head");
  const shown = await complete(page);
  const states = await page.evaluate(() => window.states);
  const loading = states.slice(states.findIndex(([word]) => word === "First preview…"));
  const steps = ["First preview…", "Refining…", "Complete"];
  assert.deepEqual(loading.map(([word]) => word).filter((word) => steps.includes(word)), steps, JSON.stringify(states));
  assert.match(loading.at(-1)[1], /^within [\d.]+ mm$/);
  const facts = await page.locator(".bar .facts .fact").evaluateAll((all) => all.map(({ classList }) => classList[1]));
  assert.deepEqual(facts, ["state", "error", "triangles"]);
  assert(await page.locator(".fact.bytes").count() === 1 && await page.isHidden(".certificate .fact.bytes"), "the rest is in the certificate");
  assert(shown.triangles > 100, `${shown.triangles} triangles`);
  assert((await surfacePixels(page)).share > 0.03, "a surface fills a part of the picture");
  await page.click(".seal");
  const certificate = await page.textContent(".certificate");
  assert.match(certificate, /Cracks\s*none/);
  assert.match(certificate, /Guaranteed by the server.*that of the full-resolution surface/);
  assert.match(certificate, /[0-9a-f]{32}/);
  assert.match(certificate, /^Error ≤ [\d.]+ voxels? = [\d.]+ mm\. /, "the bound comes first");
  assert(await page.isVisible(".certificate .fact.bytes"));
  await page.keyboard.press("Escape");
  assert(await page.isHidden(".certificate"), "Escape closes it");
  await page.waitForFunction(
    () => document.querySelectorAll('.dataset img[src^="blob:"]').length === 2, null, { timeout: patience },
  );
}

// Below an error of one voxel the server sends samples, which the page triangulates; above it, simplified meshes.
async function receivesSamples(page) {
  const certificateAt = async (error, isIt) => {
    await open(page, `#dataset=head&isovalue=500.5&error=${error}`);
    const shown = await complete(page, isIt);
    await page.click(".seal");
    const text = await page.textContent(".certificate");
    await page.keyboard.press("Escape");
    return { shown, text };
  };
  const fine = await certificateAt(0.5);
  assert.match(fine.text, /Triangles generated\s*in this browser, from samples/);
  assert.match(fine.text, /Cracks\s*none/);
  assert((await surfacePixels(page)).share > 0.03, "a surface fills a part of the picture");
  const coarse = await certificateAt(3, (shown) => shown.digest !== fine.shown.digest);
  assert.match(coarse.text, /Triangles generated\s*by the server/);
  assert(coarse.shown.triangles < fine.shown.triangles, `${coarse.shown.triangles} triangles are fewer`);
}

async function followsADrag(page) {
  await open(page, "#dataset=head&isovalue=500.5");
  const before = await complete(page);
  const plot = await page.locator(".histogram-plot").boundingBox();
  const line = await page.locator(".isoline").boundingBox();
  const y = plot.y + plot.height / 2;
  const isFilled = async () => (await surfacePixels(page)).share > 0.01;
  await page.mouse.move(line.x + 1, y);
  await page.mouse.down();
  for (let i = 1; i <= 6; ++i) {
    await page.mouse.move(line.x + 1 + 8 * i, y);
    // A screenshot may fall between two frames of a busy browser; a lasting empty picture fails twice.
    assert((await isFilled()) || (await isFilled()), "something is shown at every moment of the drag");
  }
  await page.mouse.up();
  assert.match(await page.textContent(".histogram-value:not([hidden])"), /^\d+(\.5)?$/, "the value under the pointer");
  const isovalue = Number(await page.inputValue('[aria-label="Isovalue"]'));
  assert(isovalue > 500.5, `the isovalue is ${isovalue} now`);
  await page.waitForFunction((v) => location.hash.includes(`isovalue=${v}`), isovalue, { timeout: patience });
  const after = await complete(page, (shown) => shown.digest !== before.digest);
  assert.notEqual(after.triangles, before.triangles);
}

// Controls keep their positions while surfaces appear, change and vanish; only choices add or remove controls.
async function keepsItsControls(page) {
  await open(page, "#dataset=head&isovalue=500.5&error=0.5");
  await complete(page);
  await page.evaluate(() => {
    const tops = () => [...document.querySelectorAll(".panel :is(button, input, summary)")]
      .filter((one) => one.getClientRects().length > 0)
      .map((one) => `${one.getAttribute("aria-label") ?? one.textContent}: ${Math.round(one.getBoundingClientRect().top)}`)
      .join("\n");
    window.arrangements = new Set();
    window.states = new Set();
    const look = () => {
      window.states.add(document.querySelector(".state b").textContent);
      window.arrangements.add(tops());
      requestAnimationFrame(look);
    };
    look();
  });
  for (const isovalue of ["300.5", "1e6", "400.5"]) {
    const before = await page.textContent(".state");
    await page.fill('[aria-label="Isovalue"]', isovalue);
    await page.press('[aria-label="Isovalue"]', "Enter");
    await page.waitForFunction((old) => document.querySelector(".state").textContent !== old, before, { polling: 10, timeout: patience });
    await page.waitForFunction(() => /Complete|No surface/.test(document.querySelector(".state b").textContent), null, { timeout: patience });
  }
  assert.deepEqual([...await page.evaluate(() => [...window.arrangements])].slice(1), [], "there is one arrangement");
  assert((await page.evaluate(() => [...window.states])).every((state) => state !== "First preview…"), "a surface was shown before");
}

async function refinesARegion(page) {
  const size = 64;
  const view = `eye=32,-120,32&target=32,32,32`;
  await open(page, `#dataset=head&error=6&${view}&region=ball:32,32,32,8=1`);
  const before = await complete(page);
  const canvas = await page.locator(".stage canvas").boundingBox();
  const [x, y] = [canvas.x + canvas.width / 2, canvas.y + canvas.height / 2];
  await page.mouse.move(x, y);
  await page.mouse.down();
  await page.mouse.move(x + 50, y - 20, { steps: 4 });
  await page.mouse.up();
  // The address is updated with every mouse move; the final position is above the middle.
  await page.waitForFunction(() => {
    const ball = new URLSearchParams(location.hash.slice(1)).get("region")?.match(/ball:([^=]*)=/);
    return ball && Number(ball[1].split(",")[2]) > 32;
  }, null, { timeout: patience });
  const region = new URLSearchParams((await page.evaluate(() => location.hash)).slice(1)).get("region");
  const [cx, , cz] = region.match(/ball:([^=]*)=/)[1].split(",").map(Number);
  assert(cx > 33 && cx < size && cz > 32, `the ball went to the right and up: ${region}`);
  const after = await complete(page, (shown) => shown.digest !== before.digest);
  assert.notEqual(after.triangles, before.triangles);
}

async function showsSizes(page) {
  await open(page, "#dataset=head&error=1");
  const shown = await complete(page);
  await page.waitForFunction(() => /about/.test(document.querySelector(".expected").textContent));
  const words = await page.textContent(".expected");
  const [least, most] = words.match(/([\d\u202f]+) to ([\d\u202f]+) triangles/).slice(1).map((text) => Number(text.replace(/\D/g, "")));
  assert(least < shown.triangles && shown.triangles < most, `${words}; there are ${shown.triangles}`);
  const slider = page.getByRole("slider", { name: "Allowed error" });
  assert.match(await slider.getAttribute("aria-valuetext"), /^1 voxel\b/, "it is spoken");
  await slider.fill("0");
  await page.waitForFunction((before) => {
    const now = document.querySelector(".expected").textContent;
    return /about/.test(now) && now !== before;
  }, words);
  await slider.fill("0.5"); // Two voxels.
  await page.click('label:has-text("Simplify")');
  await page.waitForFunction(() => /simplify=false/.test(location.hash));
  await complete(page, ({ triangles }) => triangles > 1.25 * shown.triangles);
}

async function pressesKeys(page) {
  await open(page, "#dataset=gyroid");
  await complete(page);
  await page.focus(".stage canvas");
  const before = await page.screenshot();
  await page.keyboard.press("c");
  await page.keyboard.press("w");
  await page.waitForFunction(() => /coloring=tiles/.test(location.hash) && /wireframe=true/.test(location.hash));
  assert(!before.equals(await page.screenshot()), "the picture is another one");
  await page.keyboard.press("ArrowLeft");
  await page.waitForFunction(() => /eye=/.test(location.hash));
  await page.keyboard.press("?");
  const [help, panel] = [await page.textContent("dialog[open]"), await page.textContent(".panel")];
  for (const word of ["wireframe", "Zoom", "Pan", "undo, redo", "ambient occlusion", "reset view"]) assert(help.includes(word), `${word} is explained`);
  assert.match(panel, /Wireframe.*Ambient occlusion/);
  await page.keyboard.press("Escape");
  assert.equal(await page.locator("dialog[open]").count(), 0);
  await page.focus(".stage canvas");
  await page.keyboard.press("o");
  await page.waitForFunction(() => /occlusion=false/.test(location.hash));
  await page.keyboard.press("w");
  await changesMaterials(page);
}

// Each material gives another picture.
async function changesMaterials(page) {
  const clip = await page.locator(".stage canvas").boundingBox();
  const picture = async () => (await page.screenshot({ clip })).toString("base64");
  const pictures = [];
  for (const material of ["skin", "bone", "glossy", "matcap", "neutral", "bone"]) {
    await page.evaluate((word) => (location.hash = `${location.hash.replace(/&material=[^&]*/, "")}&material=${word}`), material);
    if (pictures.length === 0) await page.waitForTimeout(500); // The address rounds the camera.
    const isAgain = pictures.length === 5;
    const until = Date.now() + patience;
    let now;
    do now = await picture();
    while ((isAgain ? now !== pictures[1] : pictures.includes(now)) && Date.now() < until);
    assert.equal(pictures.indexOf(now), isAgain ? 1 : -1, `${material} has a picture of its own`);
    pictures.push(now);
  }
}

async function clips(page) {
  const view = "eye=16,-60,16&target=16,16,16&axes=false";
  await open(page, `#dataset=gyroid&${view}`);
  await complete(page);
  const whole = await surfacePixels(page);
  await page.click('summary:has-text("Clip and crop")');
  await page.locator('[aria-label="Clip"] button', { hasText: "x" }).click();
  await page.waitForFunction(() => /clip=x/.test(location.hash));
  const half = await surfacePixels(page);
  assert(half.share < 0.7 * whole.share && half.share > 0.2 * whole.share, `${half.share} of ${whole.share}`);
  // A click where the surface was cut away hits nothing; on the other side it returns the position.
  const canvas = await page.locator(".stage canvas").boundingBox();
  const click = (share) => page.mouse.click(canvas.x + share * canvas.width, canvas.y + canvas.height / 2);
  await click(0.42);
  await click(0.58);
  await page.waitForSelector(".picked:not([hidden])");
  assert.match(await page.textContent(".picked"), /A (LPS|world) .*Click another point/s);
  await page.focus(".picked .close");
  await page.keyboard.press("Enter");
  await page.waitForSelector(".picked", { state: "hidden" });
  assert.equal(await atKeyboard(page), "canvas");
}

// The box is in the address, its handles move it, what is hidden is not hit, and its faces show samples.
async function crops(page) {
  await open(page, "#dataset=head&error=2&axes=false&occlusion=false&eye=-60,-110,80&target=32,32,32");
  await complete(page);
  const whole = await surfacePixels(page);
  await page.click('summary:has-text("Clip and crop")');
  await page.locator('[aria-label="Crop"] button', { hasText: "Box" }).click();
  const setting = async () => new URLSearchParams((await page.evaluate(() => location.hash)).slice(1)).get("crop")?.split(",").map(Number);
  await page.waitForFunction(() => /crop=/.test(location.hash));
  const first = await setting();
  assert(first.length === 6 && first.slice(0, 3).every((low, axis) => low > 0 && low < first[axis + 3]), `${first}`);
  await page.locator('.toggle:has-text("Fill")').click();
  const cropped = await surfacePixels(page);
  assert(cropped.share < 0.95 * whole.share && cropped.share > 0.2 * whole.share, `${cropped.share} of ${whole.share}`);
  const canvas = await page.locator(".stage canvas").boundingBox();
  const hollow = await page.screenshot({ clip: canvas });
  await page.locator('.toggle:has-text("Fill")').click();
  await page.waitForSelector(".legends > :not([hidden])");
  assert(!hollow.equals(await page.screenshot({ clip: canvas })), "faces are filled");
  const [x, y] = [canvas.x + canvas.width / 2, canvas.y + canvas.height / 2];
  await page.mouse.move(x, y);
  await page.mouse.down();
  await page.mouse.move(x + 20, y);
  await page.mouse.move(x + 40, y);
  await page.mouse.up();
  await page.waitForFunction((before) => Number(/crop=([-\d.]+)/.exec(location.hash)?.[1]) > before + 2, first[0], { timeout: patience });
  await page.locator('[aria-label="Crop"] button', { hasText: "Off" }).click();
  await page.waitForFunction(() => !/crop=/.test(location.hash));
  await open(page, "#dataset=head&error=2&crop=-9,10,-9,40,50,90"); // Three faces are outside the data.
  await complete(page);
  await page.waitForSelector(".legends > :not([hidden])");
}

// The plane faces the camera first; the middle handle moves it, the one next to it rotates it.
async function dragsTheCut(page) {
  const size = 64;
  await open(page, "#dataset=head&error=2&axes=false&eye=32,-120,32&target=32,32,32");
  await complete(page);
  const whole = await surfacePixels(page);
  await page.click('summary:has-text("Clip and crop")');
  await page.locator('[aria-label="Clip"] button', { hasText: "Oblique" }).click();
  await page.waitForFunction(() => /clip=oblique.*clip_normal=0,1,0(&|$)/.test(location.hash));
  const canvas = await page.locator(".stage canvas").boundingBox();
  const [x, y] = [canvas.x + canvas.width / 2, canvas.y + canvas.height / 2];
  const drag = async (from, right, down) => {
    await page.mouse.move(x + from, y);
    await page.mouse.down();
    await page.mouse.move(x + from + right / 2, y + down / 2);
    await page.mouse.move(x + from + right, y + down);
    await page.mouse.up();
  };
  const setting = async (name) => new URLSearchParams((await page.evaluate(() => location.hash)).slice(1)).get(name);
  await drag(0, 0, -40);
  await page.waitForFunction(() => /clip_at=0\.[6-9]/.test(location.hash), null, { timeout: patience });
  assert.match(await setting("eye"), /^32,-120,32$/, "the camera stays");
  await drag(64, -40, 0);
  const isTurned = () => Math.abs(Number(/clip_normal=([-\d.e]+)/.exec(location.hash)?.[1])) > 0.2;
  await page.waitForFunction(isTurned, null, { timeout: patience }); // Slow browsers show the first half of the drag before.
  const [nx, ny, nz] = (await setting("clip_normal")).split(",").map(Number);
  assert(Math.abs(nx) > 0.2 && ny > 0.8 && Math.abs(nz) < 1e-3, `the plane turned around what is up: ${nx}, ${ny}, ${nz}`);
  const at = Number(await setting("clip_at"));
  const [from, to] = [Math.min(0, nx) * size + Math.min(0, ny) * size, Math.max(0, nx) * size + Math.max(0, ny) * size];
  const reached = from + at * (to - from);
  assert(reached > 32 * nx + 32 * ny, "it is pushed away still");
  assert((await surfacePixels(page)).share < whole.share, "less of the surface is seen");
  await page.locator("button", { hasText: "Face the camera" }).click();
  await page.waitForFunction(() => /clip_normal=0,1,0/.test(location.hash));
  const blueAtHandle = async (png) => {
    const [red, , blue] = await pixelOf(page, png, 0.5 + 64 / canvas.width, 0.5);
    return blue - red;
  };
  assert(await blueAtHandle(await page.screenshot({ clip: canvas })) > 100, "the handle is seen");
  assert(await blueAtHandle(await downloaded(page, "Picture")) < 60, "handles are not in pictures");
}

async function savesFiles(page) {
  // A picture requested before there is a surface waits for it.
  await open(page, "#dataset=head&error=0.25&axes=false&eye=32,-120,32&target=32,32,32");
  const early = await downloaded(page, "Picture");
  const [red, green, blue] = await pixelOf(page, early, 0.5, 0.5);
  assert(red > 80 && red > blue + 15, `${red}, ${green}, ${blue} is the color of a surface`);
  await open(page, "#dataset=gyroid&error=1&simplify=false&occlusion=false");
  const { triangles } = await complete(page);
  assert.equal((await downloaded(page, "STL")).readUInt32LE(80), triangles);
  await notice(page, /^Saved [\d\u202f]+ triangles/);
  assert.equal(Number((await page.textContent(".notice")).match(/^Saved ([\d\u202f]+) /)[1].replace(/\D/g, "")), triangles);
  assert.equal((await downloaded(page, "GLB")).toString("latin1", 0, 4), "glTF");
  assert.match((await downloaded(page, "PLY")).toString("latin1", 0, 400), new RegExp(`element face ${triangles}`));
  const small = await downloaded(page, "Picture");
  assert.equal(small.toString("latin1", 1, 4), "PNG");
  await page.locator('[aria-label="Picture size"] button', { hasText: "2" }).click();
  await page.click('label:has-text("Transparent background")');
  const large = await downloaded(page, "Picture");
  const widthOf = (png) => png.readUInt32BE(16);
  assert.equal(widthOf(large), 2 * widthOf(small));
  await page.fill('[aria-label="Width of the picture, in pixels"]', "1234");
  await page.keyboard.press("Enter");
  assert.equal(widthOf(await downloaded(page, "Picture")), 1234);
  assert.deepEqual((await cornerOf(page, small))[3], 255);
  assert.deepEqual((await cornerOf(page, large))[3], 0, "nothing lies behind the surface");
}

// The first pixel of a PNG as [red, green, blue, alpha].
function cornerOf(page, png) {
  return pixelOf(page, png, 0, 0);
}

// The pixel at a fraction of the width and the height.
function pixelOf(page, png, across, down) {
  return page.evaluate(async ({ data, across, down }) => {
    const image = new Image();
    image.src = `data:image/png;base64,${data}`;
    await image.decode();
    const context = new OffscreenCanvas(1, 1).getContext("2d");
    context.drawImage(image, -Math.floor(across * image.width), -Math.floor(down * image.height));
    return [...context.getImageData(0, 0, 1, 1).data];
  }, { data: png.toString("base64"), across, down });
}

async function downloaded(page, word) {
  const isFolded = await page.locator(".actions").isHidden();
  if (isFolded) await page.click('summary:has-text("Export")');
  const coming = page.waitForEvent("download");
  await page.click(`.action:has-text("${word}")`);
  return readFileSync(await (await coming).path());
}

async function resumes(page) {
  await open(page, "#dataset=gyroid");
  const before = await complete(page);
  await page.focus('.dataset[data-name="gyroid"]');
  page.mayLoseItsConnection = true;
  await server.stop();
  await page.waitForSelector(".notice:not([hidden])", { timeout: patience });
  assert.match(await page.textContent(".notice"), /No connection/);
  assert((await surfacePixels(page)).share > 0.03, "the surface stays");
  await server.start();
  await page.waitForSelector(".notice", { state: "hidden", timeout: patience });
  assert.equal(await atKeyboard(page), "button.dataset", "the keyboard is where it was");
  await page.fill('[aria-label="Isovalue"]', "0.3");
  await page.press('[aria-label="Isovalue"]', "Enter");
  const after = await complete(page, (shown) => shown.digest !== before.digest);
  assert(after.triangles > 0);
}

async function reportsUnknownDataset(page) {
  await open(page, "#dataset=corner_of_the_moon");
  await page.waitForSelector(".notice:not([hidden])", { timeout: patience });
  assert.match(await page.textContent(".notice"), /corner_of_the_moon" is served here\.$/);
  await open(page, "#dataset=gyriod");
  await notice(page, /Did you mean "gyroid"\?/);
  await page.click('.dataset[data-name="gyroid"]');
  await complete(page);
  assert(await page.locator(".notice").isHidden());
  // Also together with another setting that finds the dataset again.
  await page.evaluate(() => (location.hash = "#dataset=nope&t=1"));
  await notice(page, /nope/);
}

async function reportsEmptySurface(page) {
  await open(page, "#dataset=head&isovalue=99999");
  await page.waitForFunction(() => document.querySelector(".state b")?.textContent === "No surface", null, { timeout: patience });
  assert.match(await page.textContent(".notice"), /no surface at isovalue 99999: the values of "head" range from/);
  assert(await page.isHidden(".seal"), "nothing is certified of nothing");
  await page.fill('[aria-label="Isovalue"]', "500.5");
  await page.press('[aria-label="Isovalue"]', "Enter");
  await complete(page);
  assert(await page.isHidden(".notice"), "the words go when there is a surface");
}

async function goesBack(page) {
  await open(page, "#dataset=head&isovalue=500.5");
  const before = await complete(page);
  await page.fill('[aria-label="Isovalue"]', "300.5");
  await page.press('[aria-label="Isovalue"]', "Enter");
  await page.waitForFunction(() => location.hash.includes("isovalue=300.5"), null, { timeout: patience });
  await complete(page, (shown) => shown.digest !== before.digest);
  await page.goBack();
  await complete(page, (shown) => shown.digest === before.digest);
  assert.equal(await page.inputValue('[aria-label="Isovalue"]'), "500.5");
  await page.goForward();
  await complete(page, (shown) => shown.digest !== before.digest);
  assert.equal(await page.inputValue('[aria-label="Isovalue"]'), "300.5");
}

async function keepsAPlace(page) {
  await open(page, "#dataset=head&isovalue=500.5");
  await complete(page);
  const canvas = await page.locator(".stage canvas").boundingBox();
  await page.mouse.click(canvas.x + canvas.width / 2, canvas.y + canvas.height / 2);
  await page.waitForFunction(() => /Value/.test(document.querySelector(".picked").textContent), null, { timeout: patience });
  const said = await page.textContent(".picked");
  await page.mouse.click(canvas.x + canvas.width - 30, canvas.y + canvas.height - 60);
  await page.waitForTimeout(700);
  assert.equal(await page.textContent(".picked"), said);
  await page.keyboard.press("Escape");
  await page.waitForSelector(".picked", { state: "hidden" });
}

async function showsSeveral(page) {
  await open(page, "#dataset=head&isovalue=300.5&opacity=0.3&surfaces=900.5,3060ff,1&axes=false");
  const first = await complete(page);
  const told = (row) => page.waitForFunction((at) => {
    const text = document.querySelectorAll(".surface-state")[at]?.textContent ?? "";
    return /triangles/.test(text) && !text.endsWith("…") && text;
  }, row, { timeout: patience }).then((handle) => handle.jsonValue());
  const before = await told(1);
  const plot = await page.locator(".histogram-plot").boundingBox();
  const line = await page.locator(".isoline").nth(1).boundingBox();
  await page.mouse.move(line.x + 1, plot.y + 20);
  await page.mouse.down();
  await page.mouse.move(line.x - 12, plot.y + 20, { steps: 3 });
  await page.mouse.up();
  await page.waitForFunction(() => !location.hash.includes("900.5"), null, { timeout: patience });
  assert.match(await page.evaluate(() => location.hash), /isovalue=300.5/, "the first one's line stays");
  await page.waitForFunction((words) => {
    const text = document.querySelectorAll(".surface-state")[1].textContent;
    return text !== words && /triangles/.test(text) && !text.endsWith("…");
  }, before, { timeout: patience });
  await page.click('button[aria-label="Remove surface 1"]');
  await page.waitForFunction(() => document.querySelectorAll(".surface-row").length === 1);
  const alone = await complete(page, (shown) => shown.digest !== first.digest);
  assert.notEqual(alone.triangles, first.triangles, "the second one is the first now");
}

async function showsTwoDatasets(page) {
  await open(page, "#dataset=head&isovalue=500.5&error=1");
  await complete(page);
  assert.match(await page.textContent(".seal"), /Watertight, within 1 mm$/);
  const bytes = await page.textContent(".fact.bytes");
  await open(page, "#dataset=head&isovalue=500.5&error=1&surfaces=900.5,00ff00;0.1,ff0000,,,,gyroid");
  await complete(page);
  const lines = await page.locator(".isoline").evaluateAll((all) => all.map((one) => one.getAttribute("aria-label")));
  assert.deepEqual(lines, ["Isovalue of surface 1", "Isovalue of surface 2"], "the gyroid's values are not the head's");
  assert.match(await page.textContent(".seal"), /No cracks, within/, "the gyroid ends where its data does");
  assert.notEqual(await page.textContent(".fact.bytes"), bytes);
  await page.click(".seal");
  assert.deepEqual(await page.locator(".certificate h3").allTextContents(),
    ["Surface 1: isovalue 500.5", "Surface 2: isovalue 900.5", "Surface 3: isovalue 0.1"]);
  await page.keyboard.press("Escape");
  const json = await glbOf(await downloaded(page, "GLB"));
  const named = json.nodes.filter(({ mesh }) => mesh !== undefined).map(({ name }) => name);
  assert.deepEqual(named, ["head, isovalue 500.5", "head, isovalue 900.5", "gyroid, isovalue 0.1"]);
  assert.deepEqual(json.materials.map(({ pbrMetallicRoughness }) => pbrMetallicRoughness.baseColorFactor.slice(0, 3)).slice(1), [[0, 1, 0], [1, 0, 0]]);
}

// Returns what a valid GLB file describes.
async function glbOf(bytes) {
  const { issues } = await createRequire(new URL("../../../client/web/package.json", import.meta.url))("gltf-validator").validateBytes(bytes);
  assert.equal(issues.numErrors, 0, JSON.stringify(issues.messages.slice(0, 3)));
  return JSON.parse(bytes.toString("utf8", 20, 20 + bytes.readUInt32LE(12)));
}

async function measuresAPart(page) {
  await open(page, "#dataset=head&isovalue=500.5&eye=32,-120,32&target=32,32,32");
  await complete(page);
  const canvas = await page.locator(".stage canvas").boundingBox();
  for (const [x, y] of [[0.5, 0.5], [0.54, 0.5], [0.5, 0.45]]) {
    const count = await page.locator(".dot").count();
    await page.mouse.click(canvas.x + x * canvas.width, canvas.y + y * canvas.height);
    await page.waitForFunction((n) => document.querySelectorAll(".dot").length === n + 1, count, { timeout: patience });
  }
  assert.match(await page.textContent(".picked"), /B to C: [\d.]+ ± [\d.]+ mm .*Angle at B: [\d.]+°/s);
  await page.waitForFunction(() => /places=[^;&]+;[^;&]+;[^;&]+/.test(location.hash), null, { timeout: patience });
  const dots = await page.locator(".dot").evaluateAll((all) => all.map((one) => one.style.transform.match(/[\d.]+/g).map(Number)));
  const line = (await page.getAttribute(".pick-labels polyline", "points")).split(/[ ,]/).map(Number);
  assert.deepEqual(line.map(Math.round), dots.flat().map(Math.round), "the line goes through all three");
  await page.click(".measure-part");
  await page.waitForSelector(".part", { timeout: patience });
  const [, area, volume, bound] = (await page.textContent(".part")).match(/Area about ([\d.]+) \S+², volume ([\d.]+) ± ([\d.]+) /).map(Number);
  // The saved file of all parts gives the same measures.
  const whole = massOf(await downloaded(page, "STL"));
  const parts = Number((await page.textContent(".certificate")).match(/Connected components(\d+)/)[1]);
  const share = parts === 1 ? 0.94 : 0.5;
  assert(area > share * whole.area && area < 1.06 * whole.area, `${area} of ${whole.area}`);
  if (parts === 1) assert(Math.abs(volume - whole.volume) < bound, `${volume} ± ${bound}, ${whole.volume}`);
  assert.match(await page.textContent(".part"), /Exact narrows the bound/);
  // Measured again for another quality.
  await page.click('[aria-label="Qualities"] button:text-is("Exact")');
  await page.waitForFunction(() => /full resolution/.test(document.querySelector(".part")?.textContent ?? ""), null, { timeout: patience });
  const exact = massOf(await downloaded(page, "STL"));
  const [, exactArea] = (await page.textContent(".part")).match(/Area ([\d.]+)/).map(Number);
  assert(exactArea > share * exact.area && exactArea < 1.01 * exact.area, `${exactArea} of ${exact.area}`);
  assert.doesNotMatch(await page.textContent(".part"), /narrows/);
  // Unknown for another surface.
  await page.fill('[aria-label="Isovalue"]', "700.5");
  await page.press('[aria-label="Isovalue"]', "Enter");
  await page.waitForFunction(() => !document.querySelector(".picked :is(.part, .measure-part)"), null, { timeout: patience });
}

async function hidesSmallComponents(page) {
  const folder = path.join(scratch, "dusty");
  const [volume, dataset] = ["dusty.nrrd", "dusty.mtd"].map((name) => path.join(folder, name));
  mkdirSync(folder, { recursive: true });
  run("generate", "head", "--size", "41", "--noise", "120", "--seed", "3", "-o", volume);
  run("prepare", volume, "-o", dataset);
  const written = (least) => {
    const file = path.join(folder, `from${least}.ply`);
    const said = run("extract", dataset, "--isovalue", "100", "--error", "0", "--min-component", String(least), "-o", file, "--json");
    const [vertices, faces] = sizesOf(readFileSync(file));
    const value = (name) => said.match(new RegExp(`"${name}": "?([0-9a-f]+)`))[1];
    return { vertices, faces, shown: value("components_written"), all: value("components"), digest: value("content_digest") };
  };
  const [large, larger] = [written(6), written(12)];
  let sent = 0; // Counts frames of the surface's connection, whose first one names no part of the viewer.
  page.on("websocket", (socket) => {
    let isOfSurface = null;
    socket.on("framesent", ({ payload }) => {
      isOfSurface ??= !payload.includes("queries");
      sent += isOfSurface ? 1 : 0;
    });
  });
  // The setting in the address applies from the first frame. With the field's gradients the mesh equals the command
  // line's; without them it is the finest level's, another triangulation of the same surface.
  await open(page, "#dataset=dusty&isovalue=100&error=0&axes=false&shading=field&min_component=6", await serveFolder(folder));
  const whole = await complete(page, ({ triangles }) => triangles === large.faces);
  assert.equal(whole.digest, large.digest, "what is checked is the whole surface");
  assert(Number((await page.textContent(".bytes span")).match(/in (\d+) tiles/)[1]) > 1, "components go across tiles");
  assert.match(await page.textContent(".certificate"), new RegExp(`${large.shown} components of ${large.all} shown \\(smaller than 6 samples hidden\\)`));
  assert.match(await page.textContent(".certificate"), new RegExp(`Connected components${large.all}`));
  // Another size applies without the server.
  const before = sent;
  const hide = async (samples, words) => {
    await page.fill('[aria-label^="Hide components of the surface"]', samples);
    await page.keyboard.press("Enter");
    await page.waitForFunction((pattern) => new RegExp(pattern).test(document.querySelector(".seal").textContent), words, { timeout: patience });
  };
  await hide("12", `Watertight, full resolution, ${larger.shown} of ${larger.all} components shown`);
  await page.waitForFunction(() => /min_component=12/.test(location.hash));
  await complete(page, ({ triangles }) => triangles === larger.faces);
  assert.deepEqual(sizesOf(await downloaded(page, "PLY")), [larger.vertices, larger.faces], "the file has what is shown");
  assert((await surfacePixels(page)).share > 0.03);
  await page.locator(".stage canvas").click();
  await page.click(".measure-part", { timeout: patience });
  await page.waitForSelector(".part", { timeout: patience });
  const area = Number((await page.textContent(".part")).match(/Area ([\d.]+)/)[1]); // All digits, at full resolution.
  const { area: saved } = massOf(await downloaded(page, "STL"));
  assert(Math.abs(area - saved) < 1e-3 * saved, `the one that is left has ${area} of ${saved}`);
  await page.focus(".stage canvas");
  await page.keyboard.press("Escape");
  await hide("", "^✓ Watertight, full resolution$");
  await page.click('[aria-label="Keep the largest part of the surface"]');
  await page.waitForFunction((all) => document.querySelector(".seal").textContent.endsWith(`1 of ${all} components shown`), large.all, { timeout: patience });
  await hide("12", `${larger.shown} of ${larger.all} components shown`);
  const room = await page.evaluate(() => ["facts", "fact.error"].map((name) => document.querySelector(`.${name}`).getBoundingClientRect().right));
  assert(room[1] <= room[0] + 1, `the facts end at ${room[0]}, the error at ${room[1]}`);
  await page.waitForTimeout(800); // Changes in quick succession are undone together.
  await hide("1000", "Nothing shown");
  assert.match(await page.textContent(".notice"), new RegExp(`No components of ${large.all} shown \\(smaller than 1000 samples hidden\\)`));
  assert((await surfacePixels(page)).share < 0.001, "nothing is left of it");
  await page.focus(".stage canvas");
  await page.keyboard.press("Control+z");
  await page.waitForFunction(() => /min_component=12/.test(location.hash));
  await hide("", "^✓ Watertight, full resolution$");
  assert.deepEqual([before > 0, sent], [true, before], "nothing is requested from the server");
  // Only the largest component remains at another quality.
  await page.click('[aria-label="Keep the largest part of the surface"]');
  await page.waitForFunction(() => /min_component=largest/.test(location.hash));
  await page.click('[aria-label="Qualities"] button:text-is("Draft")');
  await complete(page, ({ digest }) => digest !== whole.digest);
  await page.waitForFunction(() => /(^|, )1 of \d+ components shown$/.test(document.querySelector(".seal").textContent), null, { timeout: patience });
  await page.click('[aria-label="Keep the largest part of the surface"]');
  await page.waitForFunction(() => !/components shown/.test(document.querySelector(".seal").textContent), null, { timeout: patience });
}

// The numbers of vertices and faces in a PLY file's header.
function sizesOf(ply) {
  return ply.toString("latin1", 0, 400).match(/element vertex (\d+)[^]*element face (\d+)/).slice(1).map(Number);
}

async function countsTriangles(page) {
  const count = (words) => page.waitForFunction((text) => {
    const fact = document.querySelector(".fact.triangles");
    return fact.textContent.replace(/[\s\u202f]/g, "").endsWith(text);
  }, words, { timeout: patience });
  await page.addInitScript(() => {
    window.calledCompleteTooEarly = [];
    new MutationObserver(() => {
      const rows = [...document.querySelectorAll(".surface-state")].map(({ textContent }) => textContent);
      const isEarly = rows.some((text) => !/voxels?$/.test(text));
      if (document.querySelector(".state b")?.textContent === "Complete" && isEarly) window.calledCompleteTooEarly.push(rows);
    }).observe(document, { subtree: true, childList: true, characterData: true });
  });
  await open(page, "#dataset=gyroid&isovalue=0.1&error=1&surfaces=0.5,ff0000");
  await page.waitForFunction(() => [...document.querySelectorAll(".surface-state")].length === 2 &&
    [...document.querySelectorAll(".surface-state")].every(({ textContent }) => /voxels?$/.test(textContent)), null, { timeout: patience });
  const each = await page.evaluate(() => [...document.querySelectorAll(".surface-state")].map(({ textContent }) =>
    Number(textContent.split("triangles")[0].replace(/\D/g, ""))));
  assert(each.every((triangles) => triangles > 0) && each[0] !== each[1], String(each));
  await count(`${each[0] + each[1]}trianglesof2surfaces`);
  await complete(page);
  assert.deepEqual(await page.evaluate(() => window.calledCompleteTooEarly), []);
  await page.click('summary:has-text("Surfaces")').catch(() => {});
  await page.evaluate(() => document.querySelector('.eye[aria-label="Show surface 1"]').click());
  await count(`${each[1]}triangles`);
  await page.evaluate(() => document.querySelector('.eye[aria-label="Show surface 2"]').click());
  await count("0triangles");
}

function massOf(stl) {
  let area = 0;
  let volume = 0;
  for (let t = 0; t < stl.readUInt32LE(80); ++t) {
    const [a, b, c] = [12, 24, 36].map((from) => [0, 4, 8].map((at) => stl.readFloatLE(84 + 50 * t + from + at)));
    const cross = (u, v) => [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    const n = cross(b.map((v, i) => v - a[i]), c.map((v, i) => v - a[i]));
    area += Math.hypot(...n) / 2;
    volume += cross(b, c).reduce((sum, v, i) => sum + v * a[i], 0) / 6;
  }
  return { area, volume: Math.abs(volume) };
}

async function showsASlice(page) {
  const view = "eye=16,-60,16&target=16,16,16";
  await open(page, `#dataset=gyroid&isovalue=0.5&visible=false&axes=false&occlusion=false&${view}&slice=y&slice_colors=coolwarm`);
  await page.waitForFunction(() => document.querySelector(".state b").textContent === "Hidden", null, { timeout: patience });
  const canvas = await page.locator(".stage canvas").boundingBox();
  const colored = async (hash) => {
    await page.evaluate((text) => (location.hash += text), hash);
    await page.waitForTimeout(1500);
    return (await surfacePixels(page)).share; // The red end of the color map.
  };
  const all = await colored("&axes=false");
  assert(all > 0.05, `samples are shown: ${all}`);
  assert((await colored("&level=5&window_width=1")) < 0.2 * all, "above all values nothing is red");
  const value = async (share) => {
    await page.mouse.click(canvas.x + share * canvas.width, canvas.y + canvas.height / 2);
    await page.waitForFunction(() => /Value/.test(document.querySelector(".picked .field")?.textContent ?? ""), null, { timeout: patience });
    const said = await page.textContent(".picked");
    await page.keyboard.press("Escape");
    return { value: Number(said.match(/Value (-?[\d.e-]+)/)[1]), y: Number(said.match(/sample [\d.]+, ([\d.]+)/)[1]) };
  };
  const [here, there] = [await value(0.5), await value(0.56)];
  assert.equal(here.y, 16, "the place lies on the plane");
  assert.notEqual(here.value, there.value);
  await page.focus(".legend:not([hidden]) .legend-slider");
  await page.keyboard.press("ArrowUp");
  await page.waitForFunction(() => !/window_width=1(&|$)/.test(location.hash));
}

// A CT of a ball of bone in soft tissue, in a file that defines no axes of the patient.
async function showsTomography(page) {
  const folder = path.join(scratch, "tomography");
  mkdirSync(folder, { recursive: true });
  const volume = path.join(scratch, "ct.nrrd");
  writeNrrd(volume, 33, samplesOf(33, (x, y, z) => {
    const radius = Math.hypot(x - 16, y - 16, z - 16);
    return radius > 12 ? -1000 : radius > 7 ? 40 - radius : 1000 - 50 * radius;
  }));
  run("prepare", volume, "--name", "ct", "--force", "-o", path.join(folder, "ct.mtd"));
  await open(page, "#dataset=ct&error=2&visible=false&occlusion=false&eye=16,-60,16&target=16,16,16&slice=y", await serveFolder(folder));
  await page.waitForFunction(() => document.querySelector(".state b").textContent === "Hidden", null, { timeout: patience });
  const said = (pattern) => page.waitForFunction((text) => new RegExp(text).test(location.hash), pattern.source, { timeout: patience });
  await page.waitForSelector('[aria-label="Suggested isovalues"] button', { timeout: patience }); // They follow the histogram.
  const suggested = await page.locator('[aria-label="Suggested isovalues"] button').allTextContents();
  assert(suggested.length > 1 && suggested.every((text) => /^-?[\d.]+ (skin|bone)$/.test(text)), String(suggested));
  assert(new Set(suggested.map((text) => text.split(" ")[1])).size === 2, `${suggested} are skin and bone`);
  // Level and window of the slice.
  await page.click('[aria-label="Windows"] button:text-is("Bone")');
  await said(/level=500&window_width=2000(&|$)/);
  const legend = await page.locator(".legend:not([hidden]) .legend-slider").boundingBox();
  const [x, y] = [legend.x + legend.width / 2, legend.y + legend.height / 2];
  await page.mouse.move(x, y);
  await page.mouse.down();
  await page.mouse.move(x + 50, y - 15, { steps: 2 }); // To the right and up.
  await page.mouse.up();
  await page.waitForFunction(() => {
    const [level, width] = ["level", "window_width"].map((name) => Number(new URLSearchParams(location.hash.slice(1)).get(name)));
    return level > 550 && width > 2200 && width < 2700;
  });
  // Air around the ball.
  const canvas = await page.locator(".stage canvas").boundingBox();
  const air = async (isIt) => {
    const until = Date.now() + patience;
    while (true) {
      const pixel = String(await pixelOf(page, await page.screenshot({ clip: canvas }), 0.5 - (0.25 * canvas.height) / canvas.width, 0.3));
      if (isIt(pixel)) return pixel;
      assert(Date.now() < until, `${pixel} is the color of air`);
    }
  };
  await page.waitForTimeout(500);
  const hidden = await air(() => true);
  await page.click('label:has-text("Transparent air")');
  await said(/transparent_air=false/);
  await air((pixel) => pixel !== hidden);
  await page.click('[aria-label="Plane"] button:text-is("Off")');
  await air((pixel) => pixel === hidden);
  // The file does not define which way is up.
  assert.equal(await page.textContent(".turn-up"), "up: z");
  await page.click(".turn-up");
  await said(/up=0,0,-1(&|$)/);
  await page.waitForFunction(() => document.querySelector(".turn-up").textContent === "up: −z");
  await page.focus(".stage canvas");
  await page.keyboard.press("u");
  await page.waitForFunction(() => document.querySelector(".turn-up").textContent === "up: z" && !/up=0,0,-1/.test(location.hash));
  const upright = await page.evaluate(() => location.hash);
  await page.keyboard.press("[");
  await page.waitForFunction((before) => location.hash !== before && /up=-?0\.[01]\d*,/.test(location.hash), upright);
}

async function linksSlices(page) {
  await open(page, "#dataset=head&isovalue=300.5&error=2&layout=four&cross=20,32,40");
  await complete(page);
  const views = page.locator(".slice-view");
  const words = () => views.evaluateAll((all) => all.map((one) => one.getAttribute("aria-label").split(". Click")[0]));
  const values = (pattern) => page.waitForFunction((text) => [...document.querySelectorAll(".slice-view")]
    .every((one) => new RegExp(text).test(one.getAttribute("aria-label"))), pattern, { timeout: patience });
  assert.deepEqual((await words()).map((text) => text.replace(/:.*/, "")), ["Axial slice, z 40 mm", "Coronal slice, y 32 mm", "Sagittal slice, x 20 mm"]);
  assert.equal(await views.count(), 3);
  // A click in the middle of the first view moves the other two.
  const box = await views.first().boundingBox();
  await page.mouse.click(box.x + box.width / 2, box.y + box.height / 2);
  await page.waitForFunction(() => /cross=3[12][^,]*,3[12][^,]*,40(&|$)/.test(location.hash), null, { timeout: patience });
  await page.mouse.wheel(0, -180);
  await page.waitForFunction(() => /cross=3[12][^,]*,3[12][^,]*,43(&|$)/.test(location.hash), null, { timeout: patience });
  await values("mm: -?[\\d.]+\\. Click"); // Each shows the sample at the crosshair.
  const [axial, coronal] = await words();
  assert.equal(axial.split(": ")[1], coronal.split(": ")[1], "it is the same place");
  const picture = await views.first().evaluate((canvas) => {
    const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
    return new Set(data.filter((_, i) => i % 4 === 0)).size;
  });
  assert(picture > 20, `${picture} shades`);
  assert(await page.isVisible(".cross-mark"), "the place is marked in the picture of the surface");
  await zoomsSlices(page, views.first());
  await page.focus(".slice-view");
  await page.keyboard.press("PageDown");
  await page.waitForFunction(() => /,42(&|$)/.test(location.hash));
  await measuresInSlices(page, views.first());
  await page.click('[aria-label="Slices beside the surface"]');
  await page.waitForFunction(() => !/layout/.test(location.hash));
  assert(await page.isHidden(".slice-view"));
}

// Two double clicks measure a length, which the view shows; the exported picture has the slices, with it.
async function measuresInSlices(page, view) {
  const { x, y, width, height } = await view.boundingBox();
  const yellow = () => view.evaluate((canvas) => {
    const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
    return data.filter((red, i) => i % 4 === 0 && red === 0xff && data[i + 1] === 0xd2 && data[i + 2] === 0x4a).length;
  });
  assert.equal(await yellow(), 0);
  await page.mouse.dblclick(x + 0.4 * width, y + height / 2);
  await page.waitForFunction(() => /places=/.test(location.hash));
  await page.mouse.dblclick(x + 0.6 * width, y + height / 2);
  await page.waitForFunction(() => /places=[^&]*(;|%3B)/.test(location.hash));
  const [, length] = (await page.locator(".picked .distance").first().textContent()).match(/^A to B: ([\d.]+) mm /);
  const { low, high } = await page.evaluate(() => {
    const [a, b] = new URLSearchParams(location.hash.slice(1)).get("places").split(";").map((place) => place.split(",").map(Number));
    return { low: a, high: b };
  });
  assert(Math.abs(Math.abs(high[0] - low[0]) - Number(length)) < 0.1 && Math.abs(high[2] - 42) < 1e-6, `${low}, ${high}: ${length}`);
  await page.waitForTimeout(300);
  assert(await yellow() > 100, "the line is drawn");
  const bytes = await downloaded(page, "Picture");
  if (process.env.KEEP) writeFileSync(`${process.env.KEEP}/slices.png`, bytes);
  const [pictureWidth, pictureHeight] = [bytes.readUInt32BE(16), bytes.readUInt32BE(20)];
  const whole = await page.locator(".multitetra").boundingBox();
  assert(Math.abs(pictureWidth / pictureHeight - whole.width / whole.height) < 0.01, `${pictureWidth} x ${pictureHeight}, ${JSON.stringify(whole)}`);
  await page.keyboard.press("Escape");
}

// A zoomed view shows a part of its plane: equal steps of the mouse move the crosshair less far.
async function zoomsSlices(page, view) {
  const cross = () => page.evaluate(() => location.hash.match(/cross=([^&]*)/)[1].split(",").map(Number));
  const { x, y, width, height } = await view.boundingBox();
  const clickAt = async (acrossShare) => {
    const before = await cross();
    await page.mouse.click(x + acrossShare * width, y + height / 2);
    await page.waitForFunction((old) => !location.hash.includes(`cross=${old}`), before.join(","), { timeout: patience });
    return (await cross())[0];
  };
  const whole = Math.abs(await clickAt(0.6) - await clickAt(0.5));
  await page.mouse.move(x + width / 2, y + height / 2);
  await page.keyboard.down("Control");
  await page.mouse.wheel(0, -420); // 4 times.
  await page.keyboard.up("Control");
  const zoomed = Math.abs(await clickAt(0.6) - await clickAt(0.5));
  assert(zoomed > 0 && zoomed < 0.5 * whole, `${zoomed} of ${whole} samples`);
  const shades = () => view.evaluate((canvas) => {
    const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
    let hash = 0;
    for (let i = 0; i < data.length; i += 4) hash = (31 * hash + data[i]) | 0;
    return hash;
  });
  for (let drags = 0; drags < 3; ++drags) { // The last one with the crosshair outside of the view.
    const before = await shades();
    await page.mouse.move(x + width / 2, y + height / 2);
    await page.mouse.down({ button: "right" });
    await page.mouse.move(x + 0.9 * width, y + height / 2);
    await page.mouse.up({ button: "right" });
    await page.waitForTimeout(300);
    assert.notEqual(await shades(), before, "the right button drags the picture");
  }
  await page.keyboard.press("f"); // The view has the focus since the click.
  assert.equal(Math.abs(await clickAt(0.6) - await clickAt(0.5)), whole, "F shows the whole plane");
}

async function refinesWhatIsNear(page) {
  await open(page, "#dataset=head&isovalue=300.5&error=2&pixels=4&follow_view=true&eye=32,-800,32&target=32,32,32&axes=false");
  const far = await complete(page);
  const look = (eye) => page.evaluate((to) => (location.hash = location.hash.replace(/eye=[^&]*/, `eye=${to}`)), eye);
  await look("32,-30,32");
  const near = await complete(page, ({ triangles }) => triangles > 1.2 * far.triangles);
  assert.notEqual(near.digest, far.digest);
  await look("300,-740,32");
  await complete(page, ({ digest }) => digest === far.digest); // Rotating a distant view requests nothing.
}

// No setting in the address requests this.
async function followsTheView(page) {
  const hash = "#dataset=head&isovalue=300.5&error=2&pixels=4&eye=32,-800,32&target=32,32,32&axes=false";
  let far = null;
  for (let attempt = 0; attempt < 8 && !far; ++attempt) {
    await page.goto("about:blank");
    await page.goto(server.page + hash);
    const shown = await complete(page);
    if (await page.locator(".toggle.is-off").count() === 0) far = shown; // Otherwise the machine was slow, and detail is paused.
  }
  assert(far, "the surface comes within two seconds, once at least");
  await page.evaluate(() => (location.hash = location.hash.replace(/eye=[^&]*/, "eye=32,-30,32")));
  await complete(page, ({ triangles }) => triangles > 1.2 * far.triangles);
}

async function pausesDetail(page) {
  // Delays every message of the server after the list of datasets, as on a slow link.
  const requests = [];
  await page.routeWebSocket(/v1\/stream/, (socket) => {
    const other = socket.connectToServer();
    let received = 0;
    socket.onMessage((message) => {
      if (message.includes("head")) requests.push(message);
      other.send(message);
    });
    other.onMessage((message) => (++received > 2 ? setTimeout(() => socket.send(message), 2100) : socket.send(message)));
  });
  await page.goto(`${server.page}#dataset=head&isovalue=300.5&error=2&pixels=4&eye=32,-800,32&target=32,32,32&axes=false`);
  const far = await complete(page);
  await page.waitForSelector('.toggle.is-off:has-text("View-dependent detail")', { timeout: patience });
  const look = (eye) => page.evaluate((to) => (location.hash = location.hash.replace(/eye=[^&]*/, `eye=${to}`)), eye);
  const { length } = requests;
  await look("32,-30,32");
  await page.waitForTimeout(800);
  assert.equal(requests.length, length, "nothing finer is requested");
  assert.equal((await complete(page)).digest, far.digest);
  await page.locator('label:has-text("View-dependent detail")').click(); // Turns it off.
  await page.locator('label:has-text("View-dependent detail")').click(); // Turns it on again.
  await complete(page, ({ triangles }) => triangles > 1.2 * far.triangles);
}

async function namesQualities(page) {
  await open(page, "#dataset=head&isovalue=300.5&error=1");
  let before = await complete(page);
  const counts = [];
  for (const [word, error] of [["Draft", "2"], ["Normal", "0.5"], ["Exact", "0"]]) {
    const button = `[aria-label="Qualities"] button:text-is("${word}")`;
    await page.click(button);
    await page.waitForFunction((text) => new URLSearchParams(location.hash.slice(1)).get("error") === text, error);
    assert.equal(await page.getAttribute(button, "aria-pressed"), "true");
    before = await complete(page, ({ digest }) => digest !== before.digest);
    counts.push(before.triangles);
  }
  assert(counts[0] < counts[1] && counts[1] <= counts[2], `${counts} triangles`); // On a slow server, all from samples.
}

async function hidesAPart(page) {
  await page.setViewportSize({ width: 1200, height: 800 });
  await open(page, "#dataset=head&isovalue=300.5&error=1&eye=32,-120,32&target=32,32,32&axes=false");
  await complete(page);
  const before = (await surfacePixels(page)).share;
  const canvas = await page.locator(".stage canvas").boundingBox();
  await page.mouse.click(canvas.x + canvas.width / 2, canvas.y + canvas.height / 2);
  await page.click('.picked button:has-text("Hide this part")');
  await page.waitForFunction(() => /hidden_parts=/.test(location.hash));
  await page.waitForFunction(() => /components? of \d+ shown/.test(document.body.textContent));
  const without = (await surfacePixels(page)).share;
  assert(without < 0.9 * before, `${without} is seen of ${before}`);
  await page.reload(); // The address contains it.
  await complete(page);
  const again = (await surfacePixels(page)).share;
  assert(Math.abs(again - without) < 0.02, `${again} is seen after a reload, ${without} before`);
  const triangles = Number((await page.textContent(".fact.triangles b")).replace(/\D/g, ""));
  const json = await glbOf(await downloaded(page, "GLB"));
  assert.equal(json.asset.extras.length_unit, "mm");
  assert.equal(json.accessors[json.meshes[0].primitives[0].indices].count, 3 * triangles, "the file has what is shown");
  assert.equal((await downloaded(page, "STL")).readUInt32LE(80), triangles);
  assert.match((await downloaded(page, "PLY")).toString("latin1", 0, 400), new RegExp(`element face ${triangles}`));
  await page.click('button:has-text("Show 1 hidden part")');
  await page.waitForFunction(() => !/hidden_parts=/.test(location.hash));
  await page.waitForTimeout(500);
  assert((await surfacePixels(page)).share > 0.95 * before, "all is there again");
}

async function keepsNotes(page) {
  await open(page, "#dataset=gyroid&error=1&eye=16,-60,16&target=16,16,16");
  await complete(page);
  const canvas = await page.locator(".stage canvas").boundingBox();
  await page.mouse.click(canvas.x + canvas.width / 2, canvas.y + canvas.height / 2);
  await page.fill('[aria-label="Note on A"]', "a saddle, here");
  await page.press('[aria-label="Note on A"]', "Enter");
  await page.waitForFunction(() => new URLSearchParams(location.hash.slice(1)).get("places")?.endsWith("a saddle%2C here"));
  assert.equal(await page.textContent(".dot-note"), "a saddle, here");
  await page.reload();
  await complete(page);
  await page.waitForFunction(() => document.querySelector(".dot-note")?.textContent === "a saddle, here");
}

async function showsTheFront(page) {
  await open(page, "#dataset=gyroid&error=2&up=-y");
  await complete(page);
  await page.click('[aria-label="Front view"]');
  await page.waitForFunction(() => {
    const [x, y, z] = (new URLSearchParams(location.hash.slice(1)).get("eye") ?? "").split(",").map(Number);
    return Math.abs(x - 16) < 2 && Math.abs(y - 16) < 2 && z < -10; // Along z.
  }, null, { timeout: patience });
  // The thumbnail in the list follows the up axis.
  const small = '.dataset[aria-pressed="true"] img[src^="blob:"]';
  const src = await page.getAttribute(small, "src");
  await page.evaluate(() => (location.hash = location.hash.replace(/up=[^&]*/, "up=y")));
  await page.waitForFunction(({ small, src }) => document.querySelector(small).src !== src, { small, src }, { timeout: patience });
}

async function refusesOtherWorlds(page) {
  const folder = path.join(scratch, "worlds");
  mkdirSync(folder, { recursive: true });
  for (const [name, origin] of [["here", "0,0,0"], ["there", "500,0,0"]]) {
    const volume = path.join(folder, `${name}.nrrd`);
    run("generate", "gyroid", "--size", "17", "-o", volume);
    run("prepare", volume, "--name", name, "--origin", origin, "-o", path.join(folder, `${name}.mtd`));
  }
  await open(page, "#dataset=here&error=2&color_by=there", await serveFolder(folder));
  await notice(page, /"there" cannot color this surface: it is at another position than "here"/);
  await page.waitForFunction(() => !/color_by/.test(location.hash));
  await complete(page);
  await page.click('summary:has-text("Color by a field")');
  const offered = await page.locator('[aria-label="Color the surfaces by"] option').allTextContents();
  assert.deepEqual(offered.filter((name) => name === "there"), []);
}

// No number is under another element or cut off.
async function keepsNumbersLegible(page) {
  for (const more of ["slice=x&color_by=gyroid", "layout=four", "places=32,4,32,0.1"]) {
    await open(page, `#dataset=head&error=2&${more}`);
    await complete(page);
    await page.waitForTimeout(500);
    const found = await page.evaluate(() => {
      const boxes = (selector) => [...document.querySelectorAll(selector)].map((one) => one.getBoundingClientRect()).filter(({ width }) => width > 0);
      const [stage] = boxes(".stage");
      const numbers = boxes(".axis-numbers span");
      const others = boxes(".tools button, .legend, .orientation .end, .scale-bar, .picked");
      const isOver = (a, b) => a.left < b.right && a.right > b.left && a.top < b.bottom && a.bottom > b.top;
      const isCut = ({ left, right, top, bottom }) => left < stage.left || right > stage.right || top < stage.top || bottom > stage.bottom;
      return { numbers: numbers.length, bad: numbers.filter((one) => isCut(one) || others.some((other) => isOver(one, other))).length };
    });
    assert(found.numbers > 1 && found.bad === 0, JSON.stringify(found));
  }
}

async function undoes(page) {
  await open(page, "#dataset=gyroid&error=1");
  await complete(page);
  await page.focus(".stage canvas");
  await page.keyboard.press("p");
  await page.waitForFunction(() => /projection=orthographic/.test(location.hash));
  assert((await surfacePixels(page)).share > 0.03, "the surface is there without perspective, too");
  await page.click('summary:has-text("Bookmarks")');
  await page.fill(".bookmark-name", "flat");
  await page.keyboard.press("Enter");
  await page.focus(".stage canvas");
  await page.keyboard.press("Control+z");
  await page.waitForFunction(() => !/projection/.test(location.hash));
  await page.keyboard.press("Control+y");
  await page.waitForFunction(() => /projection=orthographic/.test(location.hash));
  await page.keyboard.press("p");
  await page.waitForFunction(() => !/projection/.test(location.hash));
  await page.click('.bookmark:has-text("flat")');
  await page.waitForFunction(() => /projection=orthographic/.test(location.hash));
}

async function colorsByAField(page) {
  // Grey where the other field is undefined, otherwise blue or red.
  await open(page, "#dataset=head&isovalue=300.5&error=2&axes=false&color=808080&colors=coolwarm");
  await complete(page);
  const plain = (await surfacePixels(page)).share;
  await page.click('summary:has-text("Color by a field")');
  await page.selectOption('[aria-label="Color the surfaces by"]', "gyroid");
  await page.waitForFunction(() => /color_by=gyroid/.test(location.hash));
  await page.waitForFunction(() => /Between vertices/.test(document.querySelector("details[open] .hint:not([hidden])")?.textContent ?? ""), null, { timeout: patience });
  await complete(page);
  const colored = (await surfacePixels(page)).share;
  assert(colored > plain + 0.002, `${colored} is red, ${plain} was`);
  assert.match(await page.textContent(".legend:not([hidden])"), /gyroid/);
  // The reported deviation is that of the displayed surface, and is smaller at full resolution.
  const deviation = async () => Number((await page.textContent(".panel")).match(/at most about ([\d.e+-]*\d)/)[1]);
  const coarse = { deviation: await deviation(), ...await complete(page) };
  await page.click('[aria-label="Qualities"] button:text-is("Exact")');
  await complete(page, ({ digest }) => digest !== coarse.digest);
  assert((await deviation()) < 0.7 * coarse.deviation, `${await deviation()} is less than ${coarse.deviation}`);
  // A new color range applies at once: all values are above it, and red.
  await page.waitForTimeout(1000);
  const type = async (which, value) => {
    await page.fill(`[aria-label="Value of the ${which} color of the surface's colors"]`, value);
    await page.keyboard.press("Enter");
  };
  await type("first", "-101");
  await type("last", "-100");
  await page.waitForFunction(() => /field_level=-100.5/.test(location.hash) && /field_window=1(&|$)/.test(location.hash));
  await page.waitForTimeout(500);
  const red = (await surfacePixels(page)).share;
  assert(red > colored + 0.002, `${red} is red, ${colored} was`);
  await type("last", "-102"); // Below the first end.
  assert.equal(await page.inputValue('[aria-label="Value of the last color of the surface\'s colors"]'), "-100");
  // So do a color map and the color of undefined values.
  await page.click('[role="radiogroup"][aria-label="Colors"] button:has-text("gray")');
  await page.waitForTimeout(500);
  assert((await surfacePixels(page)).share < 0.002, "nothing is red in gray");
  await page.fill('[aria-label="Color where there is no value"]', "#c02010");
  await page.waitForTimeout(500);
  assert((await surfacePixels(page)).share > 0.002, "places without a value are red");
}

// Runs the page in EMBEDDING.md with the address of this test.
async function runsTheExample(page) {
  const guide = readFileSync(new URL("../../../client/web/EMBEDDING.md", import.meta.url), "utf8");
  const [block] = guide.match(/^ {4}<!doctype html>\n(?: {4}.*\n)+/m);
  const text = block.replaceAll(/^ {4}/gm, "").replaceAll("https://volumes.example/", server.page);
  const around = `${server.page}around.html`;
  await page.route(around, (route) => route.fulfill({ contentType: "text/html", body: text }));
  await page.goto(around);
  assert.equal(await page.inputValue("input"), "500", "the slider starts at the isovalue");
  await page.evaluate(() => addEventListener("message", ({ data }) => (window.eye = data.state?.eye?.map(Math.round).join() ?? window.eye)));
  const facts = () => page.textContent("p");
  await page.waitForFunction(() => / triangles within [0-9.]+ voxels$/.test(document.querySelector("p").textContent), null, { timeout: patience });
  await page.waitForFunction(() => window.eye, null, { timeout: patience });
  const [before, eye] = [await facts(), await page.evaluate(() => window.eye)];
  await page.fill("input", "17"); // Emits the events of a user's drag: input, then change.
  await page.waitForFunction(
    (text) => document.querySelector("p").textContent !== text && / triangles within [0-9.]+ voxels$/.test(document.querySelector("p").textContent),
    before, { timeout: patience },
  );
  await page.waitForFunction((at) => window.eye !== at, eye, { timeout: patience }); // Another size is fitted.
}

async function hidesTools(page) {
  const around = `${server.page}around.html`;
  await page.route(around, (route) => route.fulfill({ contentType: "text/html", body:
    '<title>around</title><iframe src="/?embed#dataset=gyroid&error=2" width="500" height="200"></iframe>' }));
  await page.goto(around);
  const inside = page.frames().find((frame) => frame.url().includes("?embed"));
  await inside.waitForFunction(() => /final|Certified/i.test(document.body.textContent) && document.querySelector(".stage canvas"));
  const covered = () => inside.evaluate(() => {
    const over = [...document.querySelectorAll(".stage button, .stage .stage-hint, .stage .orientation, .stage .scale-bar")];
    const sizes = over.map((element) => element.getBoundingClientRect());
    return sizes.reduce((sum, { width, height }) => sum + width * height, 0) / (innerWidth * innerHeight);
  });
  const low = await covered();
  await page.locator("iframe").screenshot({ path: path.join(scratch, "low_frame.png") });
  assert(low < 0.06, `${low} of a low frame is covered`);
  assert(await inside.locator('[aria-label="Fullscreen"]').isVisible());
  await page.evaluate(() => (document.querySelector("iframe").height = 500));
  await inside.waitForFunction(() => innerHeight === 500);
  assert(await inside.locator('[aria-label="Fit the surface"]').isVisible(), "a high frame has its tools");
}

async function exchangesMessages(page) {
  // A page on the server's own host with the viewer in a frame.
  const around = `${server.page}around.html`;
  await page.route(around, (route) => route.fulfill({ contentType: "text/html", body:
    '<title>around</title><iframe src="/?embed#dataset=gyroid&error=2&isovalue=abc" width="700" height="500"></iframe>' }));
  await page.goto(around);
  const frame = page.frameLocator("iframe");
  await frame.locator(".stage canvas").waitFor();
  assert(await frame.locator(".panel").isHidden(), "the picture is alone");
  const said = await page.evaluate(() => new Promise((resolve) => {
    const heard = [];
    const viewer = document.querySelector("iframe").contentWindow;
    const say = (message) => viewer.postMessage(message, location.origin);
    const asking = setInterval(() => say({ multitetra: "get", id: "first" }), 300);
    window.addEventListener("message", ({ data }) => {
      heard.push(data);
      if (data.id === "first" && heard.filter(({ id }) => id === "first").length === 1) {
        clearInterval(asking);
        say({ multitetra: "set", id: "second", state: { isovalue: 0.25, error: 1, nonsense: 1, opacity: 7 } });
        say({ multitetra: "dance", id: "third" });
      }
      if (data.multitetra === "shown" && data.isovalue === 0.25 && data.isFinal) say({ multitetra: "picture", id: "fourth" });
      if (data.multitetra === "picture") resolve(heard.map((one) => (one.png ? { ...one, png: one.png.type } : one)));
    });
  }));
  const answer = (id) => said.find((one) => one.id === id);
  assert.equal(answer("first").state.dataset, "gyroid");
  assert.deepEqual(answer("first").ignored, ["isovalue"]);
  assert.equal(answer("first").state.maxTriangles, 500_000, "this browser draws without a graphics card");
  assert.equal(answer("second").state.isovalue, 0.25);
  assert.deepEqual(answer("second").ignored, ["nonsense", "opacity"]);
  assert.match(answer("third").text, /Unknown message "dance"; the messages are set, get/);
  assert.equal(answer("fourth").png, "image/png");
  assert(!JSON.stringify(said).includes("token"), "nothing of a token is told");
  // A page that listens later still receives the current state and the reasons for rejected settings.
  await page.goto(around);
  await page.frames()[1].waitForFunction(() => document.querySelector(".seal")?.textContent.startsWith("✓"), null, { timeout: patience });
  const late = await page.evaluate(() => new Promise((resolve) => {
    const heard = [];
    const say = (message) => document.querySelector("iframe").contentWindow.postMessage(message, location.origin);
    window.addEventListener("message", ({ data }) => {
      heard.push(data);
      if (data.id === "late") say({ multitetra: "set", state: { dataset: "nosuch" } });
      if (data.multitetra === "error") resolve(heard);
    });
    say({ multitetra: "get", id: "late" });
  }));
  assert.equal(late.find(({ multitetra }) => multitetra === "dataset").name, "gyroid");
  const shown = late.find(({ multitetra }) => multitetra === "shown");
  assert(shown.isFinal && shown.triangles > 0 && shown.surface === 0, JSON.stringify(shown));
  assert.match(late.find(({ multitetra }) => multitetra === "error").text, /nosuch/);
  // Naming the shown dataset again resolves the failure; surfaces of replaced isovalues are not reported.
  const back = await page.evaluate(() => new Promise((resolve) => {
    const heard = [];
    const say = (message) => document.querySelector("iframe").contentWindow.postMessage(message, location.origin);
    window.addEventListener("message", ({ data }) => {
      heard.push(data);
      if (data.id === "refused") say({ multitetra: "set", id: "back", state: { dataset: "gyroid", isovalue: 0.4, minComponent: 3 } });
      if (data.multitetra === "shown" && data.isFinal && data.isovalue === 0.4) resolve(heard);
    });
    say({ multitetra: "set", id: "refused", state: { dataset: "nosuch" } });
  }));
  assert.match(back.find(({ multitetra }) => multitetra === "error").text, /nosuch/);
  assert.equal(back.find(({ id }) => id === "refused").state.dataset, "gyroid");
  assert.deepEqual([...new Set(back.filter(({ multitetra }) => multitetra === "shown").map(({ isovalue }) => isovalue))], [0.4]);
  assert(await frame.locator(".notice").isHidden(), "the failure is no longer shown");
}

// The numbers of axes in files are rounded, so that their right angles are, too. Both sides compute the bounds of quantized
// samples from the longest diagonal of a cell.
async function showsRoundedAxes(page) {
  const folder = path.join(scratch, "rounded");
  mkdirSync(folder, { recursive: true });
  const volume = path.join(scratch, "rounded.nrrd");
  writeNrrd(volume, 64, samplesOf(64, (x, y, z) => 900 - 30 * Math.hypot(x - 31, y - 30, z - 33)),
    "space: left-posterior-superior\nspace directions: (1,0.0001,0) (0,1,0) (0,0,1)\n");
  run("prepare", volume, "--name", "rounded", "--force", "-o", path.join(folder, "rounded.mtd"));
  await open(page, "#dataset=rounded&isovalue=300.5&error=0.25", await serveFolder(folder));
  const shown = await complete(page);
  assert(shown.triangles > 1000, JSON.stringify(shown));
}
