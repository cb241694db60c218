// The digest of a set of triangles on the lattice (common/mesh/content_digest.hpp): the sum of one XXH3-128 per
// triangle, over its coordinates starting from its smallest corner. The digests of tiles add up to that of the mesh.
import { createXXHash128 } from "hash-wasm";

export interface ContentDigest {
  high: bigint;
  low: bigint;
}

export const emptyDigest: ContentDigest = { high: 0n, low: 0n };

const mask = (1n << 64n) - 1n;

export function sum(a: ContentDigest, b: ContentDigest): ContentDigest {
  return { high: (a.high + b.high) & mask, low: (a.low + b.low) & mask };
}

// Returns 32 lower-case hexadecimal digits, `high` first. Also the key of a tile in maps.
export function hex(digest: ContentDigest): string {
  return digest.high.toString(16).padStart(16, "0") + digest.low.toString(16).padStart(16, "0");
}

export function fromHex(text: string): ContentDigest {
  return { high: BigInt(`0x${text.slice(0, 16)}`), low: BigInt(`0x${text.slice(16)}`) };
}

// Encodes keys for OpenStream.cached_tile_digests: 16 bytes each, `high` then `low`, little-endian.
export function packed(keys: readonly string[]): Uint8Array {
  const bytes = new Uint8Array(16 * keys.length);
  const view = new DataView(bytes.buffer);
  keys.forEach((key, i) => {
    const digest = fromHex(key);
    view.setBigUint64(16 * i, digest.high, true);
    view.setBigUint64(16 * i + 8, digest.low, true);
  });
  return bytes;
}

export type TriangleHasher = (positions: Int32Array, triangles: Uint32Array) => ContentDigest;

// Returns a function that digests a tile's bytes, for manifests of sample shells: hex() of one XXH3-128.
export async function payloadHasher(): Promise<(payload: Uint8Array) => string> {
  const hash = await createXXHash128(0, 0);
  return (payload) => hash.init().update(payload).digest("hex");
}

// Returns a function that digests meshes of the given lattice resolution. At most 2^20 triangles per call, so that the
// four sums of 32-bit parts stay exact in doubles.
export async function triangleHasher(resolution: number): Promise<TriangleHasher> {
  const hash = await createXXHash128(resolution, 0);
  const corners = new Int32Array(9);
  const bytes = new Uint8Array(corners.buffer);
  return (positions, triangles) => {
    const parts = [0, 0, 0, 0];
    for (let t = 0; t < triangles.length; t += 3) {
      const first = smallestCorner(positions, triangles, t);
      for (let corner = 0; corner < 3; ++corner) {
        const vertex = 3 * triangles[t + ((first + corner) % 3)];
        corners[3 * corner] = positions[vertex];
        corners[3 * corner + 1] = positions[vertex + 1];
        corners[3 * corner + 2] = positions[vertex + 2];
      }
      hash.init();
      hash.update(bytes);
      const d = hash.digest("binary");
      for (let i = 0; i < 4; ++i) {
        parts[i] += ((d[4 * i] << 24) | (d[4 * i + 1] << 16) | (d[4 * i + 2] << 8) | d[4 * i + 3]) >>> 0;
      }
    }
    const [a, b, c, d] = parts.map(BigInt);
    return { high: ((a << 32n) + b) & mask, low: ((c << 32n) + d) & mask };
  };
}

function smallestCorner(positions: Int32Array, triangles: Uint32Array, t: number): number {
  let first = 0;
  for (let corner = 1; corner < 3; ++corner) {
    if (isBefore(positions, 3 * triangles[t + corner], 3 * triangles[t + first])) first = corner;
  }
  return first;
}

function isBefore(p: Int32Array, a: number, b: number): boolean {
  if (p[a] !== p[b]) return p[a] < p[b];
  if (p[a + 1] !== p[b + 1]) return p[a + 1] < p[b + 1];
  return p[a + 2] < p[b + 2];
}
