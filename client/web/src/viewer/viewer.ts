// Surfaces of one dataset in an element of a page: the scene with its overlays, without a panel. The page (main.ts) and
// the module (module.ts) are built on it.
import "../style/colors.css";
import "../style/picture.css";

import type * as THREE from "three";
import { serverAddress } from "../page/server_address";
import { emptySurfaceText } from "../panel/empty_surface";
import { Notices } from "../panel/notices";
import type { DatasetInfo } from "../protocol/messages";
import { SampleViews } from "../samples/sample_views";
import { permittedSettings, planesThrough } from "../samples/slices";
import { contextGoneText } from "../scene/context_keeper";
import { boxBetween, clipPlanes, croppedBox } from "../scene/crop";
import type { Picked } from "../scene/picking";
import { pngOf } from "../scene/png";
import { Stage } from "../scene/stage";
import { h } from "../shared/elements";
import { Events } from "../state/events";
import { changeFromWritten, initialSelection, settingsOfChoice } from "../state/label_surfaces";
import { type Entry, findByName, isSameData, isSameSeries, unknownDatasetText } from "../state/series";
import { defaults, isOtherRequest, type Settings, type WrittenSettings } from "../state/settings";
import { Store } from "../state/store";
import { labelBox, reservationsOf, type Vec3, worldBox } from "../stream/dataset";
import { DatasetQueries } from "../stream/dataset_queries";
import { ReadingWatch } from "../stream/reading_watch";
import type { View } from "../stream/request";
import { sceneOf, sceneRefusal } from "../surfaces/scene_at";
import type { ShownSurface } from "../surfaces/shown_surface";
import { SurfaceSet } from "../surfaces/surface_set";
import { TilePool } from "../workers/tile_pool";
import { Overlays } from "./overlays";
import { drawPicture, pictureHeading, surfaceKeys } from "./picture";
import { Playback } from "./playback";
import { completedChange } from "./setting_changes";
import { ViewDependentDetail } from "./view_dependent_detail";
import type { ViewerEvents } from "./viewer_events";
import { type PictureOptions, type TokenStorage, tokenInMemory, type ViewerOptions } from "./viewer_options";

export class Viewer {
  readonly settings: Store<Settings>;
  readonly canvas = h("canvas", {
    tabindex: "0",
    role: "application",
    "aria-label": "The surface. Drag to rotate, scroll to zoom, right button or Shift to pan. Arrow keys rotate, plus and minus zoom.",
  });
  readonly frame = h("div", { class: "stage" }); // The scene with its overlays.
  readonly stage: Stage;
  readonly pool = new TilePool(Math.min(window.parent === window ? 6 : 3, Math.max(2, (navigator.hardwareConcurrency || 4) - 1)));
  readonly surfaces: SurfaceSet;
  readonly notices: Notices;
  info: DatasetInfo | null = null; // The current dataset.
  private readonly events = new Events<ViewerEvents>();
  readonly overlays: Overlays;
  readonly queries: DatasetQueries;
  private readonly samples: SampleViews;
  readonly playback: Playback;
  private readonly token: TokenStorage;
  private isDragging = false;
  private readonly detail = new ViewDependentDetail();
  private readonly reading: ReadingWatch;
  private restTimer = 0; // The timer that detects the camera's rest.

