// Measures how long the viewer takes to complete a surface, and for how long the main thread of the page is blocked.
//
//   node long_tasks.mjs ADDRESS [--undrawn] [--then ISOVALUE]
//   node long_tasks.mjs 'http://127.0.0.1:7480/#dataset=head&isovalue=300.5&error=0.5' --then 310.5
//   node long_tasks.mjs 'http://127.0.0.1:7480/#dataset=head&isovalue=500.5&error=0&surfaces=1200.5,7fb3d5' --undrawn
//
// --then types another isovalue into the open page once the first surface is complete, to measure it without the start
// of the page. The last example shows two surfaces, which load concurrently. The measurement ends with the first
// dataset's thumbnail. A browser without a graphics card draws on the processor and
// blocks the page: --undrawn skips the drawing, but nothing before it.
//
// Prints the texts of the status bar with the milliseconds since the page was opened or the isovalue was entered
// ("Complete": all steps were received, checked and uploaded to the graphics card); the tasks above 50 ms that the
// browser reports, with those of the first second, in which the page starts, listed separately; the processor time of
// the main thread; and the final state. Wall times depend on other load of the machine.
import { createRequire } from "node:module";

const address = process.argv[2] ?? "http://127.0.0.1:7480/#error=0";
const installed = createRequire(new URL("../../../client/web/package.json", import.meta.url));
const { chromium } = installed("playwright-core");
const browser = await chromium.launch({
  executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium",
  args: ["--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"],
});
const page = await browser.newPage({ viewport: { width: 800, height: 600 } });
await page.addInitScript(() => {
  window.longTasks = [];
  new PerformanceObserver((list) => {
    for (const { startTime, duration } of list.getEntries()) {
      window.longTasks.push([Math.round(startTime), Math.round(duration)]);
    }
  }).observe({ type: "longtask", buffered: true });
  window.states = [];
  window.statesBegin = 0;
  new MutationObserver(() => {
    const word = document.querySelector(".state b")?.textContent;
    if (word && word !== window.states.at(-1)?.[1]) {
      window.states.push([Math.round(performance.now() - window.statesBegin), word]);
    }
  }).observe(document, { subtree: true, childList: true, characterData: true });
});
if (process.argv.includes("--undrawn")) {
  await page.addInitScript(() => {
    for (const name of ["drawElements", "drawArrays", "clear", "blitFramebuffer"]) {
      WebGL2RenderingContext.prototype[name] = () => {};
    }
  });
}
const devtools = await page.context().newCDPSession(page);
await devtools.send("Performance.enable");
await page.goto(address);
await complete();
await tellStates("opened");
const then = process.argv.indexOf("--then");
if (then > 0) {
  await page.evaluate(() => {
    const begin = () => {
      window.states = [[0, window.states.at(-1)[1]]];
      window.statesBegin = performance.now();
    };
    document.querySelector('[aria-label="Isovalue"]').addEventListener("change", begin, { capture: true, once: true });
  });
  await page.fill('[aria-label="Isovalue"]', process.argv[then + 1]);
  await page.press('[aria-label="Isovalue"]', "Enter");
  await complete();
  await tellStates(`isovalue ${process.argv[then + 1]}`);
}
await page.waitForSelector('.dataset img[src^="blob:"]', { timeout: 600_000 });
const { metrics } = await devtools.send("Performance.getMetrics");
const metric = (name) => metrics.find((m) => m.name === name)?.value;
const tasks = await page.evaluate(() => window.longTasks);
console.log(await page.textContent(".facts"), await page.locator(".surface-state").allTextContents());
console.log(`script ${metric("ScriptDuration").toFixed(2)} s, all tasks of the main thread ${metric("TaskDuration").toFixed(2)} s`);
const begin = tasks.filter(([start]) => start < 1000);
const rest = tasks.filter(([start]) => start >= 1000);
for (const [when, some] of [["in the first second", begin], ["after that", rest]]) {
  const longest = Math.max(0, ...some.map(([, duration]) => duration));
  console.log(`${some.length} tasks above 50 ms ${when}, the longest ${longest} ms (start, duration): ${JSON.stringify(some)}`);
}
await browser.close();

// Waits until all surfaces are complete.
async function complete() {
  await page.waitForFunction(() => {
    const others = [...document.querySelectorAll(".surface-state")].map(({ textContent }) => textContent);
    const isComing = (text) => text === "" || text.endsWith("…");
    return window.states.length > 1 && window.states.at(-1)[1] === "Complete" && !others.slice(1).some(isComing);
  }, null, { timeout: 600_000, polling: 20 });
}

async function tellStates(what) {
  const states = await page.evaluate(() => window.states);
  console.log(`${what}: ${states.map(([when, word]) => `${word} ${when} ms`).join(", ")}`);
}
