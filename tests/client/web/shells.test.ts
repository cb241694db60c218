// The golden sample shells decode as recorded from the C++ decoder in tests/golden/shells.txt.
import { readFileSync } from "node:fs";

import { payloadHasher } from "../../../client/web/src/mesh/content_digest";
import { type MarchedTile, type ShellMode, shellDecoder } from "../../../client/web/src/mesh/shell_decoder";
import { boundaryOf } from "../../../client/web/src/mesh/tile_boundary";
import type { ManifestTile } from "../../../client/web/src/mesh/tile_mesh";

const golden = new URL("../../golden/", import.meta.url);
const decoder = shellDecoder(readFileSync(new URL("../../../common/codec/wasm/shell_decoder.wasm", import.meta.url)));
const listed = readFileSync(new URL("shells.txt", golden), "utf8")
  .trim()
  .split("\n")
  .map((line) => line.split(" "));

// The mode and the lattice resolution of each shell, the same as in tests/support/golden_shells.hpp. `cube` contains all.
const modes: Record<string, [ShellMode, number]> = {
  example: [{ values: 0, levelsPerOctave: 0, spacing: 1 }, 5],
  exact: [{ values: 0, levelsPerOctave: 0, spacing: 1 }, 5],
  lattice_exact: [{ values: 1, levelsPerOctave: 0, spacing: 1 }, 5],
  quantized: [{ values: 2, levelsPerOctave: 2, spacing: 4 }, 3],
};
const cube = { exponent: 10, x: 0, y: 0, z: 0 };

async function digestOf(bytes: Uint8Array): Promise<string> {
  return (await payloadHasher())(bytes);
}

async function shell(name: string): Promise<{ bytes: Uint8Array; promised: ManifestTile; checksum: string }> {
  const [, vertices, triangles, checksum] = listed.find(([first]) => first === name)!;
  const bytes = new Uint8Array(readFileSync(new URL(`shell_${name}.bin`, golden)));
  const promised = { key: await digestOf(bytes), cube, triangles: Number(triangles), vertices: Number(vertices), bytes: bytes.length };
  return { bytes, promised, checksum };
}

async function marched(name: string): Promise<MarchedTile> {
  const { bytes, promised } = await shell(name);
  return (await decoder)(bytes, promised, ...modes[name]);
}

// Equals the checksum in tests/support/golden_shells.hpp.
function checksumOf({ mesh: { positions, triangles } }: MarchedTile): string {
  const compare = (a: number[], b: number[]) => a.map((value, i) => value - b[i]).find((d) => d !== 0) ?? 0;
  const all: number[][] = [];
  for (let t = 0; t < triangles.length; t += 3) {
    const corners = [0, 1, 2].map((k) => [...positions.subarray(3 * triangles[t + k], 3 * triangles[t + k] + 3)]);
    const turned = [0, 1, 2].map((k) => [...corners[k], ...corners[(k + 1) % 3], ...corners[(k + 2) % 3]]);
    all.push(turned.sort(compare)[0]);
  }
  const sum = all
    .sort(compare)
    .flat()
    .reduce((sum, value) => Math.imul(sum ^ value, 16777619), 2166136261);
  return (sum >>> 0).toString(16);
}

describe("ShellDecoder", () => {
  test.each(listed.map(([name]) => name))("MatchesTheNativeDecoder: %s", async (name) => {
    const tile = await marched(name);
    expect(checksumOf(tile)).toBe((await shell(name)).checksum);
    expect(checksumOf(await marched(name))).toBe(checksumOf(tile)); // In reused memory.
  });

  test("RejectsContradictionsToTheManifest", async () => {
    const { bytes, promised } = await shell("quantized");
    const [mode, resolution] = modes.quantized;
    const decode = await decoder;
    const refused = (change: Partial<ManifestTile>, otherMode = mode, otherResolution = resolution) =>
      expect(() => decode(bytes, { ...promised, ...change }, otherMode, otherResolution));
    refused({ key: "0".repeat(32) }).toThrow("digest");
    refused({ triangles: promised.triangles + 1 }).toThrow("declares");
    refused({ cube: { ...cube, exponent: 5 } }).toThrow("outside the tile's cube");
    refused({}, { ...mode, levelsPerOctave: 1 }).toThrow("another way");
    refused({}, { ...mode, values: 0, levelsPerOctave: 0 }).toThrow("another way");
    refused({}, { ...mode, spacing: 2 }).toThrow("spacing");
    refused({}, mode, resolution + 1).toThrow("spacing");
  });

  test("RejectsDamagedBytesWithValidDigest", async () => {
    const { bytes, promised } = await shell("exact");
    const decode = await decoder;
    for (const damaged of [bytes.slice(0, 8), bytes.slice(0, -5), Uint8Array.of(2, ...bytes.subarray(1)), new Uint8Array(0)]) {
      const key = await digestOf(damaged);
      expect(() => decode(damaged, { ...promised, key }, ...modes.exact)).toThrow(/its sample shell has/);
    }
  });
});

describe("TileBoundaryOfAShell", () => {
  test.each(["example", "exact", "quantized"])("MatchesComparingAllEdges: %s", async (name) => {
    const { mesh, box } = await marched(name);
    expect(box).not.toBeNull();
    const sorted = (edges: Uint32Array, vertices: Uint32Array) => {
      const pairs: string[] = [];
      for (let e = 0; e < edges.length; e += 2) pairs.push(`${vertices[edges[e]]} ${vertices[edges[e + 1]]}`);
      return pairs.sort();
    };
    const compared = boundaryOf(mesh);
    const found = boundaryOf(mesh, box);
    expect(sorted(found.edges, found.vertices)).toEqual(sorted(compared.edges, compared.vertices));
    const { innerVertices, innerEdges, nonmanifoldEdges, degenerateTriangles, components } = compared;
    expect(found).toMatchObject({ innerVertices, innerEdges, nonmanifoldEdges, degenerateTriangles, components });
  });

  test("IsUnknownWithVoidSamples", async () => {
    const { box } = await marched("lattice_exact");
    expect(box).toBeNull();
  });
});
