// The viewer's connection, token, keyboard and address, in a real browser against real servers.
//
//   node connection_test.mjs SERVER_PROGRAM VIEWER_FOLDER SCRATCH_FOLDER
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { readdirSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { createServer } from "node:http";
import net from "node:net";
import path from "node:path";
import { gzipSync } from "node:zlib";

import {
  atKeyboard, complete, finish, newToken, notice, open, scratch, serve, serveFolder, server, surfacePixels, test,
} from "./in_a_browser.mjs";

const tokens = path.join(scratch, "tokens");
rmSync(tokens, { force: true });
const token = newToken("alice", tokens);
const guarded = await serve("--tokens", tokens);

await test("ReconnectsAfterTheServerDied", reconnects, { isFresh: true });
await test("RequestsATokenUntilItIsValid", requestsAToken);
await test("RemovesTheTokenFromTheAddress", hidesItsToken, { isFresh: true });
await test("SendsATokenToItsServerOnly", keepsItsToken);
await test("AppliesAnEditedAddress", appliesAnEditedAddress);
await test("ReportsAndIgnoresUnreadableSettings", reportsIgnoredSettings);
await test("OffersNoSlicesOfSurfacesOnly", offersNoSlices);
await test("ShowsHowFarAVolumeIsRead", showsReading);
await test("LivesAsAModuleInAnotherPage", livesInAnotherPage, { isFresh: true });
await finish();

// ----

async function reconnects(page) {
  await page.addInitScript(() => {
    window.attempts = 0;
    window.WebSocket = class extends WebSocket {
      constructor(...words) {
        super(...words);
        ++window.attempts;
      }
    };
  });
  await open(page, "#dataset=gyroid");
  const before = await complete(page);
  await page.fill('[aria-label="Isovalue"]', "0.3");
  page.mayLoseItsConnection = true;
  await Promise.all([page.press('[aria-label="Isovalue"]', "Enter"), server.stop("SIGKILL")]);
  await notice(page, /No connection to the server/);
  assert.equal(await page.textContent(".state b"), "Not connected");
  assert((await surfacePixels(page)).share > 0.03, "the surface stays");
  const button = '.notice button:has-text("Try now")';
  await page.focus(button);
  for (let i = 0; i < 2; ++i) {
    const attempts = await page.evaluate(() => window.attempts);
    await page.keyboard.press("Enter");
    await page.waitForFunction((before) => window.attempts > before, attempts);
    await notice(page, /Retrying in/);
    assert.equal(await atKeyboard(page), "button", "the keyboard stays at the button");
    assert(await page.locator(button).evaluate((one) => one === document.activeElement));
  }
  await server.start();
  await page.keyboard.press("Enter");
  await page.waitForSelector(".notice", { state: "hidden" });
  assert.equal(await atKeyboard(page), "canvas", "the keyboard is at the picture");
  await complete(page, (shown) => shown.digest !== before.digest);
  const { hash } = new URL(page.url());
  await page.keyboard.press("ArrowLeft");
  await page.waitForFunction((old) => location.hash !== old && /eye=/.test(location.hash), hash);
}

// The process that reads the volume is stopped meanwhile, so that the page sees it.
async function showsReading(page) {
  const sizes = [512, 512, 250];
  const ramp = Buffer.from(Int16Array.from({ length: sizes[0] + sizes[1] + sizes[2] }, (_, at) => at).buffer);
  const rows = Array.from({ length: sizes[1] * sizes[2] }, (_, at) => 2 * ((at % sizes[1]) + Math.floor(at / sizes[1])));
  const samples = Buffer.concat(rows.map((first) => ramp.subarray(first, first + 2 * sizes[0]))); // x + y + z.
  const file = path.join(scratch, "ramp.nrrd");
  const head = `NRRD0004\ntype: int16\ndimension: 3\nsizes: ${sizes.join(" ")}\nendian: little\nencoding: gzip\n\n`;
  writeFileSync(file, Buffer.concat([Buffer.from(head), gzipSync(samples, { level: 1 })]));
  const cache = path.join(scratch, "volumes");
  rmSync(cache, { recursive: true, force: true });
  const reading = await serveFolder(file, "--volume-cache", cache, "--threads", "1");
  const { pid } = reading.process;
  const readers = readdirSync(`/proc/${pid}/task`).flatMap((task) => readFileSync(`/proc/${pid}/task/${task}/children`, "utf8").match(/\d+/g) ?? []);
  assert(readers.length > 0, "the volume is being read");
  for (const reader of readers) process.kill(Number(reader), "SIGSTOP");
  await open(page, "#dataset=ramp", reading);
  await notice(page, /^Reading "ramp": \d+ %\.$/);
  const early = await page.request.get(`${reading.page}v1/datasets/ramp`);
  assert.deepEqual([early.status(), early.headers()["retry-after"]], [503, "1"]);
  for (const reader of readers) process.kill(Number(reader), "SIGCONT");
  await complete(page);
  assert.doesNotMatch(await page.textContent(".notice"), /Reading/);
}

async function requestsAToken(page) {
  await open(page, "#dataset=gyroid", guarded);
  await notice(page, /requires a token/);
  assert.equal(await atKeyboard(page), "input");
  await page.keyboard.type("mt_wrong");
  await page.keyboard.press("Enter");
  await notice(page, /does not accept the token/);
  await page.waitForFunction(() => {
    const { selectionStart, selectionEnd, value } = document.activeElement;
    return value === "mt_wrong" && selectionStart === 0 && selectionEnd === value.length;
  });
  assert.equal(await page.locator(".notice form").count(), 1, "what was typed is there");
  await page.keyboard.type(` ${token} `); // With spaces, as when copied.
  await page.keyboard.press("Enter");
  await complete(page);
  assert(await page.locator(".notice").isHidden());
  assert.equal(await atKeyboard(page), "canvas");
  await page.reload();
  await complete(page);
  assert(!page.url().includes(token));
}

async function hidesItsToken(page) {
  await open(page, `#dataset=gyroid&token=${token}`, guarded);
  await complete(page);
  await page.waitForFunction(() => !location.href.includes("token"));
  // Also if the page is open already and has an invalid token.
  await page.goto("about:blank");
  const other = await page.context().browser().newPage();
  await open(other, "#dataset=gyroid&token=mt_wrong", guarded);
  await notice(other, /does not accept the token/);
  await other.evaluate((said) => (location.hash = `dataset=gyroid&token=${said}`), token);
  await complete(other);
  await other.waitForFunction(() => !location.href.includes("token"));
  await other.close();
}

async function keepsItsToken(page) {
  await open(page, `#dataset=gyroid&token=${token}`, guarded);
  await complete(page);
  let visits = 0;
  const thief = net.createServer((socket) => {
    ++visits;
    socket.destroy();
  });
  await new Promise((resolve) => thief.listen(0, "127.0.0.1", resolve));
  page.maySay = /Content Security Policy/;
  await page.goto(`${guarded.page}?server=ws://127.0.0.1:${thief.address().port}/v1/stream`);
  await notice(page, /cannot connect to "ws:/);
  await page.waitForTimeout(1200); // It does not retry.
  assert.equal(visits, 0);
  thief.close();
  await open(page, "#dataset=gyroid", guarded);
  await complete(page);
}

async function appliesAnEditedAddress(page) {
  await open(page, "#dataset=gyroid&wireframe=true");
  const before = await complete(page);
  await edit(page, "dataset=gyroid&isovalue=0.3&error=2");
  const after = await complete(page, ({ digest }) => digest !== before.digest);
  assert.equal(await page.inputValue('[aria-label="Isovalue"]'), "0.3");
  assert(after.triangles > 0 && (await page.locator(".notice").isHidden()));
  assert(!page.url().includes("wireframe"), "what is not said is as usual");
  await edit(page, "dataset=head");
  await complete(page, ({ digest }) => digest !== after.digest);
  assert.equal(await page.getAttribute('.dataset[data-name="head"]', "aria-pressed"), "true");
  await edit(page, "error=1.5"); // Applies to the displayed surface.
  await saysSettings(page, "dataset=head&error=1.5");
}

async function reportsIgnoredSettings(page) {
  await open(page, "#dataset=gyroid&isovalue=0.3&error=-4&shading=velvet");
  await notice(page, /Ignored in the URL: error=-4, shading=velvet\./);
  const shown = await complete(page);
  await saysSettings(page, "dataset=gyroid&isovalue=0.3");
  await edit(page, "dataset=gyroid&isovalue=much&<b>x</b>=1");
  await notice(page, /isovalue=much, <b>x<\/b>=1/);
  await saysSettings(page, "dataset=gyroid&isovalue=0.3");
  assert.equal(await page.inputValue('[aria-label="Isovalue"]'), "0.3");
  await edit(page, "dataset=corner_of_the_moon&isovalue=0.3");
  await notice(page, /No dataset named "corner_of_the_moon"/);
  await saysSettings(page, "dataset=gyroid&isovalue=0.3");
  assert.equal((await complete(page)).digest, shown.digest);
}

// A server or a token that permits surfaces only: no slices, not even of the address, and no errors.
async function offersNoSlices(page) {
  const where = await serve("--surfaces-only");
  await open(page, "#dataset=head&error=2&layout=four&slice=x&clip=y", where);
  await complete(page);
  const slices = page.locator('[aria-label="Slices beside the surface"]');
  assert.equal(await slices.getAttribute("aria-disabled"), "true");
  assert.match(await slices.getAttribute("data-tip"), /surfaces only/);
  assert(await page.isHidden(".slice-views"));
  assert(await page.isHidden(".notice"));
  await page.click('summary:has-text("Slices")');
  assert(await page.isHidden('[aria-label="Plane"]'));
  assert((await surfacePixels(page)).share > 0.03, "the cut surface is shown");
  await slices.click({ force: true }); // Playwright waits for enabled elements.
  await notice(page, /permits surfaces only/);
}

// Sets the address's hash like a user's edit.
async function edit(page, hash) {
  await page.evaluate((said) => (location.hash = said), `${hash}&follow_view=false`);
}

// Waits until the address has exactly these settings, ignoring those of the camera.
function saysSettings(page, settings) {
  return page.waitForFunction(
    (wanted) => location.hash.slice(1).replace(/&(eye|target|follow_view|occlusion)=[^&]*/g, "") === wanted, settings);
}

// The npm module, in a page of another origin, which has styles of its own.
async function livesInAnotherPage(page) {
  const web = new URL("../../../client/web/", import.meta.url).pathname;
  const built = path.resolve(scratch, "module");
  execFileSync(path.join(web, "node_modules/.bin/vite"), ["build", "--config", "vite.module.config.ts", "--outDir", built, "--emptyOutDir", "--logLevel", "error"], { cwd: web });
  const types = { html: "text/html", js: "text/javascript", css: "text/css", wasm: "application/wasm" };
  const journalPage = `<title>journal</title><link rel="icon" href="data:,"><link rel="stylesheet" href="/style.css">
    <script type="importmap">{ "imports": { "multitetra-viewer": "/multitetra-viewer.js" } }</script>
    <p class="notice">A word of the page.</p><div id="place" style="width: 600px; height: 400px"></div>`;
  const journal = createServer(({ url }, reply) => {
    reply.setHeader("Content-Type", types[url === "/" ? "html" : url.split(".").pop()]);
    reply.end(url === "/" ? journalPage : readFileSync(path.join(built, url)));
  });
  await new Promise((resolve) => journal.listen(0, "127.0.0.1", resolve));
  const host = `http://127.0.0.1:${journal.address().port}`;
  const allowing = await serve("--allow-origin", host);
  page.mayBeAt(new URL(host).host);
  page.mayLoseItsConnection = true;
  await page.emulateMedia({ colorScheme: "dark" });
  await page.goto(`${host}/`);
  const said = await page.evaluate(async (server) => {
    const { Viewer } = await import("multitetra-viewer");
    const place = document.getElementById("place");
    const thrown = (act) => { try { act(); return ""; } catch (error) { return `${error.name}: ${error.message}`; } };
    const refused = [thrown(() => new Viewer(place, { server, error: -3 }))];
    const viewer = new Viewer(place, { server, dataset: "gyroid", isovalue: 0, error: 1, simplify: true });
    refused.push(thrown(() => viewer.on("state of things", () => {})));
    const heard = [];
    for (const kind of ["dataset", "shown", "error"]) viewer.on(kind, (what) => heard.push([kind, what]));
    const until = (test) => new Promise((resolve) => {
      const look = () => (heard.some(test) ? resolve() : setTimeout(look, 50));
      look();
    });
    const ignored = viewer.set({ isovalue: 0.25, error: "small", nonsense: 1, surfaces: [{ isovalue: -0.5, opacity: 0.4 }] });
    for (const at of [0, 1]) await until(([kind, what]) => kind === "shown" && what.surface === at && what.isFinal);
    const png = await viewer.picture();
    viewer.set({ dataset: "nosuch" });
    await until(([kind]) => kind === "error");
    const lonely = new Viewer(document.body.appendChild(document.createElement("div")), { server: "http://127.0.0.1:1/" });
    const connection = await new Promise((resolve) => lonely.on("error", resolve));
    const notice = document.querySelector("body > div:last-child .notice").textContent;
    lonely.dispose();
    const { color, position } = getComputedStyle(document.querySelector(".notice"));
    const told = { notice, heard: JSON.parse(JSON.stringify(heard)), connection, ignored, refused, png: png.type, surfaces: viewer.get().surfaces, style: { color, position } };
    viewer.dispose();
    return told;
  }, allowing.page);
  journal.close();
  assert.match(said.refused[0], /TypeError: Unknown or invalid: error/);
  assert.match(said.refused[1], /TypeError: No event "state of things"; the events are state,/);
  assert.deepEqual(said.ignored, ["error", "nonsense"]);
  assert.equal(said.heard.find(([kind]) => kind === "dataset")[1].name, "gyroid");
  const previews = said.heard.filter(([kind, { spacing }]) => kind === "shown" && spacing > 1);
  assert(previews.every(([, { errorWorld, errorVoxels }]) => errorWorld === null && errorVoxels === null), "previews have no bound");
  assert.match(said.heard.find(([kind]) => kind === "error")[1], /nosuch/);
  assert.equal(said.png, "image/png");
  assert.match(said.connection, /No connection to the server/);
  assert(said.notice.includes(`--allow-origin ${host}`), said.notice);
  assert.equal(said.surfaces[0].visible, true, "fields of a surface have defaults");
  assert.deepEqual(said.style, { color: "rgb(0, 0, 0)", position: "static" }, "the page keeps its styles");
}
