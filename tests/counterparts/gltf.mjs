// Checks a GLB with the Khronos validator and three.js.
//
//   node gltf.mjs FILE TRIANGLES
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { pathToFileURL } from "node:url";

const installed = createRequire(new URL("../../client/web/package.json", import.meta.url));
const [path, triangles] = process.argv.slice(2);
const bytes = new Uint8Array(readFileSync(path));

const report = await installed("gltf-validator").validateBytes(bytes);
assert.deepEqual(
  report.issues.messages.filter((message) => message.severity <= 1),
  [],
  "neither error nor warning",
);
assert.equal(report.info.totalTriangleCount, Number(triangles));

const { GLTFLoader } = await import(pathToFileURL(installed.resolve("three/addons/loaders/GLTFLoader.js")));
const { MeshoptDecoder } = await import(pathToFileURL(installed.resolve("three/addons/libs/meshopt_decoder.module.js")));
const scene = await new GLTFLoader().setMeshoptDecoder(MeshoptDecoder).parseAsync(bytes.buffer, "");
let loaded = 0;
scene.scene.traverse((object) => {
  if (!object.isMesh) return;
  loaded += object.geometry.index.count / 3;
  object.geometry.computeBoundingSphere();
  assert(object.geometry.boundingSphere.radius > 0);
});
assert.equal(loaded, Number(triangles));
