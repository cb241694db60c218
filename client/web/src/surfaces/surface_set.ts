// The surfaces of one view. If they are few, each has a connection with one stream at a time; many share a few
// connections. The server schedules connections fairly. Surfaces request their final steps when the previews of all
// have arrived; a dragged one does not wait, and many surfaces request one coarse preview each.
import * as THREE from "three";
import type { MeshFormat } from "../mesh/mesh_file";
import type { DatasetInfo } from "../protocol/messages";
import { FieldColors } from "../scene/field_colors";
import type { Stage } from "../scene/stage";
import { Surface } from "../scene/surface";
import { hiddenPartsOf } from "../state/hidden_parts";
import { noProgress, type Progress, type ServedProgress, type SurfaceSize, type SurfacesStatus } from "../state/progress";
import { isSameData, nameOfLabel } from "../state/series";
import type { Settings } from "../state/settings";
import { Store } from "../state/store";
import { settingsOf } from "../state/surfaces";
import { ConnectionPool } from "../stream/connection_pool";
import type { DatasetQueries } from "../stream/dataset_queries";
import { type MeshReply, requestMesh } from "../stream/mesh_request";
import type { View } from "../stream/request";
import { ServerConnection } from "../stream/server_connection";
import { SharedPreviews } from "../stream/shared_previews";
import { StepSpeed } from "../stream/step_speed";
import type { RequestedSteps } from "../stream/stream_request";
import type { ViewerEvents } from "../viewer/viewer_events";
import type { TilePool } from "../workers/tile_pool";
import { shareOfLabel } from "./expected_sizes";
import { Prefetcher } from "./prefetcher";
import type { Scene } from "./scene_at";
import { ShownReports } from "./shown_reports";
import type { ShownSurface, ShownTiles } from "./shown_surface";
import { StepCache } from "./step_cache";
import { SurfaceClient, type SurfaceClientParts } from "./surface_client";
import { type SceneTime, SwapGroup } from "./swap_group";

interface Member {
  client: SurfaceClient;
  surface: Surface;
  prefetcher: Prefetcher;
  key: string; // Its key: dataset, isovalue and error.
}

export interface SurfaceSetEvents {
  shown: (at: number, shown: ShownSurface, isFirstOfScene: boolean) => void;
  drawn: (shown: ViewerEvents["shown"]) => void;
  progress: (at: number) => void;
}

const maxWithPreviews = 24; // With more surfaces, one coarse preview of each is requested, so that all are visible soon.
const maxConnections = 6;

export class SurfaceSet {
  readonly sizes = new Store<{ expected: SurfaceSize | null }>({ expected: null });
  readonly reports = new ShownReports(
    this,
    () => this.look!.settings,
    (shown) => this.events.drawn(shown),
  );
  readonly field = new FieldColors(() => this.stage.invalidate());
  private members: Member[] = [];
  private lastNumber = 0;
  private requested: DatasetInfo | null = null; // The dataset of the view at the last request.
  private look: { settings: Settings; clip: readonly THREE.Plane[]; hidden: ReadonlySet<number> } | null = null;
  private readonly connections: ConnectionPool;
  private readonly sharedPreviews: SharedPreviews;
  private readonly speed = new StepSpeed(); // The decoding speed of this page.
  private readonly swapGroup = new SwapGroup<Member>(
    () => this.visibleMembers,
    () => this.updateLooks(),
  );

  constructor(
    private readonly server: string,
    private readonly token: () => string,
    private readonly pool: TilePool,
    private readonly stage: Stage,
    private readonly queries: DatasetQueries,
    private readonly events: SurfaceSetEvents,
  ) {
    this.connections = new ConnectionPool(() => new ServerConnection(server, token, ""), maxConnections);
    this.sharedPreviews = new SharedPreviews(server, token);
    this.members = [this.createMember()];
    stage.waitFor(() => this.visibleMembers.some(({ client }) => client.progress.get().isStreaming));
    stage.everyFrame(() => this.members.map(({ surface }) => surface.uploadSome()).some(Boolean));
  }

  // Connects, or connects again.
  connect(): void {
    this.queries.connect();
    this.connections.connect();
  }

