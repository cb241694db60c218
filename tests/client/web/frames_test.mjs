// Frames of the viewer in a page around them, in a real browser: many on one page, and scrolling past them.
//
//   node frames_test.mjs SERVER_PROGRAM VIEWER_FOLDER SCRATCH_FOLDER
import assert from "node:assert/strict";

import { finish, maxScenes, patience, server, surfaceShares, test } from "./in_a_browser.mjs";

await test("DrawsEveryFrameThatIsSeen", drawsAllFrames, { viewport: { width: 500, height: 700 } });
await test("SaysWhyAFrameIsBlank", saysWhyItIsBlank, { viewport: { width: 1000, height: 560 } });
await test("ScrollsPastAFrame", scrollsPast, { viewport: { width: 700, height: 600 } });
await test("ScrollsPastAFrameWithOneFinger", scrollsWithAFinger, { viewport: { width: 500, height: 600 }, hasTouch: true });
await finish();

// ----

function frame(style) {
  return `<iframe src="/?embed#dataset=gyroid&error=2&follow_view=false" style="border: 0; display: block; ${style}"></iframe>`;
}

// Opens a page on the server's own host; it keeps the messages of its frames.
async function openAround(page, body) {
  const around = `${server.page}around.html`;
  await page.route(around, (route) => route.fulfill({ contentType: "text/html", body:
    `<title>around</title><body style="margin: 0"><script>heard = []; addEventListener("message", ({ source, data }) => heard.push({ source, data }))</script>${body}` }));
  await page.goto(around);
}

function isComplete(frame) {
  return frame.waitForFunction(() => document.querySelector(".state b")?.textContent === "Complete", null, { timeout: patience });
}

function noticeOf(frame) {
  return frame.evaluate(() => {
    const notice = document.querySelector(".notice");
    return notice && !notice.hidden ? notice.textContent : "";
  });
}

// Whether the scenes of all these frames have a surface on the screen.
async function areDrawn(page, places) {
  const boxes = await Promise.all(places.map((at) => page.locator("iframe").nth(at).boundingBox()));
  for (const until = Date.now() + 20_000; Date.now() < until;) {
    if ((await surfaceShares(page, boxes)).every((share) => share > 0.02)) return true;
    await page.waitForTimeout(300);
  }
  return false;
}

async function drawsAllFrames(page) {
  page.maySay = /WebGL/;
  const count = maxScenes + 2;
  await openAround(page, frame("width: 500px; height: 400px").repeat(count));
  const frames = page.frames().slice(1);
  assert.equal(frames.length, count);
  for (let at = 0; at < count; ++at) {
    await page.locator("iframe").nth(at).scrollIntoViewIfNeeded();
    await isComplete(frames[at]);
  }
  assert(await areDrawn(page, [count - 1]), "the last frame is drawn");
  await page.evaluate(() => scrollTo(0, 0));
  assert(await areDrawn(page, [0]), "the first frame is drawn again");
  for (const one of frames) assert.equal(await noticeOf(one), "");
}

async function saysWhyItIsBlank(page) {
  page.maySay = /WebGL/;
  const count = maxScenes + 2;
  await openAround(page, `<div style="display: grid; grid-template-columns: repeat(6, 1fr)">${frame("width: 160px; height: 180px").repeat(count)}</div>`);
  const frames = page.frames().slice(1);
  const blank = async () => (await Promise.all(frames.map(noticeOf))).map((text, at) => (/took the graphics/.test(text) ? at : -1)).filter((at) => at >= 0);
  for (const until = Date.now() + patience; (await blank()).length < 2;) {
    assert(Date.now() < until, "two frames more than a browser draws say so");
    await page.waitForTimeout(300);
  }
  const gone = await blank();
  const others = [...frames.keys()].filter((at) => !gone.includes(at));
  for (const at of others) await isComplete(frames[at]);
  assert(await areDrawn(page, others), "all others have a surface");
  const said = await page.evaluate((at) => new Promise((resolve) => {
    const viewer = document.querySelectorAll("iframe")[at].contentWindow;
    const own = () => heard.filter(({ source }) => source === viewer).map(({ data }) => data);
    viewer.postMessage({ multitetra: "picture", id: "p" }, location.origin);
    setInterval(() => own().some(({ id }) => id === "p") && resolve(own()), 100);
  }), gone[0]);
  assert.match(said.find(({ id }) => id === "p").text, /^No picture: The browser took/);
  assert(said.some(({ multitetra, id, text }) => multitetra === "error" && id === undefined && /took the graphics/.test(text)));
  await frames[gone[0]].click("text=Show it again");
  assert(await areDrawn(page, [gone[0]]), "the frame begins again");
}

