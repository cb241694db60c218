// The page: a viewer with panel, status bar and keyboard shortcuts, and all settings in the address. entry.ts loads it.
import { EmbeddedViewer } from "./embed/embedded_viewer";
import { Embedding, firstSight } from "./embed/embedding";
import { AddressSync } from "./page/address_sync";
import { Downloads } from "./page/downloads";
import { serverAddress, Token } from "./page/server_address";
import { DatasetList } from "./panel/dataset_list";
import { Help } from "./panel/help";
import { installKeyboard } from "./panel/keyboard";
import { Panel } from "./panel/panel";
import { noSamples } from "./panel/panel_section";
import { StatusBar } from "./panel/status_bar";
import { installTooltips } from "./panel/tooltip";
import { viewTools } from "./panel/view_tools";
import type { DatasetInfo } from "./protocol/messages";
import { h } from "./shared/elements";
import { Bookmarks } from "./state/bookmarks";
import { persistentValues } from "./state/browser_storage";
import { History } from "./state/history";
import { type Entry, entriesOf, isSameSeries } from "./state/series";
import { defaults, type Settings } from "./state/settings";
import { fromAddress, ignoredParts } from "./state/url_state";
import { fromWritten } from "./state/written_settings";
import { isOfFiles } from "./static/file_channel";
import { worldBox } from "./stream/dataset";
import { Thumbnails } from "./stream/thumbnails";
import { Viewer } from "./viewer/viewer";

const app = document.getElementById("app")!;
const server = serverAddress();
const token = new Token(server);
Token.hide();
const isFrame = window.parent !== window;
// A browser draws only a few scenes at a time. Elsewhere, workers that entry.ts has started begin.
const early = isFrame ? await firstSight(window.parent) : await new Promise<[]>((resolve) => setTimeout(resolve, 0, []));
const view = app.appendChild(h("main"));
const viewer = viewerIn(view);
const { settings, surfaces, queries, notices } = viewer;
const address = new AddressSync(viewer, token, location.hash);
const changes = new History();
const bookmarks = new Bookmarks(persistentValues);

const datasets = new DatasetList({
  chosen: (chosen) => viewer.choose(chosen),
  becameVisible: (name) => {
    const found = entries().find((entry) => entry.name === name);
    if (found) whenShown(() => thumbnails.request(found.info));
  },
  hasPictures: !isOfFiles(server),
});
const thumbnails = new Thumbnails(
  server,
  () => token.get(),
  upOf,
  (name, picture) => {
    for (const entry of entries()) if (entry.info.name === name) datasets.setPicture(entry.name, picture);
  },
);
const downloads = new Downloads(viewer);
const change = (update: Partial<Settings>, isDragging = false) => {
  address.setDragging(isDragging);
  viewer.set(update, isDragging);
};
const panel = new Panel(
  settings,
  change,
  {
    reset: () => viewer.reset(),
    roll: (radians) => viewer.roll(radians),
    shownBox: () => {
      const box = viewer.surfaces.worldBox();
      return box.isEmpty() && viewer.info ? worldBox(viewer.info) : { low: box.min.toArray(), high: box.max.toArray() };
    },
    saveLabels: (surfaces) => void downloads.labels(surfaces),
    zoomToLabel: (dataset) => viewer.zoomToLabel(dataset),
    screenshot: (options) => void downloads.screenshot(options),
    download: (format) => void downloads.download(format),
    copyLink: () => void downloads.copyLink(address.settingsForAddress()),
    copyEmbedding: () => void downloads.copyEmbedding(address.settingsForAddress()),
    turntable: (form) => void downloads.turntable(form),
    times: (form) => void downloads.times(form),
    bookmarks,
    currentAddress: () => downloads.addressOf(address.settingsForAddress()),
    visit: (hash) => address.applyAddress(`#${hash}`),
  },
  datasets.element,
  isOfFiles(server),
);
const bar = new StatusBar(isOfFiles(server));
const fewSurfaces = 24;
let isBarWaiting = false;
const help = new Help();
const actions = {
  turn: (azimuth: number, elevation: number, factor?: number) => viewer.stage.rotate(azimuth, elevation, factor),
  fit: () => viewer.fit(),
  reset: () => viewer.reset(),
  lookUpright: (direction: readonly [number, number, number]) => viewer.lookFrom(viewer.stage.upright(direction)),
  escape: () => {
    if (!downloads.cancel() && !bar.closeCertificate()) viewer.overlays.measuring.clear();
  },
  help: () => help.toggle(),
  fullScreen: () => void toggleFullScreen(),
  undo: () => changes.undo(settings.get(), (to) => viewer.set(to)),
  redo: () => changes.redo(settings.get(), (to) => viewer.set(to)),
  stepTime: (steps: number) => viewer.playback.step(steps),
  roll: (radians: number) => viewer.roll(radians),
  toggleSlices: () => {
    if (!queries.datasets.get().permitsSamples) return notices.announce(noSamples, true);
    viewer.set({ layout: viewer.get().layout === "four" ? "surface" : "four" });
  },
};
const hint = h("p", { class: "stage-hint", hidden: true }, "drag to rotate · scroll to zoom · click to measure");
for (const touch of ["pointerdown", "wheel", "keydown"]) {
  viewer.canvas.addEventListener(touch, () => hint.remove(), { once: true, passive: true });
}
const tools = viewTools(actions);
viewer.frame.append(tools.element, hint);
app.append(panel.element, bar.element, help.element);
app.classList.toggle("is-embedded", new URLSearchParams(location.search).has("embed"));
if (isFrame) {
  const embedded = new EmbeddedViewer(viewer);
  if (fromAddress(location.hash).maxTriangles === undefined) embedded.limitOnWeakDevices();
  new Embedding(
    embedded,
    window.parent,
    ignoredParts(location.hash).map((part) => part.split("=")[0]),
    early,
  );
}
installTooltips();
installKeyboard(viewer, actions);

