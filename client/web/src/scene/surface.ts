// The shown surface, tile by tile, and tiles that may be shown next.
//
// Buffers of tiles are uploaded to the GPU in small parts while the previous step is still drawn. show() then only
// selects the tiles: the old surface is replaced by the new one between two frames, without a hole, and common tiles
// stay.
import * as THREE from "three";

import type { LatticeBox } from "../mesh/tile_mesh";
import { type Coloring, defaults, type Settings, type SurfaceSettings } from "../state/settings";
import type { Affine } from "../stream/dataset";
import type { DecodedTile, Selection } from "../workers/worker_messages";
import { affineMatrix } from "./affine_matrix";
import { areSamePlanes } from "./cut_plane";
import type { FieldColors } from "./field_colors";
import { layers } from "./layers";
import type { Programs } from "./programs";
import { setFinish, surfaceMaterial } from "./surface_material";

interface SurfaceTile {
  mesh: THREE.Mesh;
  triangles: number;
  lastUse: number;
  isUploaded: boolean;
  stepNumber: number;
}

const bytesPerFrame = 3_000_000; // Uploaded per frame, so that the page stays responsive.
const palette = ["#d8b48f", "#7fb3d5", "#8fc9a3", "#e3a6a1", "#b7a3d9", "#e6cf7c", "#79c7c5", "#d99bc4", "#a9bf6f", "#c7a17a", "#8fa8d8", "#d6d0c4"];
const stepPalette = ["#c75146", "#dd8a4a", "#e3c567", "#a7c17a", "#5ea58b", "#4d87b0", "#7b6fb3"];

// The settings that determine a surface's look.
export type SurfaceLook = Pick<Settings, "wireframe" | "shading" | "colorBy"> &
  Pick<SurfaceSettings, "color" | "opacity" | "visible" | "material"> & { coloring: Coloring };

export class Surface {
  drawable = defaults.drawableTriangles; // Triangles that may be drawn of it.
  budget = defaults.drawableTriangles; // Triangles kept of it, including the shown ones.
  private readonly tiles = new Map<string, SurfaceTile>();
  private readonly tilesByUser = new Map<object, Set<string>>(); // Ids in use by each user; a tile stays while it is in use.
  private readonly earlyScalars = new Map<string, Float32Array>(); // Scalars of tiles that have not arrived.
  private isDisposed = false;
  private readonly uploads: string[] = [];
  private shown: string[] = [];
  private selection: Selection | null = null; // The shown triangles.
  private useCounter = 0;
  private waiting: { ids: string[]; resolve: () => void }[] = [];
  private readonly materials = new Map<string, THREE.MeshStandardMaterial>();
  private readonly wireframeMaterial = new THREE.MeshBasicMaterial({
    color: 0x000000,
    wireframe: true,
    transparent: true,
    opacity: 0.24,
    depthWrite: false,
  });
  private look: SurfaceLook = {
    coloring: "plain",
    wireframe: false,
    shading: "field",
    color: "#e0cdb4",
    opacity: 1,
    visible: true,
    colorBy: "",
    material: "neutral",
  };
  private clip: THREE.Plane[] = [];

  constructor(
    private readonly scene: THREE.Scene,
    private readonly invalidate: () => void,
    private readonly wake: () => void, // Schedules a frame that need not redraw.
    private readonly onDropped: (ids: string[]) => void,
    private readonly field: FieldColors,
    private readonly programs: Programs,
  ) {}