async function scrollsPast(page) {
  await openAround(page, `${frame("width: 700px; height: 500px")}<div style="height: 3000px"></div>`);
  const [, one] = page.frames();
  await isComplete(one);
  const eye = () => page.evaluate(() => new Promise((resolve) => {
    const id = Math.random();
    addEventListener("message", ({ data }) => data.id === id && resolve(data.state.eye));
    frames[0].postMessage({ multitetra: "get", id }, location.origin);
  }));
  const wheel = async () => {
    await page.mouse.move(350, 200);
    await page.mouse.wheel(0, 100);
    await page.waitForTimeout(700);
    return page.evaluate(() => scrollY);
  };
  await page.waitForTimeout(600);
  const before = await eye();
  const hint = one.waitForSelector(".gesture-hint:not([hidden])");
  assert(await wheel() > 50, "the page scrolls");
  assert.match(await (await hint).textContent(), /Ctrl \+ scroll/);
  await one.waitForSelector(".gesture-hint", { state: "hidden" });
  assert.deepEqual(await eye(), before);
  await page.evaluate(() => scrollTo(0, 0));
  await page.keyboard.down("Control");
  assert.equal(await wheel(), 0);
  await page.keyboard.up("Control");
  const length = ([x, y, z]) => Math.hypot(x - 16, y - 16, z - 16);
  const factor = length(await eye()) / length(before);
  assert(factor > 1.02 && factor < 1.3, `Ctrl and the wheel zoom: ${factor}`);
  await page.evaluate(() => frames[0].postMessage({ multitetra: "set", state: { gestures: "all" } }, location.origin));
  await page.waitForTimeout(300);
  assert.equal(await wheel(), 0, "all gestures are the frame's");
}

async function scrollsWithAFinger(page) {
  await openAround(page, `${frame("width: 500px; height: 500px")}<div style="height: 3000px"></div>`);
  await isComplete(page.frames()[1]);
  const devtools = await page.context().newCDPSession(page);
  const touch = (type, ...points) => devtools.send("Input.dispatchTouchEvent", { type, touchPoints: points.map(([x, y], id) => ({ x, y, id })) });
  const hint = page.frames()[1].waitForSelector(".gesture-hint:not([hidden])");
  await touch("touchStart", [250, 400]);
  for (let y = 390; y >= 200; y -= 10) await touch("touchMove", [250, y]);
  await touch("touchEnd");
  assert(await page.evaluate(() => scrollY) > 100, "one finger scrolls the page");
  assert.match(await (await hint).textContent(), /two fingers/);
  await page.waitForTimeout(600); // It scrolls on for a while.
  await page.evaluate(() => scrollTo(0, 0));
  const canvas = page.frames()[1].locator(".stage canvas");
  const picture = async () => (await canvas.screenshot()).toString("base64");
  const before = await picture();
  await touch("touchStart", [200, 250], [300, 250]);
  for (let at = 10; at <= 80; at += 10) await touch("touchMove", [200 + at, 250 + at], [300 + at, 250 + at]);
  await touch("touchEnd");
  await page.waitForTimeout(800);
  assert.equal(await page.evaluate(() => scrollY), 0, "two fingers do not");
  assert.notEqual(await picture(), before, "two fingers rotate");
}