  // Throws if the browser cannot draw in three dimensions.
  constructor(
    readonly element: HTMLElement,
    { server, token = "", showAgain, ...changes }: ViewerOptions = {},
  ) {
    this.settings = new Store<Settings>({ ...defaults, ...changes });
    this.token = typeof token === "string" ? tokenInMemory(token) : token;
    if (changes.followView) this.detail.enable();
    element.classList.add("multitetra");
    element.append(this.frame);
    this.frame.append(this.canvas);
    this.stage = new Stage(this.canvas, () => this.reportBlank());
    const address = serverAddress(server);
    this.queries = new DatasetQueries(address, () => this.token.get());
    this.surfaces = new SurfaceSet(address, () => this.token.get(), this.pool, this.stage, this.queries, {
      shown: (at, shown, isFirst) => this.reportShown(at, shown, isFirst),
      drawn: (shown) => this.events.emit("shown", shown),
      progress: (surface) => this.reportProgress(surface),
    });
    this.notices = new Notices(
      {
        connectNow: () => this.surfaces.connect(),
        useToken: (typed) => {
          this.token.set(typed);
          this.surfaces.connect();
        },
        confirmSize: () => this.surfaces.confirmSize(),
        focusScene: () => this.canvas.focus(),
        showAgain,
      },
      new URL(address).host !== location.host,
    );
    this.reading = new ReadingWatch(
      address,
      () => this.token.get(),
      (text) => this.notices.announce(text),
      () => this.queries.checkList(),
    );
    const turn = (changes: Partial<Settings>, isDragging: boolean) => this.set(changes, isDragging);
    this.samples = new SampleViews(
      this.stage,
      {
        queries: this.queries,
        surfaces: this.surfaces,
        pool: this.pool,
        settings: () => permittedSettings(this.get(), this.queries.datasets.get()),
        failed: (text) => this.notices.announce(text, true),
        volumeShown: (level) => this.events.emit("volume", level),
      },
      () => ({ info: this.info, list: this.list }),
      turn,
      (place) => this.addPlace(place),
    );
    const { canvas, stage, pool, surfaces, queries, samples } = this;
    const shared = { surfaces, info: () => this.info, settings: () => this.get(), set: turn };
    this.playback = new Playback({ ...shared, list: () => this.list, view: () => this.requestView });
    this.overlays = new Overlays({
      ...shared,
      ...{ element, canvas, stage, pool, queries, samples },
      lookFrom: (direction) => this.lookFrom(direction),
      turnUp: (up) => this.turnUp(up),
      refused: (text) => this.notices.announce(text, true),
      picked: (place) => this.receivePick(place),
    });
    this.frame.append(...this.overlays.elements(this.playback.bar.element), this.notices.element);
    element.append(this.samples.element);
    this.surfaces.connect();
    this.listen();
  }

  // Changes settings; `isDragging`: more changes follow immediately. Setting a view moves the camera.
  set(given: Partial<Settings>, isDragging = false): void {
    const hasEnded = this.isDragging && !isDragging;
    this.isDragging = isDragging;
    const [before, info] = [this.settings.get(), this.info];
    if (given.dataset !== undefined) this.notices.clear();
    if (given.eye && given.target) this.stage.setView(given.eye, given.target);
    const { change, unknown } = completedChange(this.list, info, before, given, this.stage.view());
    if (change.followView && !before.followView) this.detail.enable();
    this.settings.set(change);
    const { dataset, labels, t } = this.settings.get();
    if (labels || t !== before.t || (dataset !== before.dataset && dataset !== this.info?.name)) this.findDataset();
    if (hasEnded || (this.info === info && (dataset !== before.dataset || t !== before.t))) this.requestSurfaces();
    if (unknown) this.reportUnknown(unknown); // Last: a dataset that is found again clears notices.
  }

  get(): Settings {
    return this.settings.get();
  }

  setWritten(given: Partial<WrittenSettings>, isDragging: boolean): void {
    this.set(changeFromWritten(this.list, this.info, this.get(), given), isDragging);
  }

  // Selects another dataset with its default view.
  choose(entry: Entry): void {
    if (this.info && isSameSeries(entry.info, this.info)) return;
    this.settings.set(settingsOfChoice(entry, this.get()));
    this.useDataset(entry.info);
  }

  // Resolves when everything visible at the current time is complete or has failed.
  async settled(): Promise<void> {
    await this.surfaces.settled(() => this.info);
    await this.samples.settled();
  }

  // Registers a listener; returns a function that removes it.
  on<K extends keyof ViewerEvents>(kind: K, listener: (what: ViewerEvents[K]) => void): () => void {
    return this.events.on(kind, listener);
  }

  fit(): void {
    this.frameBox(croppedBox(this.surfaces.worldBox(), this.get().crop));
  }

