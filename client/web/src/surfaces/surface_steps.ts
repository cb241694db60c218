// Prepares the steps of one surface for display: tiles are decoded and uploaded to the GPU while invisible; a step with
// all its tiles is checked, cached, and offered to the swap group.
//
// Nothing of a replaced stream is shown, and nothing coarser on the way to a finer surface of the same isovalue. If
// small components are hidden, a step is shown without them from the first frame in which it is drawn; hiding them in a shown step needs no
// server.

import type { MeshTopology } from "../mesh/boundary_matcher";
import { missingValues } from "../mesh/scalars";
import type { Surface } from "../scene/surface";
import { type HiddenParts, hidesNothing, isSameHiddenParts, nothingHidden } from "../state/hidden_parts";
import { noProgress, type Progress, type ShownComponents } from "../state/progress";
import { isSameSeries } from "../state/series";
import type { Store } from "../state/store";
import type { AssemblerEffect, StepOfTiles } from "../stream/assembler";
import type { Effect } from "../stream/conversation";
import { applied, dataBorder, inverse, latticeToWorld } from "../stream/dataset";
import { shellModeOf } from "../stream/step_checks";
import type { StepSpeed } from "../stream/step_speed";
import type { StreamRequest } from "../stream/stream_request";
import type { TilePool } from "../workers/tile_pool";
import type { CheckedStep, DrawnTiles } from "../workers/worker_messages";
import { type Committed, factsOf, isRegression, type ShownSurface, tileIdPrefix, tileIds } from "./shown_surface";
import { allComponents, type CachedStep, type StepCache, type VisibleComponents } from "./step_cache";
import type { SceneTime } from "./swap_group";

export interface SurfaceStepsParts {
  number: number; // The index of the surface in the view.
  pool: TilePool;
  surface: Surface;
  stepCache: StepCache;
  speed: StepSpeed; // The decoding speed of this page.
  isPrefetch?: boolean; // Steps are cached and never shown.
}

export interface SurfaceStepsEvents {
  // Offers a step of this time. `show` shows it, once, unless another step is offered or it is withdrawn.
  offer: (time: SceneTime, show: () => void) => void;
  withdraw: () => void;
  shown: (shown: ShownSurface, isFirstOfScene: boolean) => void;
}

// Listener for the outcome of a stream's tiles and steps.
export interface StepChecks {
  decoded: (stream: number, key: string) => void;
  damaged: (stream: number, text: string) => void;
  checked: (stream: number, step: StepOfTiles, topology: MeshTopology) => void;
}

// The request and its time.
export interface RequestAtTime {
  request: StreamRequest;
  time: SceneTime;
}

const none = 0; // Streams are numbered from 1.

export class SurfaceSteps {
  shown: ShownSurface | null = null;
  private drawnStep: CachedStep | null = null; // The shown step; null: none.
  private pendingStep: CachedStep | null = null; // A cached step that will be offered.
  private hidden = nothingHidden;
  private pendingSelections = 0; // Number of pending selections of components.
  private stream = none;
  private started = 0;
  private readonly arrived = new Map<number, { triangles: number; lastAt: number }>(); // Tiles, by step of the stream.
  private readonly scalars = new Map<string, NonNullable<Progress["scalars"]>>(); // By tile id.
  private coloring: Promise<void>[] = []; // Pending uploads of scalars of the running stream.
  private checked: { result: CheckedStep; visible: VisibleComponents } | null = null;

  constructor(
    private readonly parts: SurfaceStepsParts,
    private readonly progress: Store<Progress>,
    private readonly checks: StepChecks,
    private readonly events: SurfaceStepsEvents,
  ) {}

  // Begins a stream, which replaces the previous one or brings the final step after its previews.
  begin(stream: number, isFinishing: boolean): void {
    this.parts.pool.cancelJobs(this);
    this.stream = stream;
    this.pendingStep = null;
    this.coloring = [];
    this.arrived.clear();
    if (isFinishing) return this.progress.set({ isStreaming: true, tilesToCome: 0, tilesReceived: 0 });
    this.started = performance.now();
    this.events.withdraw();
    this.parts.surface.release(this);
    const { phase, shown, components, sizeToConfirm, scalars } = this.progress.get();
    this.progress.set({ ...noProgress, phase, shown, components, sizeToConfirm, scalars, isStreaming: true });
  }

  // Discards results that are pending.
  cancel(): void {
    this.stream = none;
    this.pendingStep = null;
    this.parts.pool.cancelJobs(this);
    this.parts.surface.release(this);
  }

  isCurrent(stream: number): boolean {
    return stream === this.stream;
  }

