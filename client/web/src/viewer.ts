// Surfaces of one dataset in an element of a page: the picture with all that lies over it, without a
// panel. This is the module `multitetra-viewer`; the page (main.ts) is built on it.
//
//   import { Viewer } from "multitetra-viewer";
//   const viewer = new Viewer(element, { server: "https://example.org/", dataset: "head", isovalue: 500.5 });
//   viewer.on("shown", ({ isovalue, triangles }) => ...);
//   viewer.set({ error: 1, surfaces: [{ isovalue: 1200.5, error: null, color: "#ffffff", opacity: 1, visible: true }] });
import "./style/colors.css";
import "./style/picture.css";

import * as THREE from "three";

import { serverAddress } from "./server_address";
import { isEmpty } from "./panel/certificate";
import { h } from "./shared/elements";
import { nearestName } from "./shared/nearest_name";
import { inDigits } from "./shared/quantities";
import { isCt, defaultWindow } from "./shared/sample_window";
import { componentWords } from "./panel/component_filter";
import { Notices } from "./panel/notices";
import { TimeBar } from "./panel/time_bar";
import type { DatasetInfo } from "./protocol/messages";
import { annotate } from "./scene/annotations";
import { Measuring } from "./scene/measuring";
import { Orientation } from "./scene/orientation";
import { type Picked, Picking } from "./scene/picking";
import { Legend, type LegendValues } from "./panel/legend";
import { RegionHandles } from "./scene/region_handles";
import { type Scene, sceneOf } from "./scene_at";
import { Stage } from "./scene/stage";
import { SceneDecorations } from "./scene/scene_decorations";
import type { ShownSurface } from "./shown_surface";
import { Events } from "./state/events";
import type { Progress, ShownComponents, StepFacts } from "./state/progress";
import {
  atTime, type Entry, seriesOf, isOfOneSeries, named, rangeOf, settingsOfEntry, timeOf, timesOf,
} from "./state/series";
import { defaults, isOtherRequest, type Settings } from "./state/settings";
import { Store } from "./state/store";
import { type Vec3, worldBox, worldDifference } from "./stream/dataset";
import { DatasetQueries } from "./stream/dataset_queries";
import { suggestedIsovalue, type View } from "./stream/request";
import type { SliceSources } from "./latest_slice";
import { SliceViews } from "./slice_views";
import { scaleOf, slicePlace, Slices } from "./slices";
import { justAbove, withSurface } from "./state/surfaces";
import { SurfaceSet } from "./surface_set";
import { type Played, timeBeside, TimePlayer } from "./time_player";
import { TilePool } from "./workers/tile_pool";

export type { Settings } from "./state/settings";

export interface ViewerOptions extends Partial<Settings> {
  // The server's address: "https://example.org/volumes/", or that of its WebSocket. The page's own by default.
  server?: string;
  token?: string | TokenPlace;
}

// Where a token is, and where one goes that the user has typed.
export interface TokenPlace {
  get: () => string;
  set: (token: string) => void;
}

export interface PictureOptions {
  enlargement?: number; // Relative to the screen; default 1.
  width?: number; // In pixels, instead; as far as the graphics card can.
  isTransparent?: boolean; // Without a background.
}

const slowSurface = 2000; // Milliseconds from the first request to its final step.

export interface ViewerEvents {
  settings: Settings; // All of them, after any change.
  dataset: DatasetInfo; // Another one is looked at, or the same one was prepared again.
  // A step of the surface of that number, 0 for the first, and what of it is shown; null: all.
  shown: StepFacts & { surface: number; components: ShownComponents | null };
  progress: { surface: number };
  picked: Picked;
}

