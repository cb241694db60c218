// The page: puts the parts together and decides which change leads to what.
import "./style.css";

import * as THREE from "three";

import { DatasetList } from "./panel/dataset_list";
import { h } from "./panel/dom";
import { Panel } from "./panel/panel";
import { StatusBar } from "./panel/status_bar";
import { installTooltips } from "./panel/tooltip";
import type { DatasetInfo } from "./protocol/messages";
import { Picking } from "./scene/picking";
import { RegionHandles } from "./scene/region_handles";
import { Stage } from "./scene/stage";
import { Surface } from "./scene/surface";
import { Surroundings } from "./scene/surroundings";
import { Thumbnails } from "./scene/thumbnails";
import { defaults, type Settings } from "./state/settings";
import { Store } from "./state/store";
import { fromAddress, toAddress } from "./state/url_state";
import { latticeToWorld, type Vec3, worldBox } from "./stream/dataset";
import { SurfaceClient } from "./surface_client";
import { TilePool } from "./workers/tile_pool";
import { installKeyboard } from "./panel/keyboard";
import { Notices } from "./panel/notices";

const settings = new Store<Settings>({ ...defaults, ...fromAddress(location.hash) });
const canvas = h("canvas", { tabindex: "0", "aria-label":
  "The surface. Drag to turn, scroll to come closer, right button or shift to move. Arrow keys turn, plus and minus zoom." });
const view = h("main", { class: "stage" }, canvas);
const stage = new Stage(canvas);
const pool = new TilePool(Math.min(6, Math.max(2, (navigator.hardwareConcurrency || 4) - 1)));
const surface = new Surface(stage.scene, () => stage.invalidate(), (ids) => pool.drop(ids));
stage.everyFrame(() => surface.uploadSome());

const server = new URLSearchParams(location.search).get("server") ?? ownAddress();
let token = ownToken();
const client = new SurfaceClient(server, () => token, pool, surface, (shown, isFirst) => {
  if (isFirst && !settings.get().eye) stage.frameBox(surface.worldBox());
  document.title = `${shown.info.name} · Multi-Tetra viewer`;
});
const thumbnails = new Thumbnails(server, () => token, pool, stage.renderer, (name, picture) => {
  datasets.setPicture(name, picture);
  stage.invalidate();
});

let list: readonly DatasetInfo[] = [];
let info: DatasetInfo | null = null;
let isDragging = false;
let remembering = 0; // The timer behind rememberSoon().

const datasets = new DatasetList({
  chosen: (chosen) => chooseDataset(chosen),
  becameVisible: (name) => {
    const found = list.find((candidate) => candidate.name === name);
    if (found) whenIdle(() => thumbnails.want(found));
  },
});
const notices = new Notices(
  () => client.connect(),
  (said) => {
    token = said;
    sessionStorage.setItem("token", said);
    client.connect();
  },
);
const panel = new Panel(
  settings,
  {
    dragging: (now) => {
      const hasEnded = isDragging && !now;
      isDragging = now;
      if (hasEnded) ask();
    },
    fit: () => stage.frameBox(surface.worldBox()),
    reset: () => resetView(),
    screenshot: () => void screenshot(),
    download: (format) => void download(format),
    copyLink: () => void copyLink(),
  },
  datasets.element,
);
const bar = new StatusBar();
const surroundings = new Surroundings(stage);
const regionHandles = new RegionHandles(stage, canvas, (region, dragging) => {
  isDragging = dragging;
  settings.set({ region });
  if (!dragging) ask();
});
const picking = new Picking(
  stage,
  canvas,
  pool,
  () => (client.shown ? { surface: client.shown, ids: surface.shownIds } : null),
  () => regionHandles.isGrabbed,
);
const toolButton = (word: string, label: string, tip: string, act: () => void) => {
  const button = h("button", { type: "button", "aria-label": label, "data-tip": tip }, word);
  button.addEventListener("click", act);
  return button;
};
const tools = h("nav", { class: "tools", "aria-label": "View" },
  toolButton("Fit", "Fit the surface", "The whole surface in the picture (F).", () => stage.frameBox(surface.worldBox())),
  toolButton("Reset", "Reset the view", "The view of the beginning (R).", () => resetView()),
  ...([["Front", 0, -1, 0], ["Side", 1, 0, 0], ["Top", 0, -0.0001, 1]] as const).map(([word, x, y, z]) =>
    toolButton(word, `${word} view`, `Look along an axis of the world.`, () => {
      stage.lookFrom(new THREE.Vector3(x, y, z));
      stage.frameBox(surface.worldBox());
    })),
);
view.append(tools, surroundings.scaleBar, picking.labels, picking.element, notices.element);
document.getElementById("app")!.append(view, panel.element, bar.element);
installTooltips();
installKeyboard(stage, settings, {
  fit: () => stage.frameBox(surface.worldBox()),
  reset: () => resetView(),
  forget: () => picking.forget(),
});

