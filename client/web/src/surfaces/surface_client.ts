// Requests one surface: converts settings to requests. tile_stream.ts receives the steps, shown_steps.ts shows them.
//
// While the isovalue is dragged, only one request is in flight: the next one follows when the previous surface was
// shown or takes too long. At the end of the drag the last request continues to its final step.
//
// The size of a surface is estimated in parallel with its stream. A surface too large for most machines is replaced by
// the best one of a safe size, and the user may request it anyway.
//
// With several surfaces the previews of all precede the final step of any: clients request previews first, and the rest
// when all previews have arrived. A client with `isPrefetch` fetches final steps that are needed soon, and shows
// nothing.
import type { DatasetInfo } from "../protocol/messages";
import { latestOnly } from "../shared/latest_only";
import { type HiddenParts, hiddenPartsOf } from "../state/hidden_parts";
import { noProgress, type Progress } from "../state/progress";
import { Store } from "../state/store";
import type { OwnSettings } from "../state/surfaces";
import type { DatasetQueries } from "../stream/dataset_queries";
import { isosurfaceRequest, isSameRequest, type View } from "../stream/request";
import { isSameStream, type RequestedSteps, type ScalarOptions, type StreamRequest } from "../stream/stream_request";
import type { DrawnTiles } from "../workers/worker_messages";
import { ExpectedSizes } from "./expected_sizes";
import { type RequestAtTime, ShownSteps, type ShownStepsEvents } from "./shown_steps";
import type { ShownSurface } from "./shown_surface";
import type { CachedStep, StepCache } from "./step_cache";
import type { SceneTime } from "./swap_group";
import { TileStream, type TileStreamParts } from "./tile_stream";

const maxDragWait = 400; // Milliseconds that a drag waits for a preview.

export interface SurfaceClientParts extends TileStreamParts {
  queries: DatasetQueries;
  stepCache: StepCache;
}

export interface SurfaceClientEvents extends ShownStepsEvents {
  settled: () => void; // Nothing is in progress or scheduled.
}

// How a surface is requested.
export interface SurfaceRequest {
  time: SceneTime;
  scalars?: ScalarOptions;
  isDragging?: boolean; // More requests follow soon.
  steps?: RequestedSteps; // Default: all. After "previews" or "coarse", finish() requests the rest.
}

export class SurfaceClient {
  readonly progress = new Store<Progress>(noProgress);
  readonly sizes = new ExpectedSizes();
  private readonly stream: TileStream;
  private readonly steps: ShownSteps;
  private requested: RequestAtTime | null = null; // The request that is running or shown.
  private current: StreamRequest | null = null; // The running request, with a budget if it is too large.
  private next: RequestAtTime | null = null; // Waits for the running request.
  private isDragging = false;
  private dragTimer = 0;
  private isActive = false; // Streaming, or preparing to.
  private hasFinal = false; // The final step of the stream has begun.
  private readonly estimate = latestOnly((request: StreamRequest) => this.receiveSize(request));

  constructor(
    private readonly parts: SurfaceClientParts,
    private readonly events: SurfaceClientEvents,
  ) {
    this.stream = new TileStream(parts, this.progress, {
      opened: (isFinishing) => {
        this.steps.cancel();
        if (!isFinishing) events.withdraw();
      },
      begun: ({ isFinal }) => (this.hasFinal ||= isFinal),
      select: (ids, lattice) => this.steps.select(ids, lattice),
      committed: (step, isNew, elapsed) => this.receiveStep(step, isNew, elapsed),
      postponed: () => events.settled(),
      ended: (hasFailed) => this.endStream(hasFailed),
    });
    this.steps = new ShownSteps(parts, this.progress, (ids) => this.stream.scalarsOf(ids), events);
  }

  // Ends permanently.
  close(): void {
    clearTimeout(this.dragTimer);
    this.stop();
  }

  // Requests another surface.
  request(info: DatasetInfo, settings: OwnSettings, view: View | null, options: SurfaceRequest): void {
    const { time, scalars, isDragging = false } = options;
    const steps = this.parts.isPrefetch ? "final" : (options.steps ?? "all");
    const request: StreamRequest = { info, isosurface: isosurfaceRequest(info, settings, view), scalars, steps };
    this.isDragging = isDragging;
    this.hide(hiddenPartsOf(settings));
    this.requestSize(request, isDragging);
    const { failure } = this.progress.get();
    const isRepeated = failure !== null && !failure.needsView; // A surface that is too large stays so.
    if (this.requested && isSameStream(this.requested.request, request) && !isRepeated) {
      this.next = null;
      return;
    }
    const cached = this.parts.stepCache.find(request);
    if (cached) this.showCached({ request, time }, cached);
    else if (isDragging && this.dragTimer) this.next = { request, time };
    else this.open({ request, time });
  }