  close(): void {
    for (const member of this.members.splice(0)) this.removeMember(member);
    this.sharedPreviews.close();
    this.connections.close();
  }

  // Resolves when everything visible of the dataset is complete or has failed, or when `isEnough`. Rejects when
  // aborted.
  async settled(info: () => DatasetInfo | null, isEnough = () => false, signal?: AbortSignal): Promise<void> {
    const isUnknown = () => this.queries.datasets.get().list !== null && !info();
    const isThere = () => isSameData(this.requested, info()) || this.progressOf(0).failure !== null || isUnknown();
    while (!isEnough() && (!this.isSettled || !isThere())) {
      await new Promise((resolve) => setTimeout(resolve, 20));
      signal?.throwIfAborted();
    }
  }

  // Hidden surfaces are requested when they become visible.
  request({ infos, time, scalars }: Scene, settings: Settings, view: View | null, isDragging: boolean): void {
    this.matchMembers(settings);
    this.look = { clip: [], hidden: new Set(), ...this.look, settings };
    const list = settings.surfaces;
    const wanted = this.members.flatMap((member, at) => (infos[at] && list[at]?.visible ? [{ member, at }] : []));
    this.requested = infos[0];
    this.shareBudget(
      settings.drawableTriangles,
      wanted.reduce((sum, { at }) => sum + shareOfLabel(infos[at]!), 0),
    );
    const steps = stepsToRequest(wanted.length, isDragging);
    for (const { member, at } of wanted) {
      member.client.request(infos[at]!, settingsOf(settings, at), view, { time, scalars, isDragging, steps });
    }
    this.finishAll();
    this.reports.update();
  }

  confirmSize(): void {
    for (const { client } of this.members) client.confirmSize();
  }

  // Prefetches several times of a series, the first ones as far as memory allows. Empty: none.
  prepare(scenes: readonly Scene[], settings: Settings, view: View | null): void {
    this.members.forEach((member, at) => {
      const wanted = this.isVisible(member) ? scenes.filter(({ infos }) => infos[at]) : [];
      const requests = wanted.map(({ infos, time, scalars }) => ({ info: infos[at]!, time, scalars }));
      member.prefetcher.prepare(requests, settingsOf(settings, at), view);
    });
  }

  // Returns whether all visible surfaces have their final step or have failed.
  isPrepared({ infos, scalars }: Scene, settings: Settings, view: View | null): boolean {
    return this.members.every(
      (member, at) => !infos[at] || !this.isVisible(member) || member.prefetcher.has({ info: infos[at], scalars }, settingsOf(settings, at), view),
    );
  }

  // `hidden`: places of surfaces that are not drawn, because the volume shows them.
  applyLook(settings: Settings, clip: readonly THREE.Plane[], hidden: ReadonlySet<number>): void {
    this.matchMembers(settings);
    this.look = { settings, clip, hidden };
    this.swapGroup.update();
    this.updateLooks();
  }

  // The number of translucent surfaces.
  get translucent(): number {
    return this.members.filter(({ surface }) => surface.isTranslucent).length;
  }

  // The place of the first visible surface, which the view follows; 0 if none is.
  get leader(): number {
    return Math.max(0, this.members.indexOf(this.visibleMembers[0]));
  }

  // What is shown of it.
  get firstShown(): ShownSurface | null {
    return this.members[this.leader].client.shown;
  }

  // Whether it is shown, or none is visible.
  get isShown(): boolean {
    return this.visibleMembers.length === 0 || this.firstShown !== null;
  }

  progressOf(at: number): ServedProgress {
    const { phase, retryAt, failure } = this.queries.connection.state.get();
    const own = this.members[at]?.client.progress.get() ?? noProgress;
    return { ...own, phase, retryAt, failure: failure ?? own.failure };
  }

  // Returns whether the surface that is shown at this place is the one requested last.
  isCurrent(at: number): boolean {
    return this.members[at]?.client.isCurrent ?? false;
  }

