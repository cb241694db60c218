// Decodes a tile's Draco bytes into a mesh on the lattice, or throws TileError.
//
// The bytes are not trusted: counts are compared with the manifest before Draco allocates memory, then vertices with
// the tile's cube, and the triangles with their digest.
import type { Decoder, DecoderModule } from "draco3d";

import { hex, type TriangleHasher } from "./content_digest";
import { PointNumbers } from "./point_numbers";
import { TileError } from "./tile_error";
import { cubeName, isInside, type LatticeMesh, type ManifestTile } from "./tile_mesh";
import { payloadCounts } from "./tile_payload";

export interface TileDecoding {
  draco: DecoderModule;
  hasher: TriangleHasher; // For the step's lattice resolution.
  resolution: number;
  hasNormals: boolean;
}

// Throws TileError.
export function decodeTile(payload: Uint8Array, expected: ManifestTile, { draco, hasher, resolution, hasNormals }: TileDecoding): LatticeMesh {
  const damaged = (what: string) => new TileError(`Tile at ${cubeName(expected.cube)}: ${what}.`);
  const counts = payloadCounts(payload);
  if (typeof counts === "string") throw damaged(counts);
  if (counts.triangles !== expected.triangles || counts.vertices < expected.vertices) {
    throw damaged(
      `it declares ${counts.triangles} triangles and ${counts.vertices} vertices; the manifest ` + `lists ${expected.triangles} and ${expected.vertices}`,
    );
  }
  const split = dracoDecoded(draco, payload, hasNormals, damaged);
  if (split.triangles.length !== 3 * expected.triangles) {
    throw damaged(`${split.triangles.length / 3} triangles were decoded instead of ${expected.triangles}`);
  }
  if (!isInside(split.positions, expected.cube, resolution)) {
    throw damaged("a vertex lies outside the tile's cube");
  }
  const mesh = welded(split);
  if (mesh.positions.length !== 3 * expected.vertices) {
    throw damaged(`${mesh.positions.length / 3} vertices were decoded instead of ${expected.vertices}`);
  }
  const found = hex(hasher(mesh.positions, mesh.triangles));
  if (found !== expected.key) {
    throw damaged(`the triangles have the digest ${found}; the manifest lists ${expected.key}`);
  }
  return mesh;
}

function dracoDecoded(draco: DecoderModule, payload: Uint8Array, hasNormals: boolean, damaged: (what: string) => TileError): LatticeMesh {
  const decoder = new draco.Decoder();
  const mesh = new draco.Mesh();
  try {
    const bytes = new Int8Array(payload.buffer, payload.byteOffset, payload.byteLength);
    const status = decoder.DecodeArrayToMesh(bytes, bytes.byteLength, mesh);
    if (!status.ok()) throw damaged(`Draco cannot decode it: ${status.error_msg()}`);
    const position = decoder.GetAttributeId(mesh, draco.POSITION);
    const normal = decoder.GetAttributeId(mesh, draco.NORMAL);
    if (position < 0 || normal >= 0 !== hasNormals) {
      throw damaged(hasNormals ? "it has no normals" : "it has attributes other than positions");
    }
    const points = mesh.num_points();
    const read = (attribute: number, type: number) =>
      fromHeap(draco, 12 * points, damaged, (pointer) =>
        decoder.GetAttributeDataArrayForAllPoints(
          mesh,
          decoder.GetAttribute(mesh, attribute),
          type as Parameters<Decoder["GetAttributeDataArrayForAllPoints"]>[2],
          12 * points,
          pointer,
        ),
      );
    const triangles = fromHeap(draco, 12 * mesh.num_faces(), damaged, (pointer) => decoder.GetTrianglesUInt32Array(mesh, 12 * mesh.num_faces(), pointer));
    return {
      positions: new Int32Array(read(position, draco.DT_INT32)),
      triangles: new Uint32Array(triangles),
      normals: hasNormals ? new Float32Array(read(normal, draco.DT_FLOAT32)) : null,
    };
  } finally {
    draco.destroy(mesh);
    draco.destroy(decoder);
  }
}

function fromHeap(draco: DecoderModule, bytes: number, damaged: (what: string) => TileError, fill: (pointer: number) => boolean): ArrayBuffer {
  const pointer = draco._malloc(bytes);
  if (pointer === 0) throw damaged(`there is not enough memory for its ${bytes} bytes`);
  try {
    if (!fill(pointer)) throw damaged("Draco did not return the decoded values");
    return (draco.HEAPF32.buffer as ArrayBuffer).slice(pointer, pointer + bytes);
  } finally {
    draco._free(pointer);
  }
}

// Draco splits a vertex where the tile's surface touches itself; restores one vertex per lattice point.
function welded(split: LatticeMesh): LatticeMesh {
  const points = split.positions.length / 3;
  const numbers = new PointNumbers(points);
  const renumbered = new Uint32Array(points);
  const normals = split.normals && new Float32Array(split.normals.length);
  const p = split.positions;
  for (let i = 0; i < points; ++i) {
    renumbered[i] = numbers.numberOf(p[3 * i], p[3 * i + 1], p[3 * i + 2]);
  }
  if (numbers.size === points) return split;
  if (normals) {
    renumbered.forEach((to, i) => normals.set(split.normals!.subarray(3 * i, 3 * i + 3), 3 * to));
  }
  return {
    positions: numbers.coordinates(),
    triangles: split.triangles.map((vertex) => renumbered[vertex]),
    normals: normals && normals.slice(0, 3 * numbers.size),
  };
}