export class Viewer {
  readonly settings: Store<Settings>;
  readonly canvas = h("canvas", { tabindex: "0", role: "application", "aria-label":
    "The surface. Drag to rotate, scroll to zoom, right button or Shift to pan. Arrow keys rotate, plus and minus zoom." });
  readonly frame = h("div", { class: "stage" }); // The picture with what lies over it.
  readonly stage: Stage;
  readonly pool = new TilePool(Math.min(6, Math.max(2, (navigator.hardwareConcurrency || 4) - 1)));
  readonly surfaces: SurfaceSet;
  readonly notices: Notices;
  readonly measuring: Measuring;
  info: DatasetInfo | null = null; // The current dataset.
  private readonly events = new Events<ViewerEvents>();
  private readonly surroundings: SceneDecorations;
  private readonly orientation: Orientation;
  private readonly regionHandles: RegionHandles;
  private readonly queries: DatasetQueries;
  private readonly slices: Slices;
  private readonly sliceViews: SliceViews;
  readonly player: TimePlayer;
  private readonly timeBar: TimeBar;
  private readonly legends: { samples: Legend; field: Legend };
  private readonly token: TokenPlace;
  private isDragging = false;
  private isSlow: boolean | null = null; // Whether the first final step took too long to ask for detail in view; null: none was there.
  private rest = 0; // The timer behind the camera's rest.

  // Throws where the browser cannot draw in three dimensions.
  constructor(readonly element: HTMLElement, { server, token = "", ...changes }: ViewerOptions = {}) {
    this.settings = new Store<Settings>({ ...defaults, ...changes });
    this.token = typeof token === "string" ? placeOf(token) : token;
    if (changes.followView) this.isSlow = false; // Asked for.
    element.classList.add("multitetra");
    element.append(this.frame);
    this.frame.append(this.canvas);
    this.stage = new Stage(this.canvas);
    const address = serverAddress(server);
    this.queries = new DatasetQueries(address, () => this.token.get());
    this.surfaces = new SurfaceSet(address, () => this.token.get(), this.pool, this.stage, {
      shown: (at, shown, isFirst) => this.reportShown(at, shown, isFirst),
      progress: (surface) => this.events.emit("progress", { surface }),
    });
    this.notices = new Notices({
      connectNow: () => this.surfaces.connect(),
      useToken: (typed) => this.useToken(typed),
      insist: () => this.surfaces.insist(),
      leave: () => this.canvas.focus(),
    });
    this.surroundings = new SceneDecorations(this.stage);
    this.orientation = new Orientation(this.stage, (direction) => this.lookFrom(direction), (up) => this.turnUp(up));
    this.regionHandles = new RegionHandles(this.stage, this.canvas, (region, isDragging) => this.set({ region }, isDragging));
    this.measuring = new Measuring(this.stage, this.pool,
      (info, world) => this.queries.probe(info.name, world), (places) => this.set({ places }), () => this.canvas.focus());
    const sources: SliceSources = {
      queries: this.queries, surfaces: this.surfaces, pool: this.pool, settings: () => this.get(),
      failed: (text) => this.notices.announce(text, true),
    };
    const current = () => ({ info: this.info, settings: this.get(), range: this.sampleRange() });
    this.slices = new Slices(this.stage, sources, current);
    this.sliceViews = new SliceViews(this.stage, sources, current, (cross, isDragging) => this.set({ cross }, isDragging));
    const turn = (changes: Partial<Settings>, isDragging: boolean) => this.set(changes, isDragging);
    this.legends = {
      samples: new Legend({ label: "samples", colors: "sliceColors", level: "level", width: "windowWidth", isLog: "samplesLog" }, turn),
      field: new Legend({
        label: "the surface's colors", colors: "colors", level: "fieldLevel", width: "fieldWindow", isLog: "fieldLog",
      }, turn),
    };
    this.player = new TimePlayer(() => this.played(), {
      isReady: (time) => this.surfaces.isPrepared(this.sceneAt(time), this.get(), this.followedView),
      prepare: (times) => this.surfaces.prepare(times.map((time) => this.sceneAt(time)), this.get(), this.followedView),
      show: (time) => this.set({ t: time }),
      stop: () => this.set({ playing: false }),
    }, (pace) => this.timeBar.showPace(pace));
    this.timeBar = new TimeBar(turn);
    new Picking(this.stage, this.canvas, this.pool,
      () => ({
        info: this.info, tiles: this.surfaces.shownTiles(this.get()), clip: this.clipPlane(),
        slice: (ray) => this.slices.plane.hit(ray),
      }),
      () => this.regionHandles.isGrabbed,
      (place) => this.take(place));
    this.frame.append(this.surroundings.numbers, this.surroundings.scaleBar, this.orientation.element,
      h("div", { class: "legends" }, this.legends.field.element, this.legends.samples.element),
      this.timeBar.element, this.measuring.labels, this.sliceViews.mark, this.measuring.element, this.notices.element);
    element.append(this.sliceViews.element);
    this.listen();
    this.surfaces.connect();
  }