  // Planes of samples that miss the box move to its center.
  private frameBox(box: THREE.Box3): void {
    this.stage.frameBox(box);
    if (this.info) this.settings.set(planesThrough(box, this.get(), this.info));
  }

  reset(): void {
    this.settings.set({ eye: null, target: null });
    this.turnUp(defaults.up);
  }

  lookFrom(direction: THREE.Vector3): void {
    this.stage.lookFrom(direction);
    this.fit();
  }

  // Fits a label to the view, even if it is hidden. Does nothing if its box is unknown.
  zoomToLabel(dataset: string): void {
    const info = findByName(this.list, dataset);
    const box = info && labelBox(info);
    if (box) this.frameBox(boxBetween(box));
  }

  // Sets the up direction and the default view.
  private turnUp(up: Vec3): void {
    this.set({ up });
    this.stage.defaultView();
    this.fit();
  }

  // Rotates the picture clockwise around its center.
  roll(radians: number): void {
    this.set({ up: this.stage.upAfterRoll(radians) });
  }

  // Returns the scene with annotations as PNG, when it is complete or the connection is lost, on the page's background
  // or transparent.
  async picture(options: PictureOptions = {}): Promise<Blob> {
    await this.surfaces.settled(
      () => this.info,
      () => this.surfaces.progressOf(0).phase === "lost",
      options.signal,
    );
    await this.samples.settled();
    await this.stage.context.take();
    return pngOf(this.drawn(options));
  }

  // Returns the same picture of the current state.
  drawn(options: PictureOptions): HTMLCanvasElement {
    const { scene, words } = this.overlays.annotations;
    const head = pictureHeading(this.get(), this.info, this.list, options.isVideoFrame === true);
    const surfaces = surfaceKeys(this.get(), this.info, this.list);
    const slices = options.isVideoFrame ? null : this.samples.drawn;
    return drawPicture(this.stage, slices, this.element, { ...scene, legends: this.samples.legendWords, words: [...head, ...words], surfaces }, options);
  }

  // Ends all work; empties the element.
  dispose(): void {
    clearTimeout(this.restTimer);
    this.playback.stop();
    this.reading.close();
    this.surfaces.close();
    this.queries.close();
    this.pool.dispose();
    this.stage.dispose();
    this.element.replaceChildren();
    this.samples.close();
    this.element.classList.remove("multitetra", "has-slices");
  }

  // Whether nothing can be drawn any more.
  get isBlank(): boolean {
    return this.stage.context.isGone;
  }

  private reportBlank(): void {
    this.notices.showBlank(contextGoneText);
    this.events.emit("failed", contextGoneText);
  }

  private reportUnknown(dataset: string): void {
    const words = unknownDatasetText(this.list, dataset);
    this.notices.announce(words);
    this.events.emit("failed", words);
  }

  private listen(): void {
    this.settings.watch((now, before) => {
      this.element.dataset.theme = now.theme;
      if (now === before || now.up !== before.up) this.stage.setUp(now.up);
      this.applyLook();
      if (now !== before && isOtherRequest(now, before)) this.requestSurfaces();
      if (now.playing !== before.playing && now.followView) this.requestSurfaces();
      this.overlays.show(now, this.info);
      this.playback.update();
      this.events.emit("settings", now);
    });
    this.queries.connection.state.watch(() => this.get().surfaces.forEach((_, at) => this.reportProgress(at)));
    this.queries.datasets.watch(() => {
      this.findDataset();
      this.applyLook();
    });
    this.stage.controls.addEventListener("change", () => {
      clearTimeout(this.restTimer);
      this.restTimer = window.setTimeout(() => this.cameraStopped(), 250);
    });
  }

  // View-dependent detail is paused if the first surface was slow, until the user switches it on.
  get isDetailPaused(): boolean {
    return this.detail.isPaused(this.get());
  }

  private get requestView(): View | null {
    return this.detail.view(this.get(), () => this.stage.view());
  }

  private cameraStopped(): void {
    if (this.settings.get().followView) this.requestSurfaces();
    if (!this.surfaces.isShown) return;
    const { eye, target } = this.stage.view();
    this.settings.set({ eye: eye as Vec3, target: target as Vec3 });
  }

