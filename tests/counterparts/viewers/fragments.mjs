// Reads a multi-resolution mesh with neuroglancer's own code, in Node: its manifests, ranges, shards and Draco. All
// fragments of all levels must exist, fit together and stay in their octants, and the finest level must equal the
// leaves of the 3D Tiles tree.
//
//   node fragments.mjs URL-OF-MESH SEGMENT [URL-OF-TILESET]
import assert from "node:assert/strict";
import { readFile } from "node:fs/promises";

import { leavesOf } from "./trees.mjs";

// Globals of a browser's worker that neuroglancer expects.
globalThis.self ??= globalThis;
globalThis.navigator ??= { userAgent: "Node" };
const { fetch } = globalThis;
globalThis.fetch = async (address, options) => {
  if (!String(address).startsWith("file:")) return fetch(address, options);
  return new Response(await readFile(new URL(address)), { headers: { "Content-Type": "application/wasm" } });
};
const { PrecomputedMultiscaleMeshSource } = await import("neuroglancer/unstable/datasource/precomputed/backend.js");
const { ShardedKvStore } = await import("neuroglancer/unstable/datasource/precomputed/sharded.js");
const { ShardingHashFunction, DataEncoding } = await import("neuroglancer/unstable/datasource/precomputed/base.js");
const { ReadableHttpKvStore } = await import("neuroglancer/unstable/kvstore/http/common.js");
const { VertexPositionFormat } = await import("neuroglancer/unstable/mesh/base.js");

const [address, segment, tileset] = process.argv.slice(2);
const mesh = address.replace(/\/?$/, "/");
const info = await (await globalThis.fetch(`${mesh}info`)).json();
assert.equal(info["@type"], "neuroglancer_multilod_draco");
assert.deepEqual(info.transform?.length, 12);

// Parsed as neuroglancer's front end does from the file "info".
const kvStore = { store: new ReadableHttpKvStore(null, mesh), path: "" };
const nothing = () => {};
const queueManager = {
  sources: new Set(),
  adjustCapacitiesForChunk: nothing,
  markRecentlyUsed: nothing,
  scheduleUpdate: nothing,
  updateChunkState: nothing,
};
const chunkManager = { queueManager, addRef: () => chunkManager, dispose: nothing };
const sharding = info.sharding && {
  hash: ShardingHashFunction[info.sharding.hash.toUpperCase()],
  preshiftBits: info.sharding.preshift_bits,
  minishardBits: info.sharding.minishard_bits,
  shardBits: info.sharding.shard_bits,
  minishardIndexEncoding: DataEncoding[info.sharding.minishard_index_encoding.toUpperCase()],
  dataEncoding: DataEncoding[info.sharding.data_encoding.toUpperCase()],
};
const source = {
  kvStore,
  shardedKvStore: sharding && new ShardedKvStore(chunkManager, kvStore, sharding),
  parameters: {
    metadata: {
      vertexQuantizationBits: info.vertex_quantization_bits,
      lodScaleMultiplier: info.lod_scale_multiplier,
    },
  },
  format: { vertexPositionFormat: VertexPositionFormat.uint16 },
};
assert.equal(info.vertex_quantization_bits, 16);
const { download, downloadFragment } = PrecomputedMultiscaleMeshSource.prototype;

const manifestChunk = { source, objectId: BigInt(segment) };
await download.call(source, manifestChunk, new AbortController().signal);
const { octree, lodScales, chunkShape } = manifestChunk.manifest;
const { offsets } = manifestChunk;
assert(lodScales.every((scale, level) => level === 0 || scale > lodScales[level - 1]), "coarser levels err more");
assert(chunkShape.every((side) => side > 0));

// The level of an octree row is its height along first children.
function levelOf(row) {
  const [first, end] = [octree[5 * row + 3], octree[5 * row + 4] & 0x7fffffff];
  return end > first ? 1 + levelOf(first) : 0;
}

const levels = lodScales.length;
const found = Array.from({ length: levels }, () => ({ triangles: 0, vertices: new Set(), edges: new Map() }));
let outside = 0;
for (let row = 0; row < octree.length / 5; ++row) {
  if (offsets[row] === offsets[row + 1]) continue;
  const lod = levelOf(row);
  const cell = octree.subarray(5 * row, 5 * row + 3);
  const chunk = { manifestChunk, chunkIndex: row, lod };
  await downloadFragment.call(source, chunk, new AbortController().signal);
  const { meshData, subChunkOffsets } = chunk;
  const { vertexPositions, indices } = meshData;
  assert.equal(meshData.strips, false);
  const level = found[lod];
  const name = (vertex) => [0, 1, 2].map((axis) => vertexPositions[3 * vertex + axis] + 65535 * cell[axis]).join();
  for (let at = 0; at < indices.length; at += 3) {
    const corners = [0, 1, 2].map((corner) => name(indices[at + corner]));
    assert.equal(new Set(corners).size, 3, "no degenerate triangle");
    level.triangles += 1;
    corners.forEach((a, corner) => {
      const b = corners[(corner + 1) % 3];
      level.vertices.add(a);
      const edge = a < b ? `${a} ${b}` : `${b} ${a}`;
      level.edges.set(edge, (level.edges.get(edge) ?? 0) + 1);
    });
  }
  if (lod === 0) continue;
  for (let octant = 0; octant < 8; ++octant) {
    for (let at = subChunkOffsets[octant]; at < subChunkOffsets[octant + 1]; ++at) {
      for (let axis = 0; axis < 3; ++axis) {
        const position = vertexPositions[3 * indices[at] + axis];
        if ((octant >> axis) & 1 ? position < 32767 : position > 32768) outside += 1;
      }
    }
  }
}

// The first level of a tree is a preview of about every eighth sample and ends at the last of these.
function isWhereDataEnds(edge, lod) {
  const [a, b] = edge.split(" ").map((end) => end.split(",").map(Number));
  return lod === levels - 1 && a.some((place, axis) => place === b[axis] && Math.abs(place - 32767.5) > 1);
}

assert.equal(outside, 0, "triangles lie in their octants");
for (const [lod, { triangles, vertices, edges }] of found.entries()) {
  const open = [...edges].filter(([edge, count]) => count === 1 && !isWhereDataEnds(edge, lod)).length;
  const euler = vertices.size - edges.size + triangles;
  console.log(`level ${lod}: ${triangles} triangles, Euler characteristic ${euler}, ${open} open edges`);
  assert(triangles > 0);
  assert.equal(open, 0, `level ${lod}: without a crack`);
}
if (tileset) {
  const leaves = await leavesOf(tileset);
  assert.equal(found[0].triangles, leaves.triangles, "the finest level is the leaves of the tree");
}
