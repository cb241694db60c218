// Pages without a server, in a real browser: an exported folder behind a web server that answers requests for ranges, and
// behind one that does not.
//
//   node static_test.mjs SERVER_PROGRAM VIEWER_FOLDER SCRATCH_FOLDER
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { existsSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { createServer } from "node:http";
import path from "node:path";

import { complete, finish, notice, patience, run, scratch, surfacePixels, test } from "./in_a_browser.mjs";

const program = process.argv[2];
const folder = path.join(scratch, "page");
rmSync(folder, { recursive: true, force: true });
run("generate", "gyroid", "--size", "65", "-o", path.join(scratch, "beat.nrrd"));
run("prepare", ...["beat", "head"].map((name) => path.join(scratch, `${name}.nrrd`)), "--time-series", "beat", "--times", "0:0.5", "-o", path.join(scratch, "datasets"));
execFileSync(program, ["export", path.join(scratch, "datasets"), "--page", folder, "--quiet"]);
const types = { ".html": "text/html", ".js": "text/javascript", ".css": "text/css", ".wasm": "application/wasm", ".svg": "image/svg+xml" };
let fetched = []; // The ranges of prepared files, as "head.mtd 0-262143".
const [withRanges, whole] = await Promise.all([webServer(true), webServer(false)]);

await test("ShowsTheSurfaceOfTheServerFromFiles", showsTheSurface);
await test("FetchesOnlyWhatIsNew", fetchesWhatIsNew);
await test("BeginsAgainWhenItsStorageIsFull", keepsABoundedNumber);
await test("ShowsLargeSurfacesFineNearTheEye", followsTheView);
await test("StepsThroughTheTimesOfASeries", stepsThroughTimes);
await test("SamplesFilesOnPlanesAndAtPlaces", samplesFiles);
await test("SaysWhatNeedsAServer", saysWhatNeedsAServer);
await test("RefusesAWebServerWithoutRanges", refusesWholeFiles);
await finish();

// ----

async function webServer(hasRanges) {
  const server = createServer(({ url, headers }, reply) => {
    const name = decodeURIComponent(new URL(url, "http://localhost").pathname);
    const file = path.join(folder, name.endsWith("/") ? `${name}index.html` : name);
    if (!existsSync(file)) return reply.writeHead(404).end();
    const bytes = readFileSync(file);
    const type = { "Content-Type": types[path.extname(file)] ?? "application/octet-stream" };
    const range = hasRanges && /^bytes=(\d+)-(\d+)$/.exec(headers.range ?? "");
    if (!range) return reply.writeHead(200, type).end(bytes);
    fetched.push(`${path.basename(file)} ${range[1]}-${range[2]}`);
    const part = bytes.subarray(Number(range[1]), Number(range[2]) + 1);
    const place = `bytes ${range[1]}-${Number(range[1]) + part.length - 1}/${bytes.length}`;
    reply.writeHead(206, { ...type, ETag: '"1"', "Content-Range": place }).end(part);
  });
  await new Promise((resolve) => server.listen(0, "127.0.0.1", resolve));
  server.unref();
  return `http://127.0.0.1:${server.address().port}/`;
}

function open(page, hash, where = withRanges) {
  page.mayBeAt(new URL(where).host);
  return page.goto(`${where}${hash}&follow_view=false`);
}

// All tetrahedra, as the program itself marches them.
function reference(name, depth, isovalue) {
  const file = path.join(scratch, "datasets", `${name}.mtd`);
  const words = ["reference", file, "--level", depth, `--isovalue=${isovalue}`, "-o", path.join(scratch, "all.ply"), "--json"];
  return JSON.parse(execFileSync(program, words, { encoding: "utf8", stdio: ["ignore", "pipe", "ignore"] }));
}

async function showsTheSurface(page) {
  await open(page, "#dataset=head&isovalue=-200.5");
  const { triangles } = await complete(page);
  assert.equal(triangles, reference("head", "17", "-200.5").triangles);
  assert.match(await page.textContent(".bar"), /full resolution.*0 voxels/);
  assert.match(await page.textContent(".seal"), /✓ Watertight, full resolution/);
  assert((await surfacePixels(page)).share > 0.03);
  const download = page.waitForEvent("download");
  await page.click('summary:has-text("Export"), button:has-text("Export")');
  await page.click('.actions button:has-text("PLY")');
  const ply = path.join(scratch, "from_files.ply");
  await (await download).saveAs(ply);
  const volume = path.join(scratch, "datasets/head.mtd");
  execFileSync(program, ["certify", ply, "--volume", volume, "--isovalue=-200.5", "--error", "0", "--lattice", "5", "--allow-rounding", "--quiet"]);
}

async function fetchesWhatIsNew(page) {
  fetched = [];
  await open(page, "#dataset=gyroid&isovalue=0.1");
  const { digest } = await complete(page);
  const first = fetched.length;
  assert(first > 0);
  await page.fill('[aria-label="Isovalue"]', "0.15");
  await page.press('[aria-label="Isovalue"]', "Enter");
  await complete(page, (shown) => shown.digest !== digest);
  assert.equal(new Set(fetched).size, fetched.length, `nothing is fetched twice: ${fetched}`);
  fetched = [];
  await page.reload();
  await complete(page);
  assert.deepEqual(fetched, ["gyroid.mtd 0-262143"], "the rest is in the browser's storage");
}

// Storage for 2^15 blocks, filled with those of another file.
async function keepsABoundedNumber(page) {
  await open(page, "#dataset=gyroid&isovalue=0.1");
  const { digest } = await complete(page);
  const count = (fill) => page.evaluate(async (size) => {
    const done = (request) => new Promise((resolve, reject) => Object.assign(request, { onsuccess: () => resolve(request.result), onerror: () => reject(request.error) }));
    const database = await done(indexedDB.open("multitetra-files", 1));
    const store = database.transaction("blocks", "readwrite").objectStore("blocks");
    for (let i = 0; i < size; ++i) store.put(new Uint8Array(1), ["other", i]);
    const found = await done(store.count());
    database.close();
    return found;
  }, fill);
  assert(await count(2 ** 15) >= 2 ** 15);
  await open(page, "#dataset=beat&isovalue=0.1");
  await complete(page, (shown) => shown.digest !== digest);
  let kept = await count(0);
  for (const until = Date.now() + patience; kept >= 2 ** 15 && Date.now() < until; kept = await count(0)) await page.waitForTimeout(200);
  assert(kept > 0 && kept < 2 ** 14, `${kept} blocks are kept`);
}

async function stepsThroughTimes(page) {
  await open(page, "#dataset=beat&isovalue=0.1");
  const first = await complete(page);
  await page.focus(".stage canvas");
  assert.equal(first.triangles, reference("beat.t0000", "17", "0.1").triangles);
  await page.keyboard.press(".");
  const second = await complete(page, ({ digest }) => digest !== first.digest);
  assert.match(page.url(), /t=0\.5/);
  assert.equal(second.triangles, reference("beat.t0001", "17", "0.1").triangles);
}

// An index that permits a page only some of the samples.
async function followsTheView(page) {
  const index = JSON.parse(readFileSync(path.join(folder, "datasets.json"), "utf8"));
  writeFileSync(path.join(folder, "small.json"), JSON.stringify({ ...index, max_surface_megabytes: 0.2 }));
  page.mayBeAt(new URL(withRanges).host);
  await page.goto(`${withRanges}?static=small.json#dataset=head&isovalue=-200.5`);
  await notice(page, /^All samples are shown near the eye.* A server shows all\./);
  const shown = () => page.evaluate(() => ({
    triangles: Number(document.querySelector(".fact.triangles b").textContent.replace(/\D/g, "")),
    seal: document.querySelector(".seal").textContent,
    picture: location.hash,
  }));
  const before = await shown();
  assert.match(before.seal, /Watertight/);
  const all = reference("head", "17", "-200.5").triangles;
  assert(before.triangles > 0.05 * all && before.triangles < 0.9 * all, `${before.triangles} of ${all} triangles`);
  await page.focus(".stage canvas");
  for (let i = 0; i < 30; ++i) await page.keyboard.press("ArrowLeft");
  for (let i = 0; (await shown()).triangles === before.triangles; ++i) {
    assert(i < patience / 200, "another side is fine when it is near");
    await page.waitForTimeout(200);
  }
}

async function samplesFiles(page) {
  const view = "eye=16,-60,16&target=16,16,16";
  await open(page, `#dataset=gyroid&isovalue=0.5&visible=false&axes=false&${view}&slice=y&slice_colors=coolwarm`);
  await page.waitForFunction(() => document.querySelector(".state b").textContent === "Hidden", null, { timeout: patience });
  const isRed = async () => (await surfacePixels(page)).share > 0.05;
  for (let i = 0; !(await isRed()) && i < 50; ++i) await page.waitForTimeout(200);
  assert(await isRed(), "samples are shown");
  const canvas = await page.locator(".stage canvas").boundingBox();
  await page.mouse.click(canvas.x + canvas.width / 2, canvas.y + canvas.height / 2);
  await page.waitForFunction(() => /Value -?[\d.e-]+/.test(document.querySelector(".picked .field")?.textContent ?? ""), null, { timeout: patience });
  assert.match(await page.textContent(".picked"), /sample [\d.]+, 16/);
}

async function saysWhatNeedsAServer(page) {
  await open(page, "#dataset=gyroid&shading=field");
  await notice(page, /^Shading by the field needs \("smooth" and "facets" do not\) a server: this page reads files alone\./);
  assert.match(await page.textContent(".panel"), /read from files without a server\. Allowed errors, budgets/);
  assert.equal(await page.locator('[aria-label="Allowed error"]').count(), 0);
}

async function refusesWholeFiles(page) {
  await open(page, "#static=head.mtd", whole);
  await notice(page, /ignores ranges and would send "head\.mtd" as a whole, as Python's http\.server does: use nginx/);
  assert.match(page.url(), /\?static=head\.mtd#/);
}
