// A stream recorded from the C++ server (tests/golden/gyroid_stream.frames: Welcome, DatasetList, one step of five
// tiles with normals, StreamEnd; framed as over TCP), and what the C++ client decoded. Made by `generate gyroid --size
// 33 --noise 0.05 --seed 3`, isovalue 0.1, error 0.5 voxel, normals of 8 bits.

import { readFileSync } from "node:fs";
import { createRequire } from "node:module";
import type { DecoderModule } from "draco3d";

import { triangleHasher } from "../../../client/web/src/mesh/content_digest";
import { decodeTile } from "../../../client/web/src/mesh/tile_decoder";
import type { LatticeMesh, ManifestTile } from "../../../client/web/src/mesh/tile_mesh";
import {
  create,
  type DatasetInfo,
  decoded,
  type IsosurfaceRequest,
  IsosurfaceRequestSchema,
  type ServerKind,
  ThresholdMapSchema,
} from "../../../client/web/src/protocol/messages";

export const found = {
  triangles: 28268,
  vertices: 14639,
  eulerCharacteristic: -52,
  components: 2,
  borderEdges: 1114,
  digest: "e04fc58b948d3a09b01230d63ec9c5ae",
};

export function messages(): ServerKind[] {
  const bytes = readFileSync(new URL("../../golden/gyroid_stream.frames", import.meta.url));
  const all: ServerKind[] = [];
  for (let at = 0; at < bytes.length; ) {
    const length = bytes.readUInt32LE(at);
    all.push(decoded(new Uint8Array(bytes.subarray(at + 4, at + 4 + length))));
    at += 4 + length;
  }
  return all;
}

export function dataset(): DatasetInfo {
  const list = messages().find(({ case: kind }) => kind === "datasetList")!;
  return (list.value as { datasets: DatasetInfo[] }).datasets[0];
}

export function request(): IsosurfaceRequest {
  return create(IsosurfaceRequestSchema, {
    isovalue: 0.1,
    threshold: create(ThresholdMapSchema, { error: 0.5, unit: 1, regionCoordinates: 1, combine: 1 }),
    bound: 1,
    topologyRule: 1,
    lattice: 5,
    normals: 8,
  });
}

// Packages are installed next to the viewer, not above its tests.
const installed = createRequire(new URL("../../../client/web/package.json", import.meta.url));
const draco: Promise<DecoderModule> = installed("draco3d/draco_decoder_nodejs.js")({});
const hasher = triangleHasher(5);

// Throws TileError.
export async function tileFrom(payload: Uint8Array, promised: ManifestTile): Promise<LatticeMesh> {
  const decoding = { draco: await draco, hasher: await hasher, resolution: 5, hasNormals: true };
  return decodeTile(payload, promised, decoding);
}
