// The page: puts the parts together and decides which change leads to what.
import "./style/page.css";
import "./style/panel.css";
import "./style/picture.css";

import * as THREE from "three";

import { serverAddress, Token } from "./own_address";
import { DatasetList } from "./panel/dataset_list";
import { isEmpty } from "./panel/certificate";
import { h, inDigits } from "./panel/dom";
import { Help } from "./panel/help";
import { installKeyboard } from "./panel/keyboard";
import { Notices } from "./panel/notices";
import { Panel } from "./panel/panel";
import { StatusBar } from "./panel/status_bar";
import { installTooltips } from "./panel/tooltip";
import { viewTools } from "./panel/view_tools";
import type { DatasetInfo } from "./protocol/messages";
import { Picking } from "./scene/picking";
import { RegionHandles } from "./scene/region_handles";
import { Stage } from "./scene/stage";
import { Surface } from "./scene/surface";
import { Surroundings } from "./scene/surroundings";
import { Thumbnails } from "./scene/thumbnails";
import type { ShownSurface } from "./shown_surface";
import { defaults, isOtherRequest, type Settings } from "./state/settings";
import { Store } from "./state/store";
import { edited, fromAddress, misread, toAddress } from "./state/url_state";
import { type Vec3, worldBox } from "./stream/dataset";
import { SurfaceClient } from "./surface_client";
import { TakeAway } from "./take_away";
import { TilePool } from "./workers/tile_pool";

const server = serverAddress();
const token = new Token(server);
const settings = new Store<Settings>({ ...defaults, ...fromAddress(location.hash) });
const canvas = h("canvas", { tabindex: "0", "aria-label":
  "The surface. Drag to turn, scroll to come closer, right button or shift to move. Arrow keys turn, plus and minus zoom." });
const view = h("main", { class: "stage" }, canvas);
const stage = stageOn(canvas);
const pool = new TilePool(Math.min(6, Math.max(2, (navigator.hardwareConcurrency || 4) - 1)));
const surface = new Surface(stage.scene, () => stage.invalidate(), (ids) => pool.drop(ids));
stage.everyFrame(() => surface.uploadSome());

const client = new SurfaceClient(server, () => token.get(), pool, surface, (shown, isFirst) => {
  if (isFirst && !settings.get().eye) stage.frameBox(surface.worldBox());
  hint.hidden = false;
  document.title = `${shown.info.name} · Multi-Tetra viewer`;
});
const thumbnails = new Thumbnails(server, () => token.get(), pool, stage.renderer, (name, picture) => {
  datasets.setPicture(name, picture);
  stage.invalidate();
});

let saidAtFirst = location.hash;
let list: readonly DatasetInfo[] = [];
let info: DatasetInfo | null = null;
let isDragging = false;
let remembering = 0; // The timer behind rememberSoon().
let remembered: string | null = null; // What "Back" would leave: dataset and isovalue of the address.

const datasets = new DatasetList({
  chosen: (chosen) => chooseDataset(chosen),
  becameVisible: (name) => {
    const found = list.find((candidate) => candidate.name === name);
    if (found) whenIdle(() => thumbnails.want(found));
  },
});
const notices = new Notices({
  connectNow: () => client.connect(),
  useToken: (said) => {
    token.set(said);
    client.connect();
  },
  insist: () => client.insist(),
  leave: () => canvas.focus(),
});
const takeAway = new TakeAway(stage, surface, pool, notices, () => client.shown);
const panel = new Panel(
  settings,
  {
    dragging: (now) => {
      const hasEnded = isDragging && !now;
      isDragging = now;
      if (hasEnded) ask();
    },
    reset: () => resetView(),
    screenshot: () => void takeAway.screenshot(),
    download: (format) => void takeAway.download(format),
    copyLink: () => void takeAway.copyLink(addressed()),
  },
  datasets.element,
);
const bar = new StatusBar();
const help = new Help();
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
  () => client.shown && { surface: client.shown, ids: surface.shownIds, clip: clipPlane(settings.get()) },
  () => regionHandles.isGrabbed,
);
const tools = viewTools({
  fit: () => stage.frameBox(surface.worldBox()),
  reset: () => resetView(),
  lookFrom: (x, y, z) => {
    stage.lookFrom(new THREE.Vector3(x, y, z));
    stage.frameBox(surface.worldBox());
  },
  help: () => help.toggle(),
});
const hint = h("p", { class: "stage-hint", hidden: true },
  "drag to turn · scroll to come closer · click to measure");
for (const touch of ["pointerdown", "wheel", "keydown"]) {
  canvas.addEventListener(touch, () => hint.remove(), { once: true, passive: true });
}
view.append(tools, surroundings.scaleBar, hint, picking.labels, picking.element, notices.element);
document.getElementById("app")!.append(view, panel.element, bar.element, help.element);
installTooltips();
installKeyboard(stage, settings, {
  fit: () => stage.frameBox(surface.worldBox()),
  reset: () => resetView(),
  forget: () => picking.forget(),
  help: () => help.toggle(),
});

