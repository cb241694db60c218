// What lies over the scene and is moved or clicked there: axes and box, handles, picked places and names of labels.
import type * as THREE from "three";
import type { DatasetInfo } from "../protocol/messages";
import type { SampleViews } from "../samples/sample_views";
import type { Annotations } from "../scene/annotations";
import { clipPlanes } from "../scene/crop";
import { Gestures } from "../scene/gestures";
import { Handles } from "../scene/handles";
import { LabelHover } from "../scene/label_hover";
import { Measuring } from "../scene/measuring";
import { Orientation } from "../scene/orientation";
import { type Picked, Picking } from "../scene/picking";
import { SceneDecorations } from "../scene/scene_decorations";
import type { Stage } from "../scene/stage";
import { nameOfLabel } from "../state/series";
import type { Settings } from "../state/settings";
import { coordinateResolution, type Vec3 } from "../stream/dataset";
import type { DatasetQueries } from "../stream/dataset_queries";
import type { SurfaceSet } from "../surfaces/surface_set";
import type { TilePool } from "../workers/tile_pool";
import { withoutPart } from "./surface_parts";

export interface OverlaidView {
  element: HTMLElement;
  canvas: HTMLCanvasElement;
  stage: Stage;
  pool: TilePool;
  surfaces: SurfaceSet;
  queries: DatasetQueries;
  samples: SampleViews;
  info: () => DatasetInfo | null;
  settings: () => Settings;
  set: (changes: Partial<Settings>, isDragging: boolean) => void;
  lookFrom: (direction: THREE.Vector3) => void;
  turnUp: (up: Vec3) => void;
  refused: (text: string) => void;
  picked: (place: Picked) => void;
}

export class Overlays {
  readonly handles: Handles;
  readonly measuring: Measuring;
  private readonly decorations: SceneDecorations;
  private readonly orientation: Orientation;
  private readonly gestures: Gestures;
  private readonly labelHover: LabelHover;

  constructor(private readonly view: OverlaidView) {
    const { element, canvas, stage, pool, surfaces, queries, samples, info, settings, set } = view;
    this.decorations = new SceneDecorations(stage);
    this.orientation = new Orientation(stage, view.lookFrom, view.turnUp);
    this.handles = new Handles(stage, canvas, set);
    this.gestures = new Gestures(element, canvas, stage.controls, () => this.handles.isGrabbed);
    this.measuring = new Measuring(
      stage,
      pool,
      (of, world) => queries.probe(of.name, world),
      (places) => set({ places }, false),
      () => canvas.focus(),
      (surface, place, of) => this.hidePart(surface, place, of),
      (label) => nameOfLabel(label, settings()),
    );
    const pickable = () => ({
      info: samples.sampled,
      tiles: surfaces.shownTiles(settings()),
      clip: clipPlanes(settings(), info()),
      slice: (ray: THREE.Ray) => samples.hit(ray),
    });
    const picking = new Picking(stage, canvas, pool, pickable, () => this.handles.isGrabbed, view.picked);
    this.labelHover = new LabelHover(
      canvas,
      () => surfaces.hasLabels && !this.handles.isGrabbed,
      (x, y) => picking.find(x, y),
      (label) => nameOfLabel(label, settings()),
    );
  }

  // In their order over the scene, with the bar of times.
  elements(timeBar: HTMLElement): HTMLElement[] {
    const { decorations, orientation, measuring, labelHover, gestures } = this;
    const { legends, mark } = this.view.samples;
    const below = [decorations.numbers, decorations.scaleBar, orientation.element, legends, timeBar];
    return [...below, measuring.labels, mark, measuring.element, labelHover.element, gestures.hint];
  }

  setDataset(info: DatasetInfo): void {
    this.decorations.setDataset(info);
    this.orientation.setDataset(info);
    this.orientation.show(this.view.settings().axes);
  }

  show({ axes, gestures, places }: Settings, info: DatasetInfo | null): void {
    this.decorations.show(axes);
    this.orientation.show(axes);
    this.gestures.setCooperative(gestures === "cooperative" || (gestures === "auto" && window.parent !== window));
    this.measuring.show(info, places);
  }

  // What pictures show of it.
  get annotations(): { scene: Pick<Annotations, "scale" | "numbers" | "axes" | "points">; words: string[] } {
    const { scale, visibleNumbers: numbers } = this.decorations;
    const { points, words } = this.measuring.measurement;
    return { scene: { scale, numbers, axes: this.orientation.arms, points }, words };
  }

  private hidePart(surface: number, place: Vec3, info: DatasetInfo): void {
    const parts = withoutPart(this.view.settings(), surface, place, coordinateResolution(info));
    if ("refusal" in parts) this.view.refused(parts.refusal);
    else this.view.set(parts.change, false);
  }
}