  // ---- public

  // Some other settings; `isDragging`: more will follow at once. A view is where one looks from now.
  set(change: Partial<Settings>, isDragging = false): void {
    const hasEnded = this.isDragging && !isDragging;
    this.isDragging = isDragging;
    if (change.followView) this.isSlow = false; // Switched on by hand.
    if (change.eye && change.target) this.stage.setView(change.eye, change.target);
    const before = this.settings.get();
    if (isNewCut(change, before)) change = { clipFlipped: this.isSeenFromAbove(change.clip!), ...change };
    // The isovalue that one time suggests is not what another does: it stays from here.
    const isStaying = change.t !== undefined && change.dataset === undefined && before.isovalue === null && this.info;
    this.settings.set(isStaying ? { isovalue: suggestedIsovalue(isStaying), ...change } : change);
    const { dataset, t } = this.settings.get();
    if (t !== before.t || (dataset !== before.dataset && dataset !== this.info?.name)) this.findDataset();
    if (hasEnded) this.ask();
  }

  get(): Settings {
    return this.settings.get();
  }

  // Another dataset, seen as it is seen first.
  choose(entry: Entry): void {
    if (this.info && isOfOneSeries(entry.info, this.info)) return;
    this.settings.set({
      ...settingsOfEntry(entry), t: null, playing: false, region: null, minComponent: 0, eye: null, target: null,
      up: defaults.up, clip: "off", places: [], cross: null,
    });
    this.use(entry.info);
  }

  // At which time it is, of which ones; null: there is nothing to go through.
  get times(): { all: readonly number[]; now: number; unit: string } | null {
    const { list } = this.surfaces.datasets.get();
    const all = list && this.info ? timesOf(list, this.info) : [];
    return all.length > 1 ? { all, now: timeOf(this.info!)!, unit: this.info!.member!.timeUnit } : null;
  }

  // To a time before or after the one that is shown.
  stepTime(steps: number): void {
    const { times } = this;
    if (times) this.set({ t: timeBeside({ times: times.all, now: times.now, loop: this.get().loop }, steps), playing: false });
  }

  // Resolves when all that is to be seen of the time that was set is on the screen, or will not be.
  async settled(): Promise<void> {
    const isThere = () => this.surfaces.lead?.info === this.info || this.surfaces.progress.get().failure !== null;
    while (!this.surfaces.isSettled || !isThere()) {
      await new Promise((resolve) => setTimeout(resolve, 20));
    }
  }

  // Calls back on every such event, until what is returned is called.
  on<K extends keyof ViewerEvents>(kind: K, listener: (what: ViewerEvents[K]) => void): () => void {
    return this.events.on(kind, listener);
  }

  fit(): void {
    this.stage.frameBox(this.surfaces.worldBox());
  }

  reset(): void {
    this.settings.set({ eye: null, target: null, up: defaults.up });
    this.stage.defaultView();
    this.fit();
  }

  lookFrom(direction: THREE.Vector3): void {
    // Straight along it there is no up: a hair beside it there is.
    const up = this.stage.camera.up;
    const isAlongUp = direction.clone().normalize().cross(up).length() < 1e-6;
    const hair = Math.abs(up.y) < 0.9 ? new THREE.Vector3(0, -1e-4, 0) : new THREE.Vector3(0, 0, -1e-4);
    this.stage.lookFrom(isAlongUp ? direction.clone().add(hair) : direction);
    this.fit();
  }

  // Another direction is up, and one looks from the front.
  private turnUp(up: Vec3): void {
    this.set({ up });
    this.stage.defaultView();
    this.fit();
  }

