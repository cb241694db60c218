// Thumbnails of datasets: the first preview of each, drawn once and kept for the session. They use a connection of
// their own, one at a time, and only for visible list entries.
import * as THREE from "three";

import { Priority, type DatasetInfo } from "../protocol/messages";
import { sessionValues } from "../state/browser_storage";
import { defaults } from "../state/settings";
import { Conversation, type Effect } from "../stream/conversation";
import { shellModeOf } from "../stream/step_checks";
import { latticeToWorld, type Vec3 } from "../stream/dataset";
import { Link } from "../stream/link";
import { isosurfaceRequest } from "../stream/request";
import type { TilePool } from "../workers/tile_pool";
import type { DecodedTile } from "../workers/worker_messages";
import { gpuFinished } from "./gpu_fence";
import { surfaceMaterial } from "./surface_material";

const width = 128;
const height = 96;
const plenty = 5000; // The least number of triangles for a thumbnail; previews with fewer wait for the next step.

export class Thumbnails {
  private readonly queue: DatasetInfo[] = [];
  private current: DatasetInfo | null = null;
  private conversation: Conversation | null = null;
  private link: Link | null = null;
  private tiles = new Map<string, DecodedTile>();
  private resolutions = new Map<string, number>();
  private stream = 0;
  private readonly tried = new Set<DatasetInfo>();

  constructor(
    private readonly address: string,
    private readonly token: () => string,
    private readonly pool: TilePool,
    private readonly renderer: THREE.WebGLRenderer,
    private readonly up: (info: DatasetInfo) => Vec3, // The up axis of the picture.
    private readonly made: (name: string, picture: string) => void,
  ) {}

  request(info: DatasetInfo): void {
    const kept = sessionValues.get(keyOf(info, this.up(info)));
    if (kept) {
      this.made(info.name, kept);
    } else if (!this.queue.includes(info) && this.current !== info) {
      this.queue.push(info);
      this.requestNext();
    }
  }

  private requestNext(): void {
    if (this.current) return;
    this.current = this.queue.shift() ?? null;
    if (!this.current) {
      this.link?.close();
      this.link = this.conversation = null;
      return;
    }
    this.tiles.clear();
    this.resolutions.clear();
    if (this.conversation) this.perform(this.open());
    else this.connect();
  }

  private connect(): void {
    const conversation = new Conversation({
      part: "thumbnails",
      token: this.token,
      cachedTiles: () => [],
      priority: Priority.BACKGROUND,
      isListing: () => false,
    });
    this.conversation = conversation;
    this.perform(this.open()); // Sent when there is a connection.
    this.link = new Link(this.address, {
      opened: () => this.perform(conversation.opened()),
      received: (message) => this.perform(conversation.received(message)),
      closed: () => {
        // Thumbnails do not justify retries.
        this.link = this.conversation = null;
        this.current = null;
        this.queue.length = 0;
      },
      blocked: () => {},
    });
    this.link.connect();
  }

  private open(): Effect[] {
    const info = this.current!;
    const request = isosurfaceRequest(info, { ...defaults, error: 2, topologyTolerance: 8 }, null);
    return this.conversation!.request({ info, request });
  }

  private perform(effects: Effect[]): void {
    for (const effect of effects) {
      if (effect.kind === "send") this.link?.send(effect.message);
      if (effect.kind === "opened") this.stream = effect.stream;
      if (effect.kind === "stream" && effect.stream === this.stream) void this.follow(effect);
    }
  }

  private async follow({ effect, order }: Effect & { kind: "stream" }): Promise<void> {
    const { conversation, stream } = this;
    if (effect.kind === "decode") {
      const resolution = effect.begin.request!.lattice;
      const id = `thumbnail/${effect.tile.key}`;
      try {
        const tile = await this.pool.decode({
          kind: "decode",
          id,
          payload: effect.payload,
          expected: effect.tile,
          resolution,
          shell: shellModeOf(effect.begin),
          hasNormals: order.request.normals > 0,
          linear: latticeToWorld(order.info, resolution).slice(0, 9),
        }, this);
        this.pool.drop([id]);
        this.tiles.set(effect.tile.key, tile);
        this.resolutions.set(effect.tile.key, resolution);
        if (stream === this.stream) this.perform(conversation!.decoded(stream, effect.tile.key));
      } catch {
        // Damaged or superseded: try once more later.
        if (this.current === order.info && !this.tried.has(order.info)) this.queue.push(order.info);
        this.tried.add(order.info);
        if (this.current === order.info) this.finish(null);
      }
    } else if (effect.kind === "check") {
      const { begin, tiles } = effect.step;
      const triangles = tiles.reduce((n, tile) => n + tile.triangles, 0);
      if (triangles < plenty && !begin.isFinal) {
        // Too coarse to recognize; the next step's checks do not depend on this one.
        const sound = { ...nothing, triangles };
        this.perform(conversation!.checked(stream, effect.step, sound));
      } else {
        const picture = await this.drawn(order.info, tiles.map(({ key }) => key)).catch(() => null);
        if (stream === this.stream) this.finish(picture);
      }
    } else if (effect.kind === "ended" || effect.kind === "refused" || effect.kind === "failed") {
      this.finish(null);
    }
  }

