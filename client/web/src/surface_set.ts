// The surfaces of one view. Each has a connection of its own, on which one stream runs at a time: the
// server is fair between them, so that previews of all are there before the final step of any, and one
// that is dragged waits for no other.
import * as THREE from "three";

import type { DatasetInfo } from "./protocol/messages";
import { FieldColours } from "./scene/field_colours";
import type { Stage } from "./scene/stage";
import { Surface } from "./scene/surface";
import type { ShownSurface } from "./shown_surface";
import { noProgress, type Progress, type SurfaceSize } from "./state/progress";
import type { Settings } from "./state/settings";
import { Store } from "./state/store";
import { settingsOf, surfacesOf } from "./state/surfaces";
import type { View } from "./stream/request";
import { SurfaceClient } from "./surface_client";
import type { TilePool } from "./workers/tile_pool";

interface Member {
  client: SurfaceClient;
  surface: Surface;
  asked: string; // What tells it from others: isovalue and error.
}

// One that is shown, for who measures, cuts or saves it.
export interface ShownTiles {
  shown: ShownSurface;
  ids: readonly string[];
  colour: string;
}

export interface SurfaceSetEvents {
  shown: (at: number, shown: ShownSurface, isFirstOfDataset: boolean) => void;
  progress: (at: number) => void; // Of one beside the first.
}

export class SurfaceSet {
  // Of the first surface, whichever that is.
  readonly progress = new Store<Progress>(noProgress);
  readonly datasets = new Store<{ list: DatasetInfo[] | null }>({ list: null });
  readonly sizes = new Store<{ expected: SurfaceSize | null }>({ expected: null });
  readonly field = new FieldColours();
  private members: Member[] = [];
  private lastNumber = 0;
  private isConnected = false;

  constructor(
    private readonly server: string,
    private readonly token: () => string,
    private readonly pool: TilePool,
    private readonly stage: Stage,
    private readonly events: SurfaceSetEvents,
  ) {
    this.members = [this.member()];
    stage.everyFrame(() => this.members.map(({ surface }) => surface.uploadSome()).some(Boolean));
  }

  connect(): void {
    this.isConnected = true;
    for (const { client } of this.members) client.connect();
  }

  close(): void {
    for (const member of this.members.splice(0)) this.part(member);
  }

  want(info: DatasetInfo, settings: Settings, view: View, isDragging: boolean): void {
    this.arrange(settings);
    this.members.forEach(({ client }, at) => client.want(info, settingsOf(settings, at)!, view, isDragging));
  }

  insist(): void {
    this.members[0].client.insist();
  }

  applyLook(settings: Settings, clip: THREE.Plane | null): void {
    this.arrange(settings);
    const list = surfacesOf(settings);
    this.members.forEach(({ surface }, at) => surface.applyLook({ ...settings, ...list[at] }, clip));
  }

  get hasTranslucent(): boolean {
    return this.members.some(({ surface }) => surface.isTranslucent);
  }

  get lead(): ShownSurface | null {
    return this.members[0].client.shown;
  }

  progressOf(at: number): Progress {
    return this.members[at]?.client.progress.get() ?? noProgress;
  }

  // Those that are shown and not hidden, of the settings' surfaces.
  shownTiles(settings: Settings): ShownTiles[] {
    const list = surfacesOf(settings);
    return this.members.flatMap(({ client: { shown }, surface }, at) =>
      shown && list[at]?.visible && surface.shownIds.length > 0 
        ? [{ shown, ids: surface.shownIds, colour: list[at].colour }] : []);
  }

  worldBox(): THREE.Box3 {
    return this.members.reduce((box, { surface }) => box.union(surface.worldBox()), new THREE.Box3());
  }

  // As many members as surfaces. Who has what a surface wants becomes its member, also where others
  // before it have gone.
  private arrange(settings: Settings): void {
    const wanted = surfacesOf(settings).map((one) => `${one.isovalue} ${one.error ?? settings.error}`);
    const before = this.members;
    const places = arrangement(before.map(({ asked }) => asked), wanted);
    this.members = places.map((place) => (place === null ? this.member() : before[place]));
    this.members.forEach((member, at) => (member.asked = wanted[at]));
    for (const member of before) if (!this.members.includes(member)) this.part(member);
    if (this.members[0] !== before[0]) this.followLead();
  }

  private member(): Member {
    const { scene } = this.stage;
    const surface = new Surface(scene, () => this.stage.invalidate(), (ids) => this.pool.drop(ids), this.field);
    const number = ++this.lastNumber;
    const client = new SurfaceClient(number, this.server, this.token, this.pool, surface, (shown, isFirst) =>
      this.events.shown(this.members.indexOf(member), shown, isFirst));
    const member: Member = { client, surface, asked: "" };
    const isLead = () => this.members[0] === member;
    client.progress.watch(() => {
      if (isLead()) this.progress.set(client.progress.get());
      else if (this.members.includes(member)) this.events.progress(this.members.indexOf(member));
    });
    client.datasets.watch(() => isLead() && this.datasets.set(client.datasets.get()));
    client.sizes.watch(() => isLead() && this.sizes.set(client.sizes.get()));
    if (this.isConnected) client.connect();
    return member;
  }

  private followLead(): void {
    const { client } = this.members[0];
    this.progress.set(client.progress.get());
    this.sizes.set(client.sizes.get());
  }

  private part({ client, surface }: Member): void {
    client.close();
    this.pool.drop(surface.ids(""));
    surface.dispose();
  }
}

// For each that is wanted, the place of who takes it: who has the same, else who is at its place and
// not needed elsewhere, else nobody yet.
export function arrangement(have: readonly string[], wanted: readonly string[]): (number | null)[] {
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