  // The progress of the first visible surface, and the totals of all drawn ones.
  get status(): SurfacesStatus {
    const { visibleMembers } = this;
    const [first = this.members[0]] = visibleMembers;
    const numbers = new Map(this.members.map((member, at) => [member, at + 1]));
    const drawn = visibleMembers.flatMap((member) => {
      const { shown, components } = member.client.progress.get();
      const isDrawn = shown && member.client.shown && this.swapGroup.isDrawable(member);
      const label = isDrawn && member.client.shown!.info.member?.label;
      return isDrawn ? [{ number: numbers.get(member)!, shown, components, label: label ? nameOfLabel(label, this.look!.settings) : undefined }] : [];
    });
    return {
      progress: this.progressOf(this.members.indexOf(first)),
      drawn,
      done: visibleMembers.filter(({ client }) => isDone(client.progress.get())).length,
      visible: visibleMembers.length,
    };
  }

  // Returns the shown and visible surfaces; all, or only one.
  shownTiles(settings: Settings, only: number | null = null): ShownTiles[] {
    const list = settings.surfaces;
    const members = only === null ? this.members : this.members.slice(only, only + 1);
    return members.flatMap((member, i) => {
      const at = i + (only ?? 0);
      const {
        client: { shown, drawn, progress },
      } = member;
      const hasAny = drawn.ids.length > 0 && progress.get().components?.shown !== 0;
      const isDrawn = list[at]?.visible && this.swapGroup.isDrawable(member) && hasAny;
      return shown && isDrawn ? [{ at, shown, drawn, color: list[at].color, opacity: list[at].opacity }] : [];
    });
  }

  // Whether any visible surface is that of a label.
  get hasLabels(): boolean {
    return this.visibleMembers.some(({ client }) => client.shown?.info.member?.label !== undefined);
  }

  // Returns the server's file of a shown surface, as its settings require. Rejects with a reason.
  file({ at, shown: { info, facts } }: ShownTiles, settings: Settings, format: MeshFormat): Promise<MeshReply> {
    return requestMesh(this.server, this.token(), info, facts.isovalue, settingsOf(settings, at), format);
  }

  // The box of the visible surfaces; of all if none is.
  worldBox(): THREE.Box3 {
    const { visibleMembers } = this;
    return (visibleMembers.length > 0 ? visibleMembers : this.members).reduce((box, { surface }) => box.union(surface.worldBox()), new THREE.Box3());
  }

  // Whether nothing more is being received for visible surfaces.
  get isSettled(): boolean {
    return this.visibleMembers.every(({ client }) => client.isSettled);
  }

  private updateLooks(): void {
    if (!this.look) return;
    const { settings, clip, hidden } = this.look;
    const list = settings.surfaces;
    this.members.forEach((member, at) => {
      if (!list[at]) return;
      const visible = list[at].visible && !hidden.has(at) && this.swapGroup.isDrawable(member);
      member.surface.applyLook({ ...settings, ...list[at], visible }, clip);
      member.client.hide(hiddenPartsOf(list[at]));
    });
  }

  private get visibleMembers(): Member[] {
    const list = this.look?.settings.surfaces ?? [];
    return this.members.filter((_, at) => list[at]?.visible);
  }

  private isVisible(member: Member): boolean {
    return this.look?.settings.surfaces[this.members.indexOf(member)]?.visible ?? false;
  }

  // Divides memory and the triangles that need no confirmation.
  private shareBudget(drawable: number, among: number): void {
    for (const { surface, client } of this.members) {
      surface.drawable = drawable;
      surface.budget = drawable / Math.max(1, among);
      client.sizes.surfaceCount = among;
    }
  }

  // Requests the final steps when the previews of all have arrived, largest labels first.
  private finishAll(): void {
    if (this.members.some(({ client }) => client.isPreviewing)) return;
    const previewed = this.members.filter(({ client }) => client.isPreviewed);
    const size = ({ client }: Member) => Number(client.shown?.info.member?.label?.samples ?? 0);
    for (const { client } of previewed.sort((a, b) => size(b) - size(a))) client.finish();
  }

