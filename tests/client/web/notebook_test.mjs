// Tests the viewer of notebooks in a real browser, in Debian's notebook (the classic one, or version 7, whose front end is
// JupyterLab's) and in JupyterLab, if there is one: the browser reaches the notebook's port alone, and the surface comes through
// the kernel.
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

const [python, packages, scratch] = [process.argv[2], ...process.argv.slice(3).map((folder) => path.resolve(folder))];
const chromiumPath = process.env.CHROMIUM ?? "/usr/bin/chromium";
const patience = Number(process.env.PATIENCE ?? 120_000);

function skip(what) {
  console.log(`!! ${what}: the viewer is NOT TESTED in a notebook.`);
  process.exit(77);
}
if (!existsSync(chromiumPath)) skip("Chromium is not installed");
if (!existsSync(path.join(packages, "../share/multitetra/widget/widget.js"))) skip("The widget was not built");
let version = "";
try {
  const asked = "import notebook, ipywidgets, ipykernel; print(notebook.__version__.split('.')[0])";
  version = execFileSync(python, ["-c", asked], { stdio: ["ignore", "pipe", "ignore"] }).toString().trim();
} catch {
  skip("notebook and ipywidgets are not installed");
}
// No token or password; version 7 has no NotebookApp, and shows its application to tests.
const options =
  Number(version) < 7
    ? ["--NotebookApp.token=", "--NotebookApp.password="]
    : ["--IdentityProvider.token=", "--ServerApp.password=", "--LabApp.expose_app_in_browser=True", "--JupyterNotebookApp.expose_app_in_browser=True"];
const { chromium } = createRequire(new URL("../../../client/web/package.json", import.meta.url))("playwright-core");

rmSync(scratch, { recursive: true, force: true });
mkdirSync(scratch, { recursive: true });
const code = (source) => ({ cell_type: "code", execution_count: null, metadata: {}, outputs: [], source });
const shown = "print('shown', viewer.shown.get('isovalue'), viewer.shown.get('isFinal'), viewer._picture is not None, viewer.ignored)";
function writeNotebook() {
  const ball =
    "import numpy as np, multitetra\n" +
    "x, y, z = np.mgrid[-1:1:64j, -1:1:64j, -1:1:64j]\n" +
    "ball = multitetra.Volume(1 - np.sqrt(x**2 + y**2 + z**2), spacing=0.5, unit='mm')\n" +
    "viewer = multitetra.view(ball, isovalue=0.25, error=0.5)\n" +
    "viewer";
  const notebook = {
    cells: [code(ball), code("viewer.isovalue = 0.5")],
    metadata: { kernelspec: { name: "python3", display_name: "Python 3", language: "python" } },
    nbformat: 4,
    nbformat_minor: 4,
  };
  writeFileSync(path.join(scratch, "view.ipynb"), JSON.stringify(notebook));
}
const freePort = () =>
  new Promise((resolve) => {
    const probe = createServer().listen(0, "127.0.0.1", () => {
      const { port } = probe.address();
      probe.close(() => resolve(port));
    });
  });
const own = {
  ...Object.fromEntries(["JUPYTER_CONFIG_DIR", "JUPYTER_DATA_DIR", "JUPYTER_RUNTIME_DIR", "IPYTHONDIR"].map((name) => [name, path.join(scratch, name)])),
  JUPYTER_PATH: path.join(packages, "../share/jupyter"),
  PYTHONPATH: packages,
};
const browser = await chromium.launch({
  executablePath: chromiumPath,
  args: ["--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"],
});

// What a test does with a front end, in the page. `ask` returns what code prints, without a cell.
const classic = {
  isReady: () => window.Jupyter?.notebook?.kernel?.is_connected(),
  run: (cell) => Jupyter.notebook.execute_cells([cell]),
  hasRun: (cell) => Jupyter.notebook.get_cell(cell).element[0].matches(":not(.running)") && !Jupyter.notebook.kernel_busy,
  ask: (code) =>
    new Promise((resolve) => {
      let text = "";
      const output = ({ content }) => (text += content.text ?? "");
      Jupyter.notebook.kernel.execute(code, { shell: { reply: () => setTimeout(() => resolve(text), 200) }, iopub: { output } }, { silent: false });
    }),
  save: () => Jupyter.notebook.save_notebook(),
};
const lab = {
  isReady: () => {
    const panel = window.jupyterapp?.shell.currentWidget;
    return panel?.content?.widgets?.length > 1 && panel.sessionContext.session?.kernel?.status === "idle";
  },
  run: async (cell) => {
    jupyterapp.shell.currentWidget.content.activeCellIndex = cell;
    await jupyterapp.commands.execute("notebook:run-cell");
  },
  hasRun: () => jupyterapp.shell.currentWidget.sessionContext.session.kernel.status === "idle",
  ask: async (code) => {
    let text = "";
    const asked = jupyterapp.shell.currentWidget.sessionContext.session.kernel.requestExecute({ code });
    asked.onIOPub = ({ content }) => (text += content.text ?? "");
    await asked.done;
    return text;
  },
  save: () => jupyterapp.commands.execute("docmanager:save"),
};