// ---- what changes lead to

client.progress.watch((progress) => {
  bar.show(progress, client.sizes.get().expected);
  const isEmptyNow = progress.shown && !progress.isStreaming && isEmpty(progress.shown);
  notices.show(progress, isEmptyNow && client.shown ? emptyWords(client.shown) : null);
});

client.sizes.watch(({ expected }) => {
  bar.show(client.progress.get(), expected);
  panel.showExpected(expected);
});

client.datasets.watch(({ list: now }) => {
  if (!now) return;
  list = now;
  datasets.show(now);
  const found = namedDataset() ?? (settings.get().dataset ? null : now[0]);
  if (found) {
    useDataset(found);
    tellMisread(saidAtFirst);
  }
  saidAtFirst = "";
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
// What was edited is in the event: the address itself may be written anew before it is heard of.
window.addEventListener("hashchange", ({ newURL }) => useEdited(new URL(newURL).hash));
matchMedia("(prefers-color-scheme: light)").addEventListener("change", () => panel.histogram.redraw());

client.connect();

// ----

// The dataset that the address names; the user is told if there is none of that name.
function namedDataset(): DatasetInfo | null {
  const wanted = settings.get().dataset;
  const found = list.find(({ name }) => name === wanted) ?? null;
  if (wanted && !found) tellUnknown(wanted);
  return found;
}

function tellUnknown(name: string): void {
  notices.tell(`No dataset named "${name}" is served here. Choose one from the list.`);
}

function tellMisread(hash: string): void {
  const said = misread(hash);
  if (said.length === 0) return;
  const words = said.slice(0, 3).map((word) => (word.length > 40 ? `${word.slice(0, 39)}…` : word));
  const rest = said.length > words.length ? " and more" : "";
  notices.tell(`Passed over in the address, as it means nothing here: ${words.join(", ")}${rest}.`, true);
}

function emptyWords({ info: of, facts }: ShownSurface): string {
  return `There is no surface at isovalue ${inDigits(facts.isovalue, 6)}: the values of "${of.name}" go from ` +
    `${inDigits(of.min, 6)} to ${inDigits(of.max, 6)}.`;
}

function chooseDataset(chosen: DatasetInfo): void {
  if (chosen === info) return;
  settings.set({ dataset: chosen.name, isovalue: null, region: null, eye: null, target: null, clip: "off" });
  useDataset(chosen);
}

// Somebody has edited the address, or followed a link to this page.
function useEdited(hash: string): void {
  rememberSoon(); // As it is understood, without a token.
  if (token.takeFrom(hash)) client.connect();
  remembered = null; // Where the browser is by now.
  if (hash.slice(1) === toAddress(addressed())) return;
  const { dataset: wanted, ...now } = edited(settings.get(), hash);
  const found = list.find(({ name }) => name === wanted);
  const isUnknown = wanted !== "" && list.length > 0 && !found;
  if (now.eye && now.target) stage.setView(now.eye, now.target);
  settings.set({ ...now, dataset: wanted && !isUnknown ? wanted : addressed().dataset });
  if (found && found !== info) useDataset(found);
  else ask();
  if (isUnknown) tellUnknown(wanted);
  else tellMisread(hash);
}

function useDataset(now: DatasetInfo): void {
  const isOther = info?.name !== now.name || info.contentId !== now.contentId;
  info = now;
  notices.clear();
  datasets.choose(now.name);
  panel.setDataset(now);
  surroundings.setDataset(now);
  if (!isOther) return; // After a lost connection: the stream goes on by itself.
  picking.forget();
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

// The settings as the address has them: with the dataset's name, also of the one shown unasked.
function addressed(): Settings {
  const now = settings.get();
  return now.dataset || !info ? now : { ...now, dataset: info.name };
}

function rememberSoon(): void {
  clearTimeout(remembering);
  remembering = window.setTimeout(() => (isDragging ? rememberSoon() : remember()), 300);
}

// Another dataset or isovalue is a step that the browser's "Back" takes back; all else is not.
function remember(): void {
  const now = addressed();
  const step = `${now.dataset} ${now.isovalue}`;
  const isStep = remembered !== null && remembered !== step;
  remembered = step;
  const address = `#${toAddress(now)}`;
  if (isStep) history.pushState(null, "", address);
  else history.replaceState(null, "", address);
}

function whenIdle(act: () => void): void {
  const { isStreaming, shown } = client.progress.get();
  if (shown && !isStreaming) act();
  else setTimeout(() => whenIdle(act), 400);
}

// Without WebGL there is nothing to show, and no reason to go on.
function stageOn(place: HTMLCanvasElement): Stage {
  try {
    return new Stage(place);
  } catch (error) {
    const words = h("p", { class: "no-picture" },
      "This browser cannot draw in three dimensions (WebGL 2): it is switched off, or the graphics " +
        "driver is missing.");
    document.getElementById("app")!.replaceWith(words);
    throw error;
  }
}