  add(tile: DecodedTile, toWorld: Affine, stepNumber: number): void {
    if (this.isDisposed) return this.onDropped([tile.id]);
    if (this.tiles.has(tile.id)) return;
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(tile.positions, 3));
    geometry.setAttribute("normal", new THREE.BufferAttribute(tile.normals, 4, true));
    geometry.setIndex(new THREE.BufferAttribute(tile.triangles, 1));
    geometry.computeBoundingSphere();
    geometry.setDrawRange(0, 0);
    const mesh = new THREE.Mesh(geometry);
    mesh.matrixAutoUpdate = false;
    mesh.matrix.copy(affineMatrix(toWorld));
    mesh.frustumCulled = false; // Until it is uploaded.
    mesh.userData.triangles = tile.triangles.length / 3;
    const added: SurfaceTile = {
      mesh,
      triangles: tile.triangles.length / 3,
      lastUse: ++this.useCounter,
      isUploaded: false,
      stepNumber,
    };
    this.setMaterial(tile.id, added);
    this.tiles.set(tile.id, added);
    const scalars = this.earlyScalars.get(tile.id);
    this.earlyScalars.delete(tile.id);
    if (scalars) this.setScalars(tile.id, scalars);
    this.uploads.push(tile.id);
    this.wake();
  }

  // Returns the ids of cached tiles, the largest first.
  ids(prefix: string): string[] {
    return [...this.tiles.entries()]
      .filter(([id]) => id.startsWith(prefix))
      .sort(([, a], [, b]) => b.triangles - a.triangles)
      .map(([id]) => id);
  }

  hasAll(ids: readonly string[]): boolean {
    return ids.every((id) => this.tiles.has(id));
  }

  trianglesOf(ids: readonly string[]): number {
    return ids.reduce((sum, id) => sum + (this.tiles.get(id)?.triangles ?? 0), 0);
  }

  // Returns the box of the shown surface; if components are hidden, that of the largest visible one.
  worldBox(): THREE.Box3 {
    const box = new THREE.Box3();
    if (this.selection) {
      const { largest } = this.selection;
      const first = this.tiles.get(this.shown[0]);
      return largest && first ? boxOf(largest).applyMatrix4(first.mesh.matrix) : box;
    }
    for (const id of this.shown) {
      const { mesh } = this.tiles.get(id)!;
      mesh.geometry.boundingBox ?? mesh.geometry.computeBoundingBox();
      box.union(mesh.geometry.boundingBox!.clone().applyMatrix4(mesh.matrix));
    }
    return box;
  }

  // Called once per frame before drawing; returns true if something was done or is left.
  uploadSome(): boolean {
    if (!this.isDrawable()) return false; // A frame follows when it is drawable.
    let bytes = 0;
    const uploaded: string[] = [];
    while (this.uploads.length > 0 && bytes < bytesPerFrame) {
      const id = this.uploads.shift()!;
      const tile = this.tiles.get(id);
      if (!tile) continue;
      this.scene.add(tile.mesh);
      bytes += 30 * tile.triangles;
      uploaded.push(id);
    }
    if (uploaded.length > 0) setTimeout(() => this.finishUpload(uploaded));
    return uploaded.length > 0 || this.uploads.length > 0;
  }

  // Compiles programs before there are tiles.
  private isDrawable(): boolean {
    const kind = `surface ${this.isTranslucent} ${this.look.colorBy !== ""} ${this.look.shading === "facets"}`;
    return this.programs.areReady(kind, () => new THREE.Mesh(new THREE.BufferGeometry(), this.newMaterial(this.look.color)));
  }

  // Resolves when all of them are on the GPU.
  uploaded(ids: string[]): Promise<void> {
    return new Promise((resolve) => {
      this.waiting.push({ ids, resolve });
      this.resolveWaiting();
      this.wake();
    });
  }

  // Draws exactly these tiles from the next frame on, or their selected components. Requires that they are uploaded.
  show(ids: readonly string[], selection: Selection | null = null): void {
    const parted = new Map(selection?.parted.map((one) => [one.id, one]));
    const next = new Set(ids);
    for (const id of this.shown) {
      if (!next.has(id)) this.setVisible(id, false);
    }
    for (const id of ids) {
      this.setDrawnTriangles(id, parted.get(id) ?? null);
      this.setVisible(id, true);
    }
    this.shown = [...ids];
    this.selection = selection;
    this.invalidate();
  }

  // Updates normals at vertices shared with a changed neighbor.
  setNormals(id: string, normals: Int16Array): void {
    const attribute = this.tiles.get(id)?.mesh.geometry.getAttribute("normal");
    if (!(attribute instanceof THREE.BufferAttribute)) return;
    attribute.array = normals;
    attribute.needsUpdate = true;
  }

  // Sets the values of a second field, from scalarAttribute(). They may arrive before their tile.
  setScalars(id: string, scalars: Float32Array): void {
    const tile = this.tiles.get(id);
    if (tile) tile.mesh.geometry.setAttribute("scalar", new THREE.BufferAttribute(scalars, 1));
    else this.earlyScalars.set(id, scalars);
  }

  // Evicts the least recently used tiles beyond the budget, except tiles shown or in use.
  dropUnused(): void {
    let triangles = [...this.tiles.values()].reduce((n, tile) => n + tile.triangles, 0);
    if (triangles <= this.budget) return;
    const inUse = new Set([this.shown, ...this.tilesByUser.values()].flatMap((ids) => [...ids]));
    const unused = [...this.tiles.entries()].filter(([id]) => !inUse.has(id)).sort(([, a], [, b]) => a.lastUse - b.lastUse);
    const dropped: string[] = [];
    for (const [id, tile] of unused) {
      if (triangles <= this.budget) break;
      triangles -= tile.triangles;
      this.remove(id, tile);
      dropped.push(id);
    }
    if (dropped.length > 0) this.onDropped(dropped);
  }

  // Keeps the tiles until release(user).
  use(ids: readonly string[], user: object): void {
    const used = this.tilesByUser.get(user) ?? new Set();
    this.tilesByUser.set(user, used);
    for (const id of ids) {
      used.add(id);
      const tile = this.tiles.get(id);
      if (tile) tile.lastUse = ++this.useCounter;
    }
  }

  release(user: object): void {
    this.tilesByUser.delete(user);
    if (this.tilesByUser.size === 0) this.earlyScalars.clear(); // Their tiles are no longer needed.
  }

  // Whether the surface is visible and translucent.
  get isTranslucent(): boolean {
    return this.look.visible && this.look.opacity < 1;
  }

  applyLook(look: SurfaceLook, clip: readonly THREE.Plane[]): void {
    const { isTranslucent: wasTranslucent, look: before } = this;
    if (isSameLook(look, before) && areSamePlanes(clip, this.clip)) return;
    this.look = look;
    this.clip = [...clip];
    if (wasTranslucent !== this.isTranslucent || before.colorBy !== look.colorBy) this.forgetMaterials();
    if (before.color !== look.color) this.recolor(before.color);
    for (const material of this.materials.values()) this.refresh(material);
    this.wireframeMaterial.clippingPlanes = this.clip;
    const shown = new Set(this.shown);
    for (const [id, tile] of this.tiles) {
      this.setMaterial(id, tile);
      if (tile.isUploaded) tile.mesh.visible = look.visible && shown.has(id);
      this.setLines(tile);
    }
    this.invalidate();
  }

  // Frees all GPU memory, without events.
  dispose(): void {
    this.isDisposed = true;
    for (const [id, tile] of [...this.tiles]) this.remove(id, tile);
    this.shown = [];
    this.forgetMaterials();
    this.wireframeMaterial.dispose();
    this.resolveWaiting();
    this.invalidate();
  }

  private finishUpload(ids: string[]): void {
    for (const id of ids) {
      const tile = this.tiles.get(id);
      if (!tile || tile.isUploaded) continue;
      tile.isUploaded = true;
      this.setLayer(tile);
      tile.mesh.visible = false;
      tile.mesh.frustumCulled = true;
      tile.mesh.geometry.setDrawRange(0, Infinity);
    }
    this.resolveWaiting();
  }

  private resolveWaiting(): void {
    this.waiting = this.waiting.filter(({ ids, resolve }) => {
      if (!ids.every((id) => this.tiles.get(id)?.isUploaded ?? true)) return true;
      resolve();
      return false;
    });
  }

  private setVisible(id: string, isVisible: boolean): void {
    const tile = this.tiles.get(id);
    if (!tile) return;
    tile.mesh.visible = isVisible && this.look.visible;
    tile.lastUse = ++this.useCounter;
    if (isVisible) this.setLines(tile);
  }

  // Replaces the index buffer by a permutation with the drawn triangles first, and sets their number.
  private setDrawnTriangles(id: string, part: Selection["parted"][number] | null): void {
    const geometry = this.tiles.get(id)?.mesh.geometry;
    if (!geometry) return;
    geometry.setDrawRange(0, part ? 3 * part.shown : Infinity);
    const index = geometry.getIndex()!;
    if (!part || index.array === part.triangles) return;
    index.array = part.triangles;
    index.needsUpdate = true;
  }

  private setLines(tile: SurfaceTile): void {
    const child = tile.mesh.children[0];
    if (child) child.visible = this.look.wireframe;
    if (child || !this.look.wireframe || !tile.mesh.visible) return;
    const lines = new THREE.Mesh(tile.mesh.geometry, this.wireframeMaterial);
    lines.matrixAutoUpdate = false;
    lines.layers.set(layers.marks);
    tile.mesh.add(lines);
  }

  private remove(id: string, tile: SurfaceTile): void {
    tile.mesh.removeFromParent();
    tile.mesh.geometry.dispose();
    this.tiles.delete(id);
  }

  private setMaterial(id: string, tile: SurfaceTile): void {
    tile.mesh.material = this.material(id, tile.stepNumber);
    this.setLayer(tile);
  }

  private setLayer({ mesh, isUploaded }: SurfaceTile): void {
    mesh.layers.set(!isUploaded ? layers.upload : this.isTranslucent ? layers.translucent : layers.solid);
  }

  private material(id: string, stepNumber: number): THREE.MeshStandardMaterial {
    let { color } = this.look;
    if (this.look.coloring === "tiles") color = palette[parseInt(id.slice(-6), 16) % palette.length];
    if (this.look.coloring === "steps") color = stepPalette[stepNumber % stepPalette.length];
    let material = this.materials.get(color);
    if (!material) this.materials.set(color, (material = this.newMaterial(color)));
    return material;
  }

  private newMaterial(color: string): THREE.MeshStandardMaterial {
    const material = surfaceMaterial(color, this.isTranslucent, this.look.colorBy === "" ? null : this.field);
    this.refresh(material);
    return material;
  }

  // Reuses the material while the user changes the color.
  private recolor(before: string): void {
    const material = this.materials.get(before);
    if (!material || palette.includes(before) || stepPalette.includes(before)) return;
    this.materials.delete(before);
    if (this.materials.has(this.look.color)) return material.dispose();
    material.color.set(this.look.color);
    this.materials.set(this.look.color, material);
  }

  private forgetMaterials(): void {
    for (const material of this.materials.values()) material.dispose();
    this.materials.clear();
  }

  private refresh(material: THREE.MeshStandardMaterial): void {
    material.clippingPlanes = this.clip;
    setFinish(material, this.look.material);
    if (this.isTranslucent) material.opacity = this.look.opacity;
    const isFlat = this.look.shading === "facets";
    if (material.flatShading === isFlat) return;
    material.flatShading = isFlat;
    material.needsUpdate = true;
  }
}

const looks = ["coloring", "wireframe", "shading", "color", "opacity", "visible", "colorBy", "material"] as const;

function isSameLook(one: SurfaceLook, other: SurfaceLook): boolean {
  return looks.every((key) => one[key] === other[key]);
}

function boxOf([x0, y0, z0, x1, y1, z1]: LatticeBox): THREE.Box3 {
  return new THREE.Box3(new THREE.Vector3(x0, y0, z0), new THREE.Vector3(x1, y1, z1));
}