  get shown(): ShownSurface | null {
    return this.steps.shown;
  }

  // Whether the shown surface is the one requested last.
  get isCurrent(): boolean {
    const latest = (this.next ?? this.requested)?.request;
    const { shown } = this;
    return shown?.info.name === latest?.info.name && shown?.request.isovalue === latest?.isosurface.isovalue;
  }

  get drawn(): DrawnTiles {
    return this.steps.drawn;
  }

  // Hides components; needs no request.
  hide(parts: HiddenParts): void {
    this.steps.hide(parts);
  }

  // Whether previews have arrived and the final step was not requested.
  get isPreviewed(): boolean {
    return !this.isActive && isPreviews(this.current) && !this.hasFinal;
  }

  // Whether previews are being received.
  get isPreviewing(): boolean {
    return this.isActive && isPreviews(this.current) && !this.progress.get().postponed;
  }

  // Whether it is waiting for the server.
  get isBusy(): boolean {
    return this.isActive && !this.stream.isReceived;
  }

  // Whether nothing more is being received, and the shown surface is up to date.
  get isSettled(): boolean {
    return !this.isActive && !this.isPreviewed && this.steps.hasCurrentComponents;
  }

  // Cancels the current request.
  stop(): void {
    this.next = this.requested = this.current = null;
    this.stream.stop();
    this.steps.cancel();
    this.isActive = false;
  }

  // Requests the final step after the previews.
  finish(): void {
    if (this.isPreviewed) this.startStream({ ...this.current!, steps: "final" }, true);
  }

  // Requests the surface that the server sent with a budget because of its size.
  confirmSize(): void {
    const { sizeToConfirm } = this.progress.get();
    if (!sizeToConfirm || !this.requested) return;
    this.sizes.confirm(sizeToConfirm);
    this.open(this.requested);
  }

  // ----

  // Only the size of the first surface is shown.
  private requestSize(request: StreamRequest, isDragging: boolean): void {
    if (!this.parts.isFirst() && this.sizes.isSmall(request.info)) return;
    if (this.sizes.isWanted(request, isDragging)) this.estimate(request);
  }

  private async receiveSize(request: StreamRequest): Promise<void> {
    const size = await this.parts.queries.estimate(request.info.name, request.isosurface).catch(() => null);
    if (!size) return this.sizes.forget(request);
    const expected = this.sizes.record(request, size);
    const isCurrent = this.requested && isSameRequest(this.requested.request.isosurface, request.isosurface);
    if (!isCurrent || this.isDragging || this.sizes.isAllowed(expected)) return;
    this.progress.set({ sizeToConfirm: expected });
    this.startStream(this.sizes.withBudget(request));
  }

  private open(requested: RequestAtTime): void {
    const { request } = requested;
    this.next = null;
    this.requested = requested;
    this.progress.set({ sizeToConfirm: null });
    this.parts.stepCache.beginColoring(request);
    this.parts.surface.dropUnused();
    clearTimeout(this.dragTimer);
    this.dragTimer = this.isDragging ? window.setTimeout(() => this.requestNext(), maxDragWait) : 0;
    this.startStream(request);
  }

  private startStream(request: StreamRequest, isFinishing = false): void {
    this.current = request;
    this.hasFinal = false;
    this.isActive = true;
    this.stream.start(request, isFinishing);
  }

  // Shows a final step that is already cached.
  private showCached(requested: RequestAtTime, cached: CachedStep): void {
    this.stop();
    this.requested = requested;
    this.current = requested.request;
    this.hasFinal = true;
    clearTimeout(this.dragTimer);
    this.dragTimer = 0;
    this.isActive = true;
    this.steps.offerCached(requested, cached, () => {
      this.isActive = false;
      this.events.settled();
    });
  }

  // Called when the surface that a drag waited for has arrived or is late.
  private requestNext(): void {
    clearTimeout(this.dragTimer);
    this.dragTimer = 0;
    if (this.next) this.open(this.next);
  }

  // Offers a complete step, and caches the final one.
  private receiveStep(step: CachedStep, isNew: boolean, elapsed: number): void {
    const { requested } = this;
    const { info, facts } = step.shown;
    if (facts.isFinal && requested) this.parts.stepCache.keep({ ...requested.request, info }, step);
    if (this.parts.isPrefetch) return;
    if (requested && isNew) this.steps.offer(requested, step, elapsed);
    this.requestNext();
  }

  private endStream(hasFailed: boolean): void {
    if (hasFailed) this.hasFinal = true; // Nothing is left to request.
    if (hasFailed && this.requested) this.steps.offerNothing(this.requested);
    this.isActive = false;
    this.requestNext();
    if (!this.isActive) this.events.settled();
  }
}

function isPreviews(request: StreamRequest | null): boolean {
  return request?.steps === "previews" || request?.steps === "coarse";
}
