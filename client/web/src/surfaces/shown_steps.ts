// Shows the steps of one surface, by offering them to the swap group.
//
// Nothing coarser is shown on the way to a finer surface of the same isovalue. If small components are hidden, a step is
// shown without them from the first frame in which it is drawn; hiding them in a shown step needs no server.
import type { Surface } from "../scene/surface";
import { type HiddenParts, hidesNothing, isSameHiddenParts, nothingHidden } from "../state/hidden_parts";
import { noProgress, type Progress, type ShownComponents } from "../state/progress";
import { isSameSeries } from "../state/series";
import type { Store } from "../state/store";
import { applied, inverse, latticeToWorld } from "../stream/dataset";
import type { StreamRequest } from "../stream/stream_request";
import type { TilePool } from "../workers/tile_pool";
import type { DrawnTiles } from "../workers/worker_messages";
import { isRegression, type ShownSurface } from "./shown_surface";
import { allComponents, type CachedStep, type VisibleComponents } from "./step_cache";
import type { SceneTime } from "./swap_group";

export interface ShownStepsEvents {
  // Offers a step of this time. `show` shows it, once, unless another step is offered or it is withdrawn.
  offer: (time: SceneTime, show: () => void) => void;
  withdraw: () => void;
  shown: (shown: ShownSurface, isFirstOfScene: boolean) => void;
}

// The request and its time.
export interface RequestAtTime {
  request: StreamRequest;
  time: SceneTime;
}

export class ShownSteps {
  shown: ShownSurface | null = null;
  private drawnStep: CachedStep | null = null; // The shown step; null: none.
  private pendingStep: CachedStep | null = null; // A cached step that will be offered.
  private hidden = nothingHidden;
  private pendingSelections = 0; // Number of pending selections of components.

  constructor(
    private readonly parts: { pool: TilePool; surface: Surface },
    private readonly progress: Store<Progress>,
    private readonly scalarsOf: (ids: readonly string[]) => Progress["scalars"],
    private readonly events: ShownStepsEvents,
  ) {}

  // A cached step is no longer needed.
  cancel(): void {
    this.pendingStep = null;
    this.parts.surface.release(this);
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
    const { shown, components } = this.progress.get();
    this.progress.set({ ...noProgress, shown, components });
    const offer = () => {
      this.events.offer(time, () => this.show(step, null));
      offered();
    };
    if (isSameHiddenParts(step.visible.hidden, this.hidden)) return offer();
    this.pendingStep = step;
    void this.select(step.ids, step.shown)
      .catch(() => step.visible)
      .then((visible) => {
        if (this.pendingStep !== step) return;
        step.visible = visible;
        offer();
      });
  }

  // Offers a received step, unless a better one is shown.
  offer({ request, time }: RequestAtTime, step: CachedStep, elapsed: number): void {
    if (!isRegression(this.shown, request, step.shown.facts)) this.events.offer(time, () => this.show(step, elapsed));
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

  // Returns the components to show.
  async select(ids: readonly string[], lattice: Lattice): Promise<VisibleComponents> {
    const { hidden } = this;
    if (hidesNothing(hidden)) return allComponents;
    return { hidden, selection: await this.parts.pool.call("select", drawnOf(ids, lattice, hidden)) };
  }

  // Updates the shown components to the current hidden parts.
  private async updateComponents(): Promise<void> {
    const { drawnStep } = this;
    if (!drawnStep || isSameHiddenParts(drawnStep.visible.hidden, this.hidden)) return;
    ++this.pendingSelections;
    const visible = await this.select(drawnStep.ids, drawnStep.shown).catch(() => null);
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