  private findDataset(): void {
    const { list } = this.queries.datasets.get();
    if (!list) return;
    if (list.length === 0) return this.reading.begin();
    this.reading.close();
    const start = initialSelection(list, this.get());
    if (!start) return this.get().dataset ? this.reportUnknown(this.get().dataset) : undefined;
    if (start.changes) this.settings.set(start.changes);
    this.useDataset(start.info);
  }

  private get list(): readonly DatasetInfo[] {
    return this.queries.datasets.get().list ?? [];
  }

  private useDataset(now: DatasetInfo): void {
    const { info: before } = this;
    const isMember = before !== null && before.name !== now.name && isSameSeries(before, now);
    this.info = now;
    this.notices.clear();
    this.playback.update();
    if (isMember) {
      // Another time, field or label: places stay valid.
      this.events.emit("dataset", now);
      this.applyLook();
      return this.requestSurfaces();
    }
    this.overlays.setDataset(now);
    this.events.emit("dataset", now);
    const reservations = reservationsOf(now).join(" ");
    if (reservations && before?.name !== now.name) this.notices.announce(`"${now.name}": ${reservations}`, true);
    if (isSameData(before, now)) return; // After a lost connection: the stream resumes by itself.
    if (before) this.overlays.measuring.clear();
    this.overlays.show(this.get(), now);
    this.stage.setBounds(worldBox(now));
    const { eye, target } = this.settings.get();
    if (eye && target) this.stage.setView(eye, target);
    else if (!this.surfaces.firstShown) this.stage.defaultView();
    this.applyLook();
    this.requestSurfaces();
  }

  private requestSurfaces(): void {
    if (!this.info) return;
    const refusal = sceneRefusal(this.list, this.get(), this.info);
    if (!refusal) return this.surfaces.request(sceneOf(this.list, this.get(), this.info), this.get(), this.requestView, this.isDragging);
    this.set(refusal.change); // Requests the rest.
    this.notices.announce(refusal.text);
  }

  private applyLook(): void {
    const now = permittedSettings(this.get(), this.queries.datasets.get());
    const clip = clipPlanes(now, this.info);
    this.overlays.handles.show(now, this.info);
    this.surfaces.applyLook(now, clip, new Set(this.samples.labels?.labels.map(({ at }) => at)));
    this.element.classList.toggle("has-slices", now.layout === "four");
    this.samples.update();
    this.stage.setLook({
      isOrthographic: now.projection === "orthographic",
      hasOcclusion: now.occlusion,
      translucent: this.surfaces.translucent,
      clip,
    });
  }

  private reportProgress(surface: number): void {
    const progress = this.surfaces.progressOf(0);
    if (surface === 0) this.notices.show(progress, this.surfaces.firstShown && emptySurfaceText(this.surfaces.firstShown, progress));
    const { failure } = this.surfaces.progressOf(surface);
    if (failure?.needsView && this.get().followView && this.detail.require(failure.needsView)) queueMicrotask(() => this.requestSurfaces());
    this.events.emit("progress", { surface });
  }

  private reportShown(at: number, shown: ShownSurface, isFirst: boolean): void {
    const isLeading = at === this.surfaces.leader;
    if (isLeading && isFirst && !this.settings.get().eye)
      shown.info.member?.label || this.playback.times ? this.stage.frameBox(boxBetween(worldBox(shown.info))) : this.fit();
    this.samples.updateSlices();
    for (const tiles of this.surfaces.shownTiles(this.get(), at)) this.overlays.measuring.surfaceReplaced(tiles);
    const { complete } = this.surfaces.progressOf(at);
    if (isLeading && shown.facts.isFinal && this.detail.recordDuration(complete) && this.get().followView) this.requestSurfaces();
    this.surfaces.reports.add(at);
  }

  private receivePick(place: Picked): void {
    if (this.get().layout === "four") this.set({ cross: place.world });
    this.addPlace(place);
  }

  private addPlace(place: Picked): void {
    this.overlays.measuring.add(place);
    this.events.emit("picked", place);
  }
}
