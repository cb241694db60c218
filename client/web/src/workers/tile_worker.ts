// Decodes tiles off the main thread. The geometry goes to the page for drawing, and a copy with the
// tile's rim straight to the mesh keeper, which checks whole steps.
import createDecoderModule from "draco3d/draco_decoder_nodejs.js";
import dracoWasm from "draco3d/draco_decoder.wasm?url";

import { type TriangleHasher, triangleHasher } from "../mesh/content_digest";
import { fieldNormals, normalSums, packedNormals } from "../mesh/normals";
import { decodeTile, TileDamage } from "../mesh/tile_decoder";
import { rimOf } from "../mesh/tile_rim";
import type { DecodedTile, KeptTile, TileJob } from "./worker_messages";

const draco = fetch(dracoWasm)
  .then((response) => response.arrayBuffer())
  .then((wasmBinary) => createDecoderModule({ wasmBinary }));
const hashers = new Map<number, Promise<TriangleHasher>>();
let keeper: MessagePort;

function hasherFor(resolution: number): Promise<TriangleHasher> {
  let hasher = hashers.get(resolution);
  if (!hasher) hashers.set(resolution, (hasher = triangleHasher(resolution)));
  return hasher;
}

async function decoded(job: TileJob): Promise<DecodedTile> {
  const mesh = decodeTile(job.payload, job.promised, {
    draco: await draco,
    hasher: await hasherFor(job.resolution),
    resolution: job.resolution,
    hasNormals: job.hasNormals,
  });
  const sums = mesh.normals ? null : normalSums(mesh);
  const normals = mesh.normals ? fieldNormals(mesh.normals, job.linear) : packedNormals(sums!);
  const isShort = mesh.positions.length / 3 <= 65536;
  const triangles = isShort ? Uint16Array.from(mesh.triangles) : mesh.triangles;
  // Lattice coordinates are below 2^24: exact as floats.
  const positions = Float32Array.from(mesh.positions);
  const kept: KeptTile = {
    kind: "tile",
    id: job.id,
    positions: positions.slice(),
    triangles: triangles.slice(),
    normals: normals.slice(),
    sums,
    rim: rimOf(mesh),
  };
  keeper.postMessage(kept, [
    kept.positions.buffer,
    kept.triangles.buffer,
    kept.normals.buffer,
    ...(sums ? [sums.buffer] : []),
  ]);
  return { kind: "decoded", id: job.id, positions, triangles, normals };
}

self.onmessage = async ({ data }: MessageEvent<TileJob | { kind: "keeper"; port: MessagePort }>) => {
  if (data.kind === "keeper") {
    keeper = data.port;
    return;
  }
  try {
    const tile = await decoded(data);
    self.postMessage(tile, {
      transfer: [tile.positions.buffer, tile.triangles.buffer, tile.normals.buffer],
    });
  } catch (error) {
    const text = error instanceof TileDamage ? error.message : `Decoding failed: ${error}`;
    self.postMessage({ kind: "damaged", id: data.id, text });
  }
};