  // Hides all components of a surface but the one with the largest box.
  async keepLargest(surface: number): Promise<void> {
    const tiles = this.surfaces.shownTiles(this.get()).find(({ at }) => at === surface);
    const found = tiles && (await this.pool.select({ ids: tiles.drawn.ids, leastDiagonal: 0 }).catch(() => null));
    if (!found) return this.notices.announce("The surface is not shown, or has changed meanwhile.", true);
    const minComponent = justAbove(found.diagonals, 2 ** tiles.shown.resolution);
    if (minComponent === null) return this.notices.announce("Its largest parts are equally large.", true);
    this.set(withSurface(this.get(), surface, { minComponent }));
  }

  // Turns the picture clockwise around its middle; half a turn turns it upside down.
  roll(radians: number): void {
    this.set({ up: this.stage.rolledUp(radians) });
  }

  // What is shown, as PNG, on the page's background or on none, with scale bar, axes, legends and what is measured.
  picture({ enlargement = 1, width, isTransparent = false }: PictureOptions = {}): Promise<Blob> {
    const { backgroundColor: own, color } = getComputedStyle(this.element);
    const isNone = own === "transparent" || own === "rgba(0, 0, 0, 0)";
    const paper = isNone ? getComputedStyle(document.body).backgroundColor : own;
    const canvas = this.stage.picture(isTransparent ? null : paper, width ? this.stage.enlargementTo(width) : enlargement);
    const legends = [this.legends.samples.words, this.legends.field.words].filter((words) => words !== null);
    const { measurement } = this.measuring;
    annotate(canvas.getContext("2d")!, { scale: this.surroundings.scale, axes: this.orientation.arms, legends, ...measurement },
      canvas.width / Math.max(1, this.canvas.clientWidth), color, paper);
    return new Promise((resolve) => canvas.toBlob((blob) => resolve(blob!), "image/png"));
  }

  // Nothing is drawn or asked any more; the element is empty.
  dispose(): void {
    clearTimeout(this.rest);
    this.player.stop();
    this.surfaces.close();
    this.queries.close();
    this.pool.dispose();
    this.stage.dispose();
    this.element.replaceChildren();
    this.sliceViews.close();
    this.element.classList.remove("multitetra", "has-slices");
  }

  useToken(token: string): void {
    this.token.set(token);
    this.surfaces.connect();
  }

  reportUnknown(dataset: string): void {
    const names = this.list.flatMap(({ name, member }) => (member ? [member.series, name] : [name]));
    const meant = nearestName(dataset, names);
    const advice = meant ? `Did you mean "${meant}"?` : "Choose one from the list.";
    this.notices.announce(`No dataset named "${dataset}" is served here. ${advice}`);
  }

  // The half-space that the cut leaves; null: nothing is cut.
  clipPlane(): THREE.Plane | null {
    const { clip, clipAt, clipFlipped } = this.settings.get();
    if (clip === "off" || !this.info) return null;
    const axis = "xyz".indexOf(clip);
    const { low, high } = worldBox(this.info);
    const at = low[axis] + clipAt * (high[axis] - low[axis]);
    const sign = clipFlipped ? -1 : 1;
    return new THREE.Plane(new THREE.Vector3().setComponent(axis, sign), -sign * at);
  }

  // Whether the eye lies farther along an axis than what it looks at: a cut then leaves what is behind it, and shows its face.
  private isSeenFromAbove(clip: Settings["clip"]): boolean {
    const { eye, target } = this.stage.view();
    const axis = "xyz".indexOf(clip);
    return eye[axis] > target[axis];
  }

  // ---- what changes lead to

