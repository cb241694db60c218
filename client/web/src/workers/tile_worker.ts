// Decodes tiles off the main thread. Sends the geometry to the page for drawing, and a copy with
// the tile's boundary to the mesh worker, which checks whole steps.
import type { DecoderModule } from "draco3d";
import dracoWasm from "draco3d/draco_decoder.wasm?url";
import createDecoderModule from "draco3d/draco_decoder_nodejs.js";

import shellWasm from "../../../../common/codec/wasm/shell_decoder.wasm?url";
import { type TriangleHasher, triangleHasher } from "../mesh/content_digest";
import { fieldNormals, normalSums, packedNormals, smoothedSums } from "../mesh/normals";
import { shellDecoder, smoothingRounds } from "../mesh/shell_decoder";
import { boundaryOf, type TileBoundary } from "../mesh/tile_boundary";
import { decodeTile } from "../mesh/tile_decoder";
import { TileError } from "../mesh/tile_error";
import type { LatticeMesh } from "../mesh/tile_mesh";
import type { DecodedTile, StoredTile, TileJob } from "./worker_messages";

const bytesOf = (url: string) => fetch(url).then((response) => response.arrayBuffer());
// Each needs a memory of its own, so it is made for the first tile that needs it.
const dracoDecoder = once(() => bytesOf(dracoWasm).then(dracoModule));
const shellBytes = bytesOf(shellWasm);
shellBytes.catch(() => {}); // Tiles that need them tell.
const decoderOfShells = once(() => shellBytes.then(shellDecoder));
const hashers = new Map<number, Promise<TriangleHasher>>();
let meshWorker: MessagePort;

// Rejects if there is no memory; Draco's own loader would never settle then.
function dracoModule(wasm: ArrayBuffer): Promise<DecoderModule> {
  return new Promise((resolve, reject) => {
    void createDecoderModule({
      instantiateWasm: (imports, receive) => {
        WebAssembly.instantiate(wasm, imports).then(({ instance }) => receive(instance), reject);
        return {};
      },
    }).then(resolve);
  });
}

function once<T>(make: () => T): () => T {
  let made: { value: T } | null = null;
  return () => (made ??= { value: make() }).value;
}

function hasherFor(resolution: number): Promise<TriangleHasher> {
  let hasher = hashers.get(resolution);
  if (!hasher) hashers.set(resolution, (hasher = triangleHasher(resolution)));
  return hasher;
}

async function meshOf({ payload, expected, resolution, shell, hasNormals }: TileJob): Promise<{ mesh: LatticeMesh; boundary: TileBoundary }> {
  if (shell) {
    const { mesh, box } = (await decoderOfShells())(payload, expected, shell, resolution);
    return { mesh, boundary: boundaryOf(mesh, box) };
  }
  const hasher = await hasherFor(resolution);
  const mesh = decodeTile(payload, expected, { draco: await dracoDecoder(), hasher, resolution, hasNormals });
  return { mesh, boundary: boundaryOf(mesh) };
}

function sumsOf(mesh: LatticeMesh, { shell, resolution }: TileJob): Float32Array {
  const sums = normalSums(mesh, 2 ** resolution);
  return shell ? smoothedSums(sums, mesh.triangles, smoothingRounds(shell)) : sums;
}

async function decoded(job: TileJob): Promise<DecodedTile> {
  const { mesh, boundary } = await meshOf(job);
  const sums = mesh.normals ? null : sumsOf(mesh, job);
  const normals = mesh.normals ? fieldNormals(mesh.normals, job.linear) : packedNormals(sums!);
  const isShort = mesh.positions.length / 3 <= 65536;
  const triangles = isShort ? Uint16Array.from(mesh.triangles) : mesh.triangles;
  // Lattice coordinates are below 2^24: exact as floats.
  const positions = Float32Array.from(mesh.positions);
  const kept: StoredTile = {
    kind: "tile",
    id: job.id,
    positions: positions.slice(),
    triangles: triangles.slice(),
    normals: normals.slice(),
    sums,
    boundary,
  };
  meshWorker.postMessage(kept, [kept.positions.buffer, kept.triangles.buffer, kept.normals.buffer, ...(sums ? [sums.buffer] : [])]);
  return { kind: "decoded", id: job.id, positions, triangles, normals };
}

function textOf(error: unknown): string {
  return error instanceof TileError ? error.message : `Decoding failed: ${error}`;
}

// Browsers report a memory that cannot be made in several ways, Draco's module as an abort.
function isOutOfMemory(error: unknown): boolean {
  return !(error instanceof TileError) && /memory/i.test(String(error));
}

self.onmessage = async ({ data }: MessageEvent<TileJob | { kind: "meshWorker"; port: MessagePort }>) => {
  if (data.kind === "meshWorker") {
    meshWorker = data.port;
    return;
  }
  try {
    const tile = await decoded(data);
    self.postMessage(tile, {
      transfer: [tile.positions.buffer, tile.triangles.buffer, tile.normals.buffer],
    });
  } catch (error) {
    self.postMessage(isOutOfMemory(error) ? { kind: "noMemory" } : { kind: "damaged", id: data.id, text: textOf(error) });
  }
};
