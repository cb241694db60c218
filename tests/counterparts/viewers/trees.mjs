// Reads a whole tree of 3D Tiles as plain JSON.
import assert from "node:assert/strict";

import validator from "gltf-validator";

async function fetched(address, token) {
  const answer = await fetch(address, { headers: token ? { Authorization: `Bearer ${token}` } : {} });
  assert.equal(answer.status, 200, `${address}: ${answer.status}`);
  return answer;
}

// The number of leaf surfaces and of their triangles. Validates the first surface and a leaf's as glTF.
export async function leavesOf(address, token = "") {
  const leaves = { tiles: 0, triangles: 0 };
  let validated = 0;
  async function visit(tileset, parentError) {
    const { root } = await (await fetched(tileset, token)).json();
    assert(root.geometricError < parentError, `${tileset}: finer than what leads to it`);
    const children = root.children ?? [];
    const isLeaf = children.length === 0;
    if (root.content && (isLeaf || validated === 0)) {
      const bytes = new Uint8Array(await (await fetched(new URL(root.content.uri, tileset), token)).arrayBuffer());
      const length = new DataView(bytes.buffer).getUint32(12, true);
      const gltf = JSON.parse(new TextDecoder().decode(bytes.subarray(20, 20 + length)));
      if (isLeaf) {
        leaves.tiles += 1;
        leaves.triangles += gltf.accessors[gltf.meshes[0].primitives[0].indices].count / 3;
      }
      if (validated < 2) {
        const report = await validator.validateBytes(bytes);
        const said = report.issues.messages.filter(({ severity }) => severity <= 1);
        assert.deepEqual(said, [], `${tileset}: neither error nor warning`);
        validated += 1;
      }
    }
    for (const { content } of children) await visit(new URL(content.uri, tileset), root.geometricError);
  }
  await visit(new URL(address), Infinity);
  return leaves;
}