  private listen(): void {
    this.settings.watch((now, before) => {
      this.element.dataset.theme = now.theme;
      this.surroundings.show(now.axes);
      this.orientation.show(now.axes);
      this.regionHandles.show(now.region);
      if (now === before || now.up !== before.up) this.stage.setUp(now.up);
      this.applyLook();
      if (now !== before && isOtherRequest(now, before)) this.ask();
      if (now.playing !== before.playing && now.followView) this.ask();
      this.timeBar.show(now, this.times);
      this.measuring.show(this.info, now.places);
      this.player.update();
      this.events.emit("settings", now);
    });
    this.surfaces.progress.watch((progress) => {
      const { lead } = this.surfaces;
      this.notices.show(progress, lead && nothingWords(lead, progress));
      this.events.emit("progress", { surface: 0 });
    });
    this.surfaces.datasets.watch(({ list }) => {
      if (!list) return;
      this.findDataset();
      this.applyLook();
    });
    this.stage.controls.addEventListener("change", () => {
      clearTimeout(this.rest);
      this.rest = window.setTimeout(() => this.cameraRests(), 250);
    });
    this.canvas.addEventListener("pointermove", (event) => {
      const isOver = event.buttons === 0 && this.regionHandles.isOver(event.offsetX, event.offsetY);
      this.canvas.style.cursor = isOver ? "grab" : "";
    });
  }

  // View-dependent detail waits where the first surface was slow to come, until it is switched on by hand.
  get isDetailPaused(): boolean {
    return this.isSlow === true && this.get().followView;
  }

  // What errors on the screen are seen through. While times play, all of them have one error.
  private get followedView(): View | null {
    return this.isSlow !== false || this.get().playing ? null : this.stage.view();
  }

  private learnPace(): void {
    const { complete } = this.surfaces.progress.get();
    if (this.isSlow !== null || complete === null) return;
    this.isSlow = complete > slowSurface;
    if (!this.isSlow && this.get().followView) this.ask();
  }

  private cameraRests(): void {
    if (this.settings.get().followView) this.ask();
    if (!this.surfaces.lead) return;
    const { eye, target } = this.stage.view();
    this.settings.set({ eye: eye as Vec3, target: target as Vec3 });
  }

  private findDataset(): void {
    const { list } = this.surfaces.datasets.get();
    if (!list) return;
    const { dataset, surfaces, t } = this.settings.get();
    const found = dataset ? named(list, dataset) : list[0];
    if (!found) return dataset ? this.reportUnknown(dataset) : undefined;
    // All labels of a segmentation, where no surfaces are named; one alone is shown where it is named.
    const series = surfaces.length === 0 && found.member?.label ? seriesOf(list, found) : null;
    if (!series || series.labels.length < 2) return this.use(atTime(list, found, t));
    const label = series.labels.find(({ name }) => name === dataset)?.name ?? null;
    const changes = settingsOfEntry({ name: series.name, info: found, series }, label);
    this.settings.set(changes);
    this.use(atTime(list, named(list, changes.dataset!) ?? found, t));
  }

  private played(): Played | null {
    const { times, settings } = this;
    const { playing, speed, loop } = settings.get();
    return times && { times: times.all, now: times.now, playing, speed, loop };
  }

  private sceneAt(time: number): Scene {
    return this.sceneOf(atTime(this.list, this.info!, time));
  }

  private sceneOf(info: DatasetInfo): Scene {
    return sceneOf(this.list, this.get(), info);
  }

  private get list(): readonly DatasetInfo[] {
    return this.surfaces.datasets.get().list ?? [];
  }

  private rangeOf(info: DatasetInfo | null): LegendValues | null {
    return info && { ...rangeOf(this.list, info), valueUnit: info.valueUnit };
  }

  // The range of samples on slices, the same at all times of a series.
  private sampleRange(): LegendValues | null {
    const { info } = this;
    const range = this.rangeOf(info);
    return info && range && (this.times && !isCt(info) ? range : { ...range, usual: defaultWindow(info) });
  }

  private use(now: DatasetInfo): void {
    const { info: before } = this;
    const isOther = before?.name !== now.name || before.contentId !== now.contentId;
    const isMember = before !== null && before.name !== now.name && isOfOneSeries(before, now);
    this.info = now;
    this.notices.clear();
    this.timeBar.show(this.get(), this.times);
    this.player.update();
    if (isMember) return this.changeMember(now);
    this.surroundings.setDataset(now);
    this.orientation.setDataset(now);
    this.orientation.show(this.settings.get().axes);
    this.events.emit("dataset", now);
    if (!isOther) return; // After a lost connection: the stream continues by itself.
    if (before) this.measuring.forget();
    this.measuring.show(now, this.settings.get().places);
    const { low, high } = worldBox(now);
    this.stage.setBounds(low, high);
    const { eye, target } = this.settings.get();
    if (eye && target) this.stage.setView(eye, target);
    else if (!this.surfaces.lead) this.stage.defaultView();
    this.applyLook();
    this.ask();
  }