// ---- what changes lead to

client.progress.watch((progress) => {
  bar.show(progress);
  notices.show(progress);
});

client.datasets.watch(({ list: now }) => {
  if (!now) return;
  list = now;
  datasets.show(now);
  const wanted = settings.get().dataset;
  const found = now.find(({ name }) => name === wanted);
  if (wanted && !found) {
    notices.tell(`No dataset named "${wanted}" is served here. Choose one from the list.`);
  } else if (found ?? now[0]) {
    useDataset(found ?? now[0]);
  }
});

settings.watch((now, before) => {
  applyTheme(now.theme);
  surroundings.show(now.axes);
  regionHandles.show(now.region);
  surface.applyLook(now, clipPlane(now));
  if (now !== before && isOtherRequest(now, before)) ask();
  rememberSoon();
});

let rest = 0;
stage.controls.addEventListener("change", () => {
  clearTimeout(rest);
  rest = window.setTimeout(() => {
    if (settings.get().followView) ask();
    if (client.shown) {
      const { eye, target } = stage.view();
      settings.set({ eye: eye as Vec3, target: target as Vec3 });
    }
  }, 250);
});
// A graphics card that was taken away has lost all tiles; the address knows the rest.
canvas.addEventListener("webglcontextrestored", () => location.reload());
canvas.addEventListener("pointermove", (event) => {
  const isOver = event.buttons === 0 && regionHandles.isOver(event.offsetX, event.offsetY);
  canvas.style.cursor = isOver ? "grab" : "";
});
window.addEventListener("hashchange", () => {
  if (location.hash.slice(1) === toAddress(settings.get())) return;
  settings.set({ ...defaults, ...fromAddress(location.hash) });
  const { dataset, eye, target } = settings.get();
  const found = list.find(({ name }) => name === dataset);
  if (dataset && !found) notices.tell(`No dataset named "${dataset}" is served here. Choose one from the list.`);
  if (found && found !== info) useDataset(found);
  if (eye && target) stage.setView(eye, target);
});
matchMedia("(prefers-color-scheme: light)").addEventListener("change", () => panel.histogram.redraw());

client.connect();

// ----

function chooseDataset(chosen: DatasetInfo): void {
  if (chosen === info) return;
  picking.forget();
  settings.set({ dataset: chosen.name, isovalue: null, region: null, eye: null, target: null, clip: "off" });
  useDataset(chosen);
}

function useDataset(now: DatasetInfo): void {
  const isOther = info?.name !== now.name;
  info = now;
  notices.clear();
  datasets.choose(now.name);
  panel.setDataset(now);
  surroundings.setDataset(now);
  if (!isOther) return; // After a lost connection: the stream goes on by itself.
  const { low, high } = worldBox(now);
  stage.setBounds(low, high);
  const { eye, target } = settings.get();
  if (eye && target) stage.setView(eye, target);
  else if (!client.shown) stage.defaultView();
  surface.applyLook(settings.get(), clipPlane(settings.get()));
  ask();
}