  private finish(picture: string | null): void {
    const info = this.current;
    if (!info) return;
    ++this.stream;
    this.perform(this.conversation?.cancel() ?? []);
    if (picture) {
      sessionValues.set(keyOf(info, this.up(info)), picture);
      this.made(info.name, picture);
    }
    this.current = null;
    this.requestNext();
  }

  private async drawn(info: DatasetInfo, keys: string[]): Promise<string> {
    const scene = new THREE.Scene();
    const camera = new THREE.PerspectiveCamera(30, width / height, 0.1, 1000);
    camera.up.set(...this.up(info));
    const turn = new THREE.Quaternion().setFromUnitVectors(new THREE.Vector3(0, 0, 1), camera.up);
    const light = new THREE.DirectionalLight(0xffffff, 2.2);
    scene.add(new THREE.HemisphereLight(0xdfe8f5, 0x3a3530, 1.3), camera);
    camera.add(light, light.target);
    light.position.set(-0.6, 0.9, 1);
    light.target.position.set(0, 0, -1);
    const material = surfaceMaterial("#e0cdb4");
    const box = new THREE.Box3();
    for (const key of keys) {
      const tile = this.tiles.get(key);
      if (!tile) continue;
      const geometry = new THREE.BufferGeometry();
      geometry.setAttribute("position", new THREE.BufferAttribute(tile.positions, 3));
      geometry.setAttribute("normal", new THREE.BufferAttribute(tile.normals, 4, true));
      geometry.setIndex(new THREE.BufferAttribute(tile.triangles, 1));
      const mesh = new THREE.Mesh(geometry, material);
      const m = latticeToWorld(info, this.resolutions.get(key)!);
      mesh.matrixAutoUpdate = false;
      mesh.matrix.set(m[0], m[3], m[6], m[9], m[1], m[4], m[7], m[10], m[2], m[5], m[8], m[11], 0, 0, 0, 1);
      geometry.computeBoundingBox();
      box.union(geometry.boundingBox!.clone().applyMatrix4(mesh.matrix));
      scene.add(mesh);
    }
    const sphere = box.getBoundingSphere(new THREE.Sphere());
    const direction = new THREE.Vector3(0.55, -1, 0.32).normalize().applyQuaternion(turn);
    camera.position.copy(sphere.center).addScaledVector(direction, 3.4 * sphere.radius);
    camera.lookAt(sphere.center);
    camera.near = sphere.radius;
    camera.far = 6 * sphere.radius;
    camera.updateProjectionMatrix();
    const picture = await this.render(scene, camera);
    scene.traverse((object) => object instanceof THREE.Mesh && object.geometry.dispose());
    material.dispose();
    return picture;
  }

  // Queries of the GPU block the page until all earlier work is drawn, which may take seconds for a large surface. A
  // first picture needs some (extensions, shader compilation), so it waits until the GPU is idle and reads the pixels
  // asynchronously.
  private async render(scene: THREE.Scene, camera: THREE.Camera): Promise<string> {
    await idle(this.renderer);
    const target = new THREE.WebGLRenderTarget(width, height, { samples: 4, colorSpace: THREE.SRGBColorSpace });
    this.renderer.setRenderTarget(target);
    this.renderer.clear();
    this.renderer.render(scene, camera);
    this.renderer.setRenderTarget(null);
    const pixels = new Uint8Array(4 * width * height);
    await this.renderer.readRenderTargetPixelsAsync(target, 0, 0, width, height, pixels);
    target.dispose();
    const canvas = document.createElement("canvas");
    canvas.width = width;
    canvas.height = height;
    const context = canvas.getContext("2d")!;
    const image = context.createImageData(width, height);
    for (let y = 0; y < height; ++y) {
      const row = pixels.subarray(4 * width * (height - 1 - y), 4 * width * (height - y));
      image.data.set(row, 4 * width * y);
    }
    context.putImageData(image, 0, 0);
    return canvas.toDataURL("image/png");
  }
}

// Resolves when all frames are drawn and none has begun meanwhile.
async function idle(renderer: THREE.WebGLRenderer): Promise<void> {
  const { render } = renderer.info;
  for (let frame = -1; frame !== render.frame; ) {
    frame = render.frame;
    await gpuFinished(renderer);
  }
}

const nothing = {
  vertices: 0, edges: 0, triangles: 0, eulerCharacteristic: 0, components: 0,
  borderEdges: 0, openEdges: 0, nonmanifoldEdges: 0, degenerateTriangles: 0,
};

function keyOf(info: DatasetInfo, up: Vec3): string {
  return `thumbnail:${info.name}:${info.contentId}:${info.suggestedIsovalues[0] ?? ""}:${up}`;
}