  // Another time, field or label: the places are the same.
  private changeMember(now: DatasetInfo): void {
    this.events.emit("dataset", now);
    this.applyLook();
    this.ask();
  }

  private ask(): void {
    if (this.info && this.dropsColors(this.info)) return; // The settings without them ask.
    if (this.info) this.surfaces.want(this.sceneOf(this.info), this.settings.get(), this.followedView, this.isDragging);
  }

  // Colors by a field of another world are refused with the reason.
  private dropsColors(info: DatasetInfo): boolean {
    const { colorBy } = this.get();
    const by = colorBy ? named(this.list, colorBy) : null;
    const reason = by && worldDifference(info, by);
    if (!reason) return false;
    this.set({ colorBy: "" });
    this.notices.announce(`"${colorBy}" cannot color this surface: ${reason}.`);
    return true;
  }

  private applyLook(): void {
    const now = this.settings.get();
    const clip = this.clipPlane();
    this.surfaces.applyLook(now, clip);
    this.element.classList.toggle("has-slices", now.layout === "four");
    this.slices.update();
    this.sliceViews.update();
    this.showLegends(now);
    this.stage.setLook({
      isOrthographic: now.projection === "orthographic",
      hasOcclusion: now.occlusion,
      translucent: this.surfaces.translucent,
      clip: clip ? [clip] : [],
    });
  }

  private showLegends(now: Settings): void {
    this.legends.samples.show(now, slicePlace(now) || now.layout === "four" ? this.sampleRange() : null, now.colorBy ? "samples" : "");
    const field = now.colorBy ? named(this.list, now.colorBy) : null;
    const by = this.rangeOf(field);
    this.legends.field.show(now, by, field?.member?.field || now.colorBy);
    if (!by) return;
    this.surfaces.field.setRange(by.min, by.max);
    const scale = scaleOf(now.fieldLevel, now.fieldWindow, now.fieldLog, by);
    this.surfaces.field.setLook({ map: now.colors, ...scale }, now.noValueColor);
  }

  private reportShown(at: number, shown: ShownSurface, isFirst: boolean): void {
    if (at === 0 && isFirst && !this.settings.get().eye) this.frameFirst(shown.info);
    this.slices.update();
    this.sliceViews.update();
    if (at === 0 && shown.facts.isFinal) this.learnPace();
    this.events.emit("shown", { ...shown.facts, surface: at, components: this.surfaces.progressOf(at).components });
  }

  // One surface as it is; with several, the data.
  private frameFirst(info: DatasetInfo): void {
    const { low, high } = worldBox(info);
    if (info.member?.label) this.stage.frameBox(new THREE.Box3(new THREE.Vector3(...low), new THREE.Vector3(...high)));
    else this.fit();
  }

  private take(place: Picked): void {
    this.measuring.add(place);
    if (this.get().layout === "four") this.set({ cross: place.world });
    this.events.emit("picked", place);
  }
}

function isNewCut({ clip = "off", clipFlipped }: Partial<Settings>, before: Settings): boolean {
  return clip !== "off" && clip !== before.clip && clipFlipped === undefined;
}

// Why there is nothing to see of a surface; null: there is something, or will be.
function nothingWords({ info: of, facts }: ShownSurface, { shown, components, isStreaming }: Progress): string | null {
  if (!shown || isStreaming) return null;
  if (!isEmpty(shown)) return components?.shown === 0 ? `${componentWords(components)}.` : null;
  return `There is no surface at isovalue ${inDigits(facts.isovalue, 6)}: the values of "${of.name}" go from ` +
    `${inDigits(of.min, 6)} to ${inDigits(of.max, 6)}.`;
}

function placeOf(token: string): TokenPlace {
  let value = token;
  return { get: () => value, set: (typed) => (value = typed) };
}