function ask(): void {
  if (info) client.want(info, settings.get(), stage.view(), isDragging);
}

function isOtherRequest(now: Settings, before: Settings): boolean {
  if (now.dataset !== before.dataset) return false; // useDataset asks.
  const hasNormals = (s: Settings) => s.shading === "field";
  return (
    now.isovalue !== before.isovalue || now.error !== before.error || now.bound !== before.bound ||
    now.rule !== before.rule || now.tolerance !== before.tolerance || now.region !== before.region ||
    now.followView !== before.followView || (now.followView && now.pixels !== before.pixels) ||
    now.maxTriangles !== before.maxTriangles || hasNormals(now) !== hasNormals(before)
  );
}

function clipPlane(now: Settings): THREE.Plane | null {
  if (now.clip === "off" || !info) return null;
  const axis = "xyz".indexOf(now.clip);
  const { low, high } = worldBox(info);
  const at = low[axis] + now.clipAt * (high[axis] - low[axis]);
  const sign = now.clipFlipped ? -1 : 1;
  return new THREE.Plane(new THREE.Vector3().setComponent(axis, sign), -sign * at);
}

function resetView(): void {
  settings.set({ eye: null, target: null });
  stage.defaultView();
  if (client.shown) stage.frameBox(surface.worldBox());
}

function applyTheme(theme: Settings["theme"]): void {
  if (document.documentElement.dataset.theme === theme) return;
  document.documentElement.dataset.theme = theme;
  panel.histogram.redraw();
}

function rememberSoon(): void {
  clearTimeout(remembering);
  remembering = window.setTimeout(() => {
    const { dataset } = settings.get();
    const now = dataset || !info ? settings.get() : { ...settings.get(), dataset: info.name };
    history.replaceState(null, "", `#${toAddress(now)}`);
  }, 300);
}

async function copyLink(): Promise<void> {
  const { eye, target } = stage.view();
  const now = { ...settings.get(), dataset: info?.name ?? "", eye: eye as Vec3, target: target as Vec3 };
  history.replaceState(null, "", `#${toAddress(now)}`);
  try {
    await navigator.clipboard.writeText(location.href);
    notices.tell("The link is in the clipboard.", true);
  } catch {
    notices.tell("The link is in the address line; this browser does not let pages copy.", true);
  }
}

async function screenshot(): Promise<void> {
  const background = getComputedStyle(document.body).getPropertyValue("--stage").trim();
  save(await stage.picture(background || "#15181d"), "png");
}

async function download(format: "glb" | "ply" | "stl"): Promise<void> {
  const { shown } = client;
  if (!shown || surface.shownIds.length === 0) {
    notices.tell("There is no surface to save.", true);
    return;
  }
  const toWorld = [...latticeToWorld(shown.info, shown.resolution)];
  const bytes = await pool.file([...surface.shownIds], format, toWorld);
  save(new Blob([bytes as Uint8Array<ArrayBuffer>]), format);
}

function save(blob: Blob, ending: string): void {
  const { shown } = client;
  const name = shown ? `${shown.info.name}_${shown.facts.isovalue}` : "multitetra";
  const link = h("a", { href: URL.createObjectURL(blob), download: `${name}.${ending}` });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}

function whenIdle(act: () => void): void {
  const { isStreaming, shown } = client.progress.get();
  if (shown && !isStreaming) act();
  else setTimeout(() => whenIdle(act), 400);
}

function ownAddress(): string {
  const scheme = location.protocol === "https:" ? "wss:" : "ws:";
  return `${scheme}//${location.host}/v1/stream`;
}

// A token comes with the address once (#token=...) and is not shown any longer than that.
function ownToken(): string {
  const said = new URLSearchParams(location.hash.slice(1)).get("token");
  if (said) sessionStorage.setItem("token", said);
  return said ?? sessionStorage.getItem("token") ?? "";
}