  // Hides components of the shown and later steps.
  hide(parts: HiddenParts): void {
    if (isSameHiddenParts(parts, this.hidden)) return;
    this.hidden = parts;
    void this.updateComponents();
  }

  // Whether the shown surface already omits the hidden components.
  get hasCurrentComponents(): boolean {
    return this.pendingSelections === 0;
  }

  // The drawn triangles, for picking, cutting and saving.
  get drawn(): DrawnTiles {
    const { drawnStep } = this;
    return drawnStep ? drawnOf(drawnStep.ids, drawnStep.shown, drawnStep.visible.hidden) : { ids: [], leastDiagonal: 0, hidden: [] };
  }

  // Offers a cached step instead of a stream, as soon as its small components are known.
  offerCached({ time }: RequestAtTime, step: CachedStep, offered: () => void): void {
    this.parts.surface.use(step.ids, this);
    const { phase, shown, components } = this.progress.get();
    this.progress.set({ ...noProgress, phase, shown, components });
    const offer = () => {
      this.events.offer(time, () => this.show(step, null));
      offered();
    };
    if (isSameHiddenParts(step.visible.hidden, this.hidden)) return offer();
    this.pendingStep = step;
    void this.selectComponents(step.ids, step.shown)
      .catch(() => step.visible)
      .then((visible) => {
        if (this.pendingStep !== step) return;
        step.visible = visible;
        offer();
      });
  }

  beginStep(request: StreamRequest, { tiles, missing, begin }: AssemblerEffect & { kind: "begun" }): void {
    const ids = tiles.map(({ key }) => tileIdPrefix(this.parts.number, request) + key);
    this.parts.surface.use(ids, this);
    this.progress.set({ step: begin.step, tilesToCome: missing, tilesReceived: 0, shareRead: 0 });
    this.arrived.set(begin.step, { triangles: 0, lastAt: 0 });
  }

  async decode(request: StreamRequest, { tile: expected, payload, begin }: AssemblerEffect & { kind: "decode" }): Promise<void> {
    const { stream } = this;
    const { tilesReceived, bytesReceived, firstTile } = this.progress.get();
    this.progress.set({
      tilesReceived: tilesReceived + 1,
      bytesReceived: bytesReceived + payload.length,
      firstTile: firstTile ?? performance.now() - this.started,
    });
    const resolution = begin.request!.lattice; // May be smaller for previews.
    const toWorld = latticeToWorld(request.info, resolution);
    const { triangles } = this.arrived.get(begin.step)!;
    this.arrived.set(begin.step, { triangles: triangles + expected.triangles, lastAt: performance.now() });
    try {
      const tile = await this.parts.pool.decode(
        {
          kind: "decode",
          id: tileIdPrefix(this.parts.number, request) + expected.key,
          payload,
          expected,
          resolution,
          shell: shellModeOf(begin),
          hasNormals: request.isosurface.normals > 0,
          linear: toWorld.slice(0, 9),
        },
        this,
      );
      this.parts.surface.add(tile, toWorld, begin.step);
      this.checks.decoded(stream, expected.key);
    } catch (error) {
      this.checks.damaged(stream, (error as Error).message);
    }
  }

  // A step is shown only with the values of all its tiles.
  color({ request, values: { key, codes, range, deviation } }: Effect & { kind: "scalars" }): void {
    const { pool, surface } = this.parts;
    const id = tileIdPrefix(this.parts.number, request) + key;
    const { low, high, bits } = range;
    this.scalars.set(id, { low, high, deviation, vertices: (8 * codes.length) / bits, missing: missingValues(codes, bits) });
    const done = pool.scalars(id, codes, bits).then(
      (attribute) => surface.setScalars(id, attribute),
      () => {},
    );
    this.coloring.push(done);
  }

  async check(request: StreamRequest, step: StepOfTiles): Promise<void> {
    const { stream } = this;
    const { begin } = step;
    const ids = tileIds(this.parts.number, request, step);
    const { triangles, lastAt } = this.arrived.get(begin.step)!;
    const { lattice: resolution, topologyTolerance } = begin.request!;
    const border = dataBorder(request.info, resolution, topologyTolerance, begin.finestSpacing || 1);
    const [result, visible] = await Promise.all([
      this.parts.pool.check(ids, border).catch(() => null),
      this.selectComponents(ids, { info: request.info, resolution }).catch(() => null),
      this.parts.surface.uploaded(ids),
      ...this.coloring,
    ]);
    // Tiles of a replaced stream may be gone.
    if (stream !== this.stream || !result || !visible) return;
    this.parts.speed.record(triangles, performance.now() - lastAt);
    this.checked = { result, visible };
    this.checks.checked(stream, step, result.topology);
  }

