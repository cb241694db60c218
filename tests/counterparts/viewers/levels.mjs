// Checks a GLB with levels of detail (MSFT_lod) with the Khronos validator and three.js: it contains all levels and
// shows the finest one.
//
//   node levels.mjs FILE TRIANGLES-OF-ALL-LEVELS
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";

import validator from "gltf-validator";
import { GLTFLoader } from "three/addons/loaders/GLTFLoader.js";

const [path, triangles] = process.argv.slice(2);
const bytes = new Uint8Array(readFileSync(path));
const report = await validator.validateBytes(bytes);
assert.deepEqual(
  report.issues.messages.filter(({ severity }) => severity <= 1),
  [],
  "neither error nor warning",
);
assert.deepEqual(report.info.extensionsUsed, ["MSFT_lod"]);

const { parser, scene } = await new GLTFLoader().parseAsync(bytes.buffer, "");
const counts = await Promise.all(
  parser.json.nodes.map(async (_, index) => (await parser.getDependency("node", index)).geometry.index.count / 3),
);
assert.equal(counts.reduce((sum, count) => sum + count), Number(triangles));
assert(counts.length > 1 && counts.every((count, level) => level === 0 || count < counts[level - 1]), "coarser and coarser");
assert.equal(scene.children.length, 1);
assert.equal(scene.children[0].geometry.index.count / 3, counts[0], "the finest level is shown");
console.log(`levels of ${counts.join(", ")} triangles`);