// `check` throws if there is no use in waiting.
async function test(name, front, address, check) {
  const page = await browser.newPage({ viewport: { width: 1000, height: 900 } });
  page.setDefaultTimeout(patience);
  const others = [];
  page.on("request", (request) => {
    if (/^(https?|wss?):/.test(request.url()) && new URL(request.url()).host !== new URL(address).host) others.push(request.url());
  });
  if (process.env.VERBOSE) page.on("console", (message) => console.log(message.text()));
  const run = async (cell) => {
    await page.evaluate(front.run, cell);
    await page.waitForFunction(front.hasRun, cell);
  };
  const untilShown = async (expected) => {
    let text = "";
    for (const end = Date.now() + patience; Date.now() < end; await page.waitForTimeout(500)) {
      check();
      text = await page.evaluate(front.ask, shown);
      if (text.trim() === expected) return;
    }
    throw new Error(`"${text}" is shown instead of "${expected}"`);
  };
  try {
    await page.goto(address);
    await page.waitForFunction(front.isReady);
    await run(0);
    await page.waitForSelector(".multitetra canvas");
    await untilShown("shown 0.25 True True []");
    await run(1);
    await untilShown("shown 0.5 True True []");
    await page.screenshot({ path: path.join(scratch, `${name}.png`) });
    assert.equal(await page.locator(".multitetra canvas").count() > 0, true, "the viewer is still there");
    assert.deepEqual(others, [], "The browser reaches the notebook alone.");
    let outputs = [];
    const hasPicture = () => outputs.some((data) => (data["image/png"] ?? "").length > 5000);
    for (const end = Date.now() + patience; !hasPicture() && Date.now() < end; ) {
      check();
      await page.evaluate(front.save);
      await page.waitForTimeout(1000);
      const { cells } = JSON.parse(readFileSync(path.join(scratch, "view.ipynb"), "utf8"));
      outputs = cells[0].outputs.map(({ data }) => data ?? {});
    }
    assert(hasPicture(), "The saved notebook has the last picture.");
    assert(JSON.stringify(outputs).length < 1_500_000, "The saved notebook does not have the viewer itself.");
    console.log(`ok: the viewer works in ${name} through the kernel alone`);
  } catch (problem) {
    await page.screenshot({ path: path.join(scratch, "failed.png") }).catch(() => {});
    console.error(await page.evaluate(() => document.body.innerText).catch(() => ""));
    throw problem;
  } finally {
    await page.close();
  }
}

// Notebook 6 with jupyter_client 8, as in Debian 13, writes to one socket from two threads, and says so when messages are lost.
const hasLostMessages = (log) => /iostream\.py"[^]*(AssertionError|BufferError|IndexError)/.test(log);

// Runs `python -m MODULE` with a new notebook, and tests its page. Returns "passed", "failed", or "lost": messages that the
// server lost by its own fault.
async function testServer(module, page, front) {
  writeNotebook();
  const port = await freePort();
  const server = spawn(
    python,
    ["-m", module, "--no-browser", "--allow-root", "--ip=127.0.0.1", `--port=${port}`, ...options, `--notebook-dir=${scratch}`],
    { env: { ...process.env, ...own } },
  );
  let log = "";
  server.stderr.on("data", (text) => (log += text));
  try {
    for (const end = Date.now() + patience; !log.includes("is running at"); ) {
      assert(Date.now() < end && server.exitCode === null, log);
      await new Promise((resolve) => setTimeout(resolve, 100));
    }
    await test(module, front, `http://127.0.0.1:${port}/${page}`, () => assert(!hasLostMessages(log), "The server has lost messages."));
  } catch (problem) {
    console.error(problem);
    console.error(log.split("\n").slice(-15).join("\n"));
    return hasLostMessages(log) ? "lost" : "failed";
  } finally {
    server.kill();
  }
  return "passed";
}

const results = [];
if (Number(version) < 7) {
  let result = "lost";
  let loses = false; // Not all losses leave a trace in its log.
  for (let tries = 0; tries < 3 && (result === "lost" || (loses && result === "failed")); ++tries) {
    result = await testServer("notebook", "notebooks/view.ipynb", classic);
    loses ||= result === "lost";
  }
  results.push(loses && result === "failed" ? "lost" : result);
} else {
  results.push(await testServer("notebook", "notebooks/view.ipynb", lab));
  results.push(await testServer("jupyterlab", "lab/tree/view.ipynb", lab));
}
await browser.close();
if (results.includes("lost")) skip("This notebook server loses messages (Notebook 6 with jupyter_client 8)");
process.exit(results.every((result) => result === "passed") ? 0 : 1);
