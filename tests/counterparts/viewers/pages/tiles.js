// Shows a tileset in 3d-tiles-renderer. A header field of every request has the token.
import { TilesRenderer } from "3d-tiles-renderer";
import { GLTFExtensionsPlugin } from "3d-tiles-renderer/plugins";
import {
  DirectionalLight,
  HemisphereLight,
  PerspectiveCamera,
  Scene,
  Sphere,
  Vector3,
  WebGLRenderer,
} from "three";
import { DRACOLoader } from "three/examples/jsm/loaders/DRACOLoader.js";

const renderer = new WebGLRenderer({ antialias: true });
renderer.setSize(innerWidth, innerHeight);
renderer.setClearColor(0x223344);
document.body.append(renderer.domElement);
const camera = new PerspectiveCamera(50, innerWidth / innerHeight);
camera.up.set(0, 0, 1);
const sun = new DirectionalLight(0xffffff, 2);
sun.position.set(1, -2, 2);
const scene = new Scene().add(new HemisphereLight(0xffffff, 0x444444, 2), sun);

const failed = [];
let tiles = null;
let frames = 0; // Since the camera moved.

function draw() {
  tiles.update();
  renderer.render(scene, camera);
  frames += 1;
  requestAnimationFrame(draw);
}

// The surfaces of the visible tiles.
function shown() {
  const surfaces = [];
  tiles.forEachLoadedModel((model, tile) => {
    if (tiles.visibleTiles.has(tile)) surfaces.push({ model, name: tile.content.uri });
  });
  return surfaces;
}

function triangles(model) {
  let sum = 0;
  model.traverse((object) => {
    if (object.isMesh) sum += object.geometry.index.count / 3;
  });
  return sum;
}

window.counterpart = {
  async open(address, token) {
    tiles = new TilesRenderer(address);
    tiles.fetchOptions.headers = { Authorization: `Bearer ${token}` };
    tiles.registerPlugin(new GLTFExtensionsPlugin({ dracoLoader: new DRACOLoader().setDecoderPath("draco/") }));
    tiles.setCamera(camera);
    tiles.setResolutionFromRenderer(camera, renderer);
    tiles.addEventListener("load-error", ({ url, error }) => failed.push(`${url}: ${error}`));
    const first = new Promise((resolve) => tiles.addEventListener("load-tileset", resolve, { once: true }));
    scene.add(tiles.group);
    draw();
    await first;
  },
  // Looks at the middle from `radii` radii of the whole away. `error` is the allowed screen-space error in pixels.
  look(radii, error) {
    const whole = new Sphere();
    tiles.getBoundingSphere(whole);
    const { center, radius } = whole;
    camera.position.copy(new Vector3(0.5, -1, 0.3).setLength(radii * radius).add(center));
    camera.near = radius / 1000;
    camera.far = 100 * radius;
    camera.lookAt(center);
    camera.updateProjectionMatrix();
    camera.updateMatrixWorld();
    tiles.errorTarget = error;
    frames = 0;
  },
  isBusy() {
    const { queued = 0, downloading, parsing } = tiles.stats;
    return frames < 5 || queued + downloading + parsing > 0 || shown().length === 0;
  },
  facts: () => ({
    failed,
    tiles: shown().length,
    triangles: shown().reduce((sum, { model }) => sum + triangles(model), 0),
  }),
};