  // Offers a complete step if it is new, and caches the final one for `requested`.
  offerStep(request: StreamRequest, requested: RequestAtTime | null, committed: Committed, isNew: boolean): void {
    const { number, surface, stepCache, isPrefetch } = this.parts;
    const { begin } = committed.step;
    const facts = factsOf(request, committed);
    // Even for a skipped step: the mesh worker reports each change of normals once.
    for (const { id, normals } of this.checked?.result.normals ?? []) surface.setNormals(id, normals);
    const step: CachedStep = {
      ids: tileIds(number, request, committed.step),
      shown: { info: request.info, resolution: begin.request!.lattice, request: begin.request!, facts },
      visible: this.checked?.visible ?? allComponents,
    };
    if (facts.isFinal && requested) stepCache.keep({ ...requested.request, info: request.info }, step);
    if (isPrefetch || !requested || !isNew || isRegression(this.shown, request, facts)) return;
    const elapsed = performance.now() - this.started;
    this.events.offer(requested.time, () => this.show(step, elapsed));
  }

  // There is no surface at the requested time: others do not wait for it, and surfaces of other times are hidden.
  offerNothing({ request: { info }, time }: RequestAtTime): void {
    const { shown } = this;
    if (!shown || !isSameSeries(shown.info, info)) return;
    this.events.offer(time, () => shown.info !== info && this.showNothing());
  }

  private showNothing(): void {
    this.drawnStep = null;
    this.parts.surface.show([]);
  }

  // `elapsed`: milliseconds since the request; null: without a request.
  private show(step: CachedStep, elapsed: number | null): void {
    const { ids, shown, visible } = step;
    const before = this.shown;
    this.parts.surface.show(ids, visible.selection);
    this.drawnStep = step;
    this.shown = shown;
    const { firstSurface } = this.progress.get();
    this.progress.set({
      shown: shown.facts,
      components: componentsOf(visible),
      scalars: this.scalarsOf(ids),
      firstSurface: firstSurface ?? elapsed,
      complete: shown.facts.isFinal ? elapsed : null,
    });
    this.events.shown(shown, !before || !isSameSeries(before.info, shown.info));
    void this.updateComponents(); // The hidden parts may have changed meanwhile.
  }

  // Returns the scalars of shown tiles and deletes those of removed ones.
  private scalarsOf(ids: readonly string[]): Progress["scalars"] {
    for (const id of this.scalars.keys()) if (!this.parts.surface.hasAll([id])) this.scalars.delete(id);
    const all = ids.map((id) => this.scalars.get(id)).filter((one) => one !== undefined);
    if (all.length === 0) return null;
    const { low, high } = all[0];
    const sum = (of: "vertices" | "missing") => all.reduce((before, one) => before + one[of], 0);
    return { low, high, deviation: Math.max(...all.map(({ deviation }) => deviation)), vertices: sum("vertices"), missing: sum("missing") };
  }

  private async selectComponents(ids: readonly string[], lattice: Lattice): Promise<VisibleComponents> {
    const { hidden } = this;
    if (hidesNothing(hidden)) return allComponents;
    return { hidden, selection: await this.parts.pool.select(drawnOf(ids, lattice, hidden)) };
  }

  // Updates the shown components to the current hidden parts.
  private async updateComponents(): Promise<void> {
    const { drawnStep } = this;
    if (!drawnStep || isSameHiddenParts(drawnStep.visible.hidden, this.hidden)) return;
    ++this.pendingSelections;
    const visible = await this.selectComponents(drawnStep.ids, drawnStep.shown).catch(() => null);
    --this.pendingSelections;
    if (!visible || drawnStep !== this.drawnStep || !isSameHiddenParts(visible.hidden, this.hidden)) return;
    drawnStep.visible = visible;
    this.parts.surface.show(drawnStep.ids, visible.selection);
    this.progress.set({ components: componentsOf(visible) });
    this.events.shown(drawnStep.shown, false);
  }
}

type Lattice = Pick<ShownSurface, "info" | "resolution">;

function drawnOf(ids: readonly string[], { info, resolution }: Lattice, { minComponent, places, largestOnly }: HiddenParts): DrawnTiles {
  const toLattice = inverse(latticeToWorld(info, resolution));
  return { ids, leastDiagonal: minComponent * 2 ** resolution, hidden: places.map((place) => applied(toLattice, place)), largestOnly };
}

function componentsOf({ hidden: { minComponent }, selection }: VisibleComponents): ShownComponents | null {
  if (!selection) return null;
  const { components, shown, triangles } = selection;
  return { minComponent, components, shown, triangles };
}
