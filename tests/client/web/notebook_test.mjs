// Tests the viewer of notebooks in a real browser, in Debian's classic notebook: the browser reaches the notebook's port alone, and
// the surface comes through the kernel.
//
//   node notebook_test.mjs PYTHON FOLDER_OF_THE_PACKAGE SCRATCH_FOLDER
//
// Exit code 77, with a warning, means that something is not installed and nothing was tested.
import assert from "node:assert/strict";
import { execFileSync, spawn } from "node:child_process";
import { existsSync, mkdirSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import { createServer } from "node:net";
import path from "node:path";

const [python, packages, scratch] = process.argv.slice(2);
const chromiumPath = process.env.CHROMIUM ?? "/usr/bin/chromium";
const patience = Number(process.env.PATIENCE ?? 120_000);

function skip(what) {
  console.log(`!! ${what}: the viewer is NOT TESTED in a notebook.`);
  process.exit(77);
}
if (!existsSync(chromiumPath)) skip("Chromium is not installed");
if (!existsSync(path.join(packages, "../share/multitetra/widget/widget.js"))) skip("The widget was not built");
try {
  execFileSync(python, ["-c", "import notebook, ipywidgets, ipykernel, widgetsnbextension"], { stdio: "ignore" });
} catch {
  skip("notebook and ipywidgets are not installed");
}
const { chromium } = createRequire(new URL("../../../client/web/package.json", import.meta.url))("playwright-core");

rmSync(scratch, { recursive: true, force: true });
mkdirSync(scratch, { recursive: true });
const code = (source) => ({ cell_type: "code", execution_count: null, metadata: {}, outputs: [], source });
writeFileSync(
  path.join(scratch, "view.ipynb"),
  JSON.stringify({
    cells: [
      code(
        "import numpy as np, multitetra\n" +
          "x, y, z = np.mgrid[-1:1:64j, -1:1:64j, -1:1:64j]\n" +
          "ball = multitetra.Volume(1 - np.sqrt(x**2 + y**2 + z**2), spacing=0.5, unit='mm')\n" +
          "viewer = multitetra.view(ball, isovalue=0.25, error=0.5)\n" +
          "viewer",
      ),
      code("viewer.isovalue = 0.5"),
      code("print('shown', viewer.shown.get('isovalue'), viewer.shown.get('isFinal'), viewer._picture is not None, viewer.ignored)"),
    ],
    metadata: { kernelspec: { name: "python3", display_name: "Python 3", language: "python" } },
    nbformat: 4,
    nbformat_minor: 5,
  }),
);
const own = Object.fromEntries(
  ["JUPYTER_CONFIG_DIR", "JUPYTER_DATA_DIR", "JUPYTER_RUNTIME_DIR", "IPYTHONDIR"].map((name) => [name, path.join(scratch, name)]),
);
const port = await new Promise((resolve) => {
  const probe = createServer().listen(0, "127.0.0.1", () => {
    const { port: free } = probe.address();
    probe.close(() => resolve(free));
  });
});
const address = `http://127.0.0.1:${port}/`;
const notebook = spawn(
  python,
  ["-m", "notebook", "--no-browser", "--allow-root", "--ip=127.0.0.1", `--port=${port}`, "--NotebookApp.token=", "--NotebookApp.password=", `--notebook-dir=${scratch}`],
  { env: { ...process.env, ...own, PYTHONPATH: packages } },
);
let log = "";
notebook.stderr.on("data", (text) => (log += text));
const browser = await chromium.launch({
  executablePath: chromiumPath,
  args: ["--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"],
});

// Runs a cell and waits for its end.
async function run(page, cell) {
  await page.evaluate((at) => Jupyter.notebook.execute_cells([at]), cell);
  await page.waitForFunction((at) => Jupyter.notebook.get_cell(at).element[0].matches(":not(.running)") && !Jupyter.notebook.kernel_busy, cell);
}

async function shown(page) {
  await run(page, 2);
  return page.evaluate(() => Jupyter.notebook.get_cell(2).output_area.outputs.map(({ text }) => text).join(""));
}

async function untilShown(page, expected) {
  const end = Date.now() + patience;
  let text = "";
  while (Date.now() < end) {
    text = await shown(page);
    if (text.trim() === expected) return;
    await page.waitForTimeout(500);
  }
  throw new Error(`"${text}" is shown instead of "${expected}"`);
}

let failure = null;
let page = null;
try {
  for (const end = Date.now() + patience; !log.includes("is running at"); ) {
    assert(Date.now() < end && notebook.exitCode === null, log);
    await new Promise((resolve) => setTimeout(resolve, 100));
  }
  page = await browser.newPage({ viewport: { width: 1000, height: 900 } });
  page.setDefaultTimeout(patience);
  const others = [];
  page.on("request", (request) => {
    if (/^(https?|wss?):/.test(request.url()) && new URL(request.url()).host !== new URL(address).host) others.push(request.url());
  });
  if (process.env.VERBOSE) page.on("console", (message) => console.log(message.text()));
  await page.goto(`${address}notebooks/view.ipynb`);
  await page.waitForFunction(() => window.Jupyter?.notebook?.kernel?.is_connected());
  await run(page, 0);
  await page.waitForSelector(".multitetra canvas");
  await untilShown(page, "shown 0.25 True True []");
  await run(page, 1);
  await untilShown(page, "shown 0.5 True True []");
  await page.waitForTimeout(2000); // The last picture follows its surface.
  await page.screenshot({ path: path.join(scratch, "notebook.png") });
  assert.equal(await page.locator(".multitetra canvas").count() > 0, true, "the viewer is still there");
  assert.deepEqual(others, [], "The browser reaches the notebook alone.");
  await page.evaluate(() => Jupyter.notebook.save_notebook());
  await page.waitForTimeout(1000);
  const { cells } = JSON.parse(readFileSync(path.join(scratch, "view.ipynb"), "utf8"));
  const outputs = cells[0].outputs.map(({ data }) => data ?? {});
  assert(outputs.some((data) => (data["image/png"] ?? "").length > 5000), "The saved notebook has the last picture.");
  assert(JSON.stringify(outputs).length < 1_500_000, "The saved notebook does not have the viewer itself.");
  console.log("ok: the viewer works in a notebook through the kernel alone");
} catch (problem) {
  failure = problem;
  console.error(problem);
  if (page) {
    await page.screenshot({ path: path.join(scratch, "failed.png") }).catch(() => {});
    console.error(await page.evaluate(() => document.querySelector("#notebook-container")?.innerText).catch(() => ""));
  }
  console.error(log.split("\n").slice(-15).join("\n"));
} finally {
  await browser.close();
  notebook.kill();
}
process.exit(failure ? 1 : 0);