// ---- reactions to changes

surfaces.sizes.watch(({ expected }) => panel.showExpected(expected));
queries.datasets.watch(({ list, permitsSamples }) => {
  if (!list) return;
  datasets.show(entries());
  panel.show({ list, permitsSamples });
  tools.showPermission(permitsSamples);
  if (viewer.info) datasets.choose(viewer.info);
});
viewer.on("dataset", (info) => {
  datasets.choose(info);
  panel.show({ info });
});
viewer.on("progress", ({ surface }) => {
  showBar();
  panel.showSurface(surface, surfaces.progressOf(surface));
});
viewer.on("shown", () => {
  panel.accuracy.showPaused(viewer.isDetailPaused);
  hint.hidden = false;
  document.title = `${viewer.info?.name} · Multi-Tetra viewer`;
});
viewer.on("volume", (level) => panel.volume.showLevel(level));
viewer.on("picked", ({ surface }) => surface && panel.labels.select(surface.tiles.at));
settings.watch((now, before) => {
  applyTheme(now.theme);
  tools.show(now);
  changes.note(now, before, performance.now());
  showBar(); // The visible surfaces may have changed.
  const turned = now.up !== before.up && entries().find(({ info }) => isShown(info));
  if (turned) whenShown(() => thumbnails.request(turned.info));
  panel.accuracy.showPaused(viewer.isDetailPaused);
});
matchMedia("(prefers-color-scheme: light)").addEventListener("change", () => panel.histogram.redraw());

// ----

// Limits the rate of status updates with many surfaces: a thousand labels report thousands of steps.
function showBar(): void {
  const show = () => bar.show(surfaces.status);
  if (settings.get().surfaces.length < fewSurfaces) return show();
  if (isBarWaiting) return;
  isBarWaiting = true;
  setTimeout(() => {
    isBarWaiting = false;
    show();
  }, 200);
}

function isShown(info: DatasetInfo): boolean {
  return viewer.info !== null && (info.name === viewer.info.name || isSameSeries(info, viewer.info));
}

// Returns the up axis of a thumbnail: that of the viewer if it is a world axis.
function upOf(info: DatasetInfo): Settings["up"] {
  const { up } = settings.get();
  const isAxis = up.some((part) => Math.abs(part) === 1);
  return isShown(info) && isAxis ? up : defaults.up;
}

function entries(): Entry[] {
  return entriesOf(queries.datasets.get().list ?? []);
}

function applyTheme(theme: Settings["theme"]): void {
  if (document.documentElement.dataset.theme === theme) return;
  document.documentElement.dataset.theme = theme;
  panel.histogram.redraw();
}

async function toggleFullScreen(): Promise<void> {
  try {
    if (document.fullscreenElement) await document.exitFullscreen();
    else await view.requestFullscreen();
  } catch {
    notices.announce("This browser does not allow fullscreen here.", true);
  }
}

// Acts once a surface is shown, which the server makes before thumbnails, or if there is none to show.
function whenShown(act: () => void): void {
  if (surfaces.isShown || !viewer.info) act();
  else setTimeout(() => whenShown(act), 200);
}

// Without WebGL the viewer stops here.
function viewerIn(element: HTMLElement): Viewer {
  try {
    return new Viewer(element, { ...fromWritten(defaults, fromAddress(location.hash)), server, token, showAgain: () => location.reload() });
  } catch (error) {
    const words = h("p", { class: "no-picture" }, "This browser cannot draw in three dimensions: WebGL 2 is disabled, or the graphics " + "driver is missing.");
    app.replaceWith(words);
    throw error;
  }
}