  // Creates as many members as surfaces. A member that has the data of a surface is reused for it, even when members
  // before it were removed.
  private matchMembers(settings: Settings): void {
    const wanted = settings.surfaces.map(({ dataset, isovalue, error }) => `${dataset} ${isovalue} ${error ?? settings.error}`);
    const before = this.members;
    const places = reusedMembers(
      before.map(({ key }) => key),
      wanted,
    );
    this.members = places.map((place) => (place === null ? this.createMember() : before[place]));
    this.members.forEach((member, at) => (member.key = wanted[at]));
    for (const member of before) if (!this.members.includes(member)) this.removeMember(member);
    const moved = this.members.filter((member, at) => before[at] !== member);
    queueMicrotask(() => moved.forEach((member) => this.reportProgress(member))); // When the list of surfaces is shown.
    if (this.members[0] !== before[0]) this.sizes.set(this.members[0].client.sizes.get());
  }

  private createMember(): Member {
    const { scene } = this.stage;
    const surface = new Surface(
      scene,
      () => this.scheduleFrame(true),
      () => this.scheduleFrame(false),
      (ids) => this.pool.drop(ids),
      this.field,
      this.stage.programs,
    );
    const { pool, queries, speed, connections, sharedPreviews } = this;
    const isFirst = () => this.members[0] === member;
    const stepCache = new StepCache((ids) => surface.hasAll(ids));
    const parts: SurfaceClientParts = { number: ++this.lastNumber, pool, surface, queries, stepCache, speed, connections, sharedPreviews, isFirst };
    const client = new SurfaceClient(parts, {
      offer: (time, show) => this.offer(member, time, show),
      withdraw: () => this.swapGroup.withdraw(member),
      shown: (shown, isFirst) => this.events.shown(this.members.indexOf(member), shown, isFirst),
      settled: () => this.finishAll(),
    });
    const prefetches = new ConnectionPool(() => new ServerConnection(this.server, this.token, "prefetch"), 1);
    const member: Member = { client, surface, prefetcher: new Prefetcher({ ...parts, connections: prefetches }), key: "" };
    client.progress.watch(() => this.reportProgress(member));
    client.sizes.watch(() => isFirst() && this.sizes.set(client.sizes.get()));
    return member;
  }

  // With many surfaces some arrive in every frame: drawing each time would take longer than receiving them.
  private scheduleFrame(isOther: boolean): void {
    const isCrowded = this.members.length > maxWithPreviews;
    if (isOther) isCrowded ? this.stage.invalidateSoon() : this.stage.invalidate();
    else isCrowded ? this.stage.wakeSoon() : this.stage.wake();
  }

  private offer(member: Member, time: SceneTime, show: () => void): void {
    const wasOpen = this.swapGroup.isDrawable(member);
    this.swapGroup.offer(member, time, show);
    if (wasOpen !== this.swapGroup.isDrawable(member)) this.updateLooks();
  }

  private reportProgress(member: Member): void {
    const at = this.members.indexOf(member);
    if (at >= 0) this.events.progress(at);
  }

  private removeMember(member: Member): void {
    const { client, surface, prefetcher } = member;
    this.swapGroup.remove(member);
    client.close();
    prefetcher.close();
    this.pool.drop(surface.ids(""));
    surface.dispose();
  }
}

// Returns the steps to request of each surface.
export function stepsToRequest(surfaces: number, isDragging: boolean): RequestedSteps {
  if (surfaces > maxWithPreviews) return "coarse";
  return surfaces > 1 && !isDragging ? "previews" : "all";
}

// For each wanted surface, returns the index of an existing one to reuse: one with the same key, else the one at its
// place if it is not needed elsewhere, else null.
export function reusedMembers(have: readonly string[], wanted: readonly string[]): (number | null)[] {
  const taken = new Set<number>();
  const take = (place: number) => {
    if (place < 0 || taken.has(place)) return null;
    taken.add(place);
    return place;
  };
  const places = wanted.map((one, at) => (have[at] === one ? take(at) : null));
  wanted.forEach((one, at) => (places[at] ??= take(have.findIndex((other, i) => other === one && !taken.has(i)))));
  wanted.forEach((_, at) => (places[at] ??= at < have.length ? take(at) : null));
  return places;
}

function isDone({ isStreaming, shown, failure }: Progress): boolean {
  return !isStreaming && (shown?.isFinal === true || failure !== null);
}
