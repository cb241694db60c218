import { type DataBorder, isSound, matchBoundaries } from "../../../client/web/src/mesh/boundary_matcher";
import { glbScene } from "../../../client/web/src/mesh/glb_scene";
import { meshFile } from "../../../client/web/src/mesh/mesh_file";
import { fieldNormals, normalSums, packedNormals, smoothedSums } from "../../../client/web/src/mesh/normals";
import { nearestHit } from "../../../client/web/src/mesh/ray";
import { boundaryOf } from "../../../client/web/src/mesh/tile_boundary";
import { payloadCounts } from "../../../client/web/src/mesh/tile_payload";
import { weldedInWorld } from "../../../client/web/src/mesh/welded_mesh";
import type { DatasetInfo } from "../../../client/web/src/protocol/messages";
import { writtenDefaults } from "../../../client/web/src/state/settings";
import { meshAddress } from "../../../client/web/src/stream/mesh_request";

const corners = [
  [9, 5, 5],
  [5, 9, 5],
  [5, 5, 9],
  [1, 5, 5],
  [5, 1, 5],
  [5, 5, 1],
];
const octahedron = [
  [0, 1, 2],
  [1, 3, 2],
  [3, 4, 2],
  [4, 0, 2],
  [1, 0, 5],
  [3, 1, 5],
  [4, 3, 5],
  [0, 4, 5],
];
const border: DataBorder = { low: [0, 0, 0], high: [10, 10, 10], inset: 0, anywhere: false };
const identity = [1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0];

function mesh(faces: number[][], shift = 0) {
  const used = [...new Set(faces.flat())];
  return {
    positions: Int32Array.from(used.flatMap((v) => [corners[v][0] + shift, corners[v][1], corners[v][2]])),
    triangles: Uint32Array.from(faces.flat().map((v) => used.indexOf(v))),
    normals: null,
  };
}

function tile(faces: number[][], shift = 0) {
  const surface = mesh(faces, shift);
  const sums = normalSums(surface, 1);
  return {
    id: "tile",
    positions: Float32Array.from(surface.positions),
    triangles: surface.triangles,
    normals: packedNormals(sums),
    sums,
  };
}

// A file of one surface as a server writes it, whose data are `byte`.
function served(translation: number[], byte: number): Uint8Array {
  const json = JSON.stringify({
    asset: { version: "2.0", extras: { space: "RAS" } },
    scene: 0,
    scenes: [{ nodes: [0] }],
    nodes: [{ children: [1], translation }, { mesh: 0 }],
    meshes: [
      {
        primitives: [{ attributes: { POSITION: 0 }, indices: 1, material: 0 }],
        extensions: { EXT_mesh_manifold: { manifoldPrimitive: { mode: 4, indices: 1 }, mergeIndices: 1 } },
      },
    ],
    materials: [{ name: "isovalue 1" }],
    accessors: [{ bufferView: 0 }, { bufferView: 1 }],
    bufferViews: [
      { buffer: 0, byteOffset: 0, byteLength: 12 },
      { buffer: 0, byteOffset: 12, byteLength: 12 },
    ],
    buffers: [{ byteLength: 24 }],
  });
  const text = new TextEncoder().encode(json.padEnd(4 * Math.ceil(json.length / 4)));
  const glb = new Uint8Array(28 + text.length + 24).fill(byte);
  glb.set(new Uint8Array(Uint32Array.of(0x46546c67, 2, glb.length, text.length, 0x4e4f534a).buffer));
  glb.set(text, 20);
  glb.set(new Uint8Array(Uint32Array.of(24, 0x004e4942).buffer), 20 + text.length);
  return glb;
}

function topology(...tiles: number[][][]) {
  return matchBoundaries(
    tiles.map((faces) => boundaryOf(mesh(faces))),
    border,
  ).topology;
}

describe("BoundaryMatcher", () => {
  test("CountsDoNotDependOnTheTiling", () => {
    const whole = topology(octahedron);
    expect(whole).toMatchObject({ vertices: 6, edges: 12, eulerCharacteristic: 2, components: 1 });
    for (let cut = 1; cut < 8; ++cut) {
      expect(topology(octahedron.slice(0, cut), octahedron.slice(cut))).toEqual(whole);
    }
    expect(topology(...octahedron.map((face) => [face]))).toEqual(whole);
  });

  test("FindsCracks", () => {
    const torn = topology(octahedron.slice(0, 4), octahedron.slice(4, 7));
    expect(torn.openEdges).toBe(3);
    expect(isSound(torn)).toBe(false);
  });

  test("FindsFlippedTriangles", () => {
    const turned = octahedron.map((face, i) => (i === 3 ? [face[1], face[0], face[2]] : face));
    expect(topology(turned.slice(0, 3), turned.slice(3)).nonmanifoldEdges).toBe(3);
  });

  test("AllowsBordersOnlyAtTheEndOfTheData", () => {
    const half = octahedron.slice(0, 4);
    const at = (low: number) => matchBoundaries([boundaryOf(mesh(half))], { ...border, low: [0, 0, low] }).topology;
    expect(at(0)).toMatchObject({ openEdges: 4, borderEdges: 0 });
    expect(at(5)).toMatchObject({ openEdges: 0, borderEdges: 4 });
  });

  test("CountsSeparateSurfaces", () => {
    const far = matchBoundaries([boundaryOf(mesh(octahedron)), boundaryOf(mesh(octahedron, 100))], border).topology;
    expect(far).toMatchObject({ components: 2, eulerCharacteristic: 4 });
  });
});

describe("Files", () => {
  test("HaveOneVertexPerLatticePoint", () => {
    const tiles = [tile(octahedron.slice(0, 4)), tile(octahedron.slice(4))];
    const welded = weldedInWorld(tiles, identity);
    expect([welded.positions.length / 3, welded.triangles.length / 3]).toEqual([6, 8]);
  });

  test("KeepTheOrientationInMirroredWorlds", () => {
    const mirrored = weldedInWorld([tile(octahedron)], [-1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0]);
    expect(volume(mirrored)).toBeGreaterThan(0);
    expect(volume(weldedInWorld([tile(octahedron)], identity))).toBeGreaterThan(0);
  });

  test("MatchTheLengthInTheirHeaders", async () => {
    const mesh = () => weldedInWorld([tile(octahedron)], identity);
    expect((await meshFile(mesh(), "stl", 1)).length).toBe(84 + 8 * 50);
    const ply = new TextDecoder("latin1").decode(await meshFile(mesh(), "ply", 1));
    expect(ply.split("end_header\n")[1].length).toBe(6 * 12 + 8 * 13);
  });

  test("KeepTheLatticeFarFromTheOrigin", async () => {
    const far = [0.5, 0, 0, 0, 0.5, 0, 0, 0, 0.5, 500000, 5.4e6, 0];
    const { origin, positions } = weldedInWorld([tile(octahedron)], far);
    const corner = corners.map((at) => at.map((value, axis) => 0.5 * value + far[9 + axis]));
    corner.forEach((place, v) => place.forEach((value, axis) => expect(origin[axis] + positions[3 * v + axis]).toBe(value)));
    for (const format of ["stl", "ply"] as const) {
      await expect(meshFile(weldedInWorld([tile(octahedron)], far), format, 0.5)).rejects.toThrow("32-bit coordinates");
    }
  });

  test("HaveANodeForEverySurface", () => {
    const looks = [
      { name: "skin", color: "#ff8000", opacity: 0.5 },
      { name: "bone", color: "#ffffff", opacity: 1 },
    ];
    const files = looks.map((look, i) => ({ look, glb: served([0, 5.4e6 + i, 0], 6 + i) }));
    const glb = glbScene(files, "m");
    const view = new DataView(glb.buffer);
    expect(view.getUint32(8, true)).toBe(glb.length);
    const json = JSON.parse(new TextDecoder().decode(glb.subarray(20, 20 + view.getUint32(12, true))));
    expect(json.asset).toEqual({ version: "2.0", extras: { space: "RAS", length_unit: "m" } });
    expect(json.scenes).toEqual([{ nodes: [0, 2] }]);
    expect(json.nodes).toEqual([
      { children: [1], translation: [0, 5.4e6, 0] },
      { name: "skin", mesh: 0 },
      { children: [3], translation: [0, 5.4e6 + 1, 0] },
      { name: "bone", mesh: 1 },
    ]);
    expect(json.meshes[1].primitives[0]).toEqual({ attributes: { POSITION: 2 }, indices: 3, material: 1 });
    expect(json.meshes[1].extensions).toEqual({ EXT_mesh_manifold: { manifoldPrimitive: { mode: 4, indices: 3 }, mergeIndices: 3 } });
    const [skin, bone] = json.materials;
    expect([skin.name, skin.alphaMode, bone.alphaMode]).toEqual(["skin", "BLEND", undefined]);
    const [red, green, blue, alpha] = skin.pbrMetallicRoughness.baseColorFactor;
    expect([red, blue, alpha]).toEqual([1, 0, 0.5]);
    expect(green).toBeCloseTo(0.2158, 3);
    const begin = 28 + view.getUint32(12, true);
    for (const [i, { byteOffset, byteLength }] of json.bufferViews.entries()) {
      expect([...glb.subarray(begin + byteOffset, begin + byteOffset + byteLength)]).toEqual(Array(byteLength).fill(i < 2 ? 6 : 7));
    }
    expect(() => glbScene([{ look: looks[0], glb: new TextEncoder().encode('{"error":{"text":"no"}}') }], "")).toThrow("did not send a GLB");
  });

  test("HaveOutwardNormalsInAnyWorld", () => {
    const center = [5, 5, 5];
    for (const map of [
      identity,
      [2, 0, 0, 0, 3, 0, 0, 0, 0.5, 7, 8, 9],
      [-1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0],
      [1, 1, 0, -1, 1, 0, 0, 0, 4, 0, 0, 0],
      [0, 0, 2, 2, 0, 0, 0, 1, 0, 1, 2, 3],
    ]) {
      const { origin, positions, normals: n } = weldedInWorld([tile(octahedron)], map);
      const p = positions.map((value, i) => value + origin[i % 3]);
      const middle = [0, 1, 2].map((row) => map[9 + row] + [0, 1, 2].reduce((sum, c) => sum + map[3 * c + row] * center[c], 0));
      for (let v = 0; v < p.length; v += 3) {
        expect(Math.hypot(n[v], n[v + 1], n[v + 2])).toBeCloseTo(1, 5);
        // Normals of an octahedron point away from its center, along the axes, which the map scales.
        const away = [0, 1, 2].map((axis) => p[v + axis] - middle[axis]);
        expect(away.reduce((sum, value, axis) => sum + value * n[v + axis], 0) / Math.hypot(...away)).toBeGreaterThan(0.3);
      }
    }
  });

  test("KeepFieldNormals", () => {
    const map = [2, 0, 0, 0, 3, 0, 0, 0, 0.5, 7, 8, 9];
    const own = tile(octahedron);
    const world = Float32Array.from({ length: own.positions.length }, (_, i) => [0.6, 0, -0.8][i % 3]);
    const { normals } = weldedInWorld([{ ...own, normals: fieldNormals(world, map.slice(0, 9)) }], map);
    normals.forEach((value, i) => expect(value).toBeCloseTo([0.6, 0, -0.8][i % 3], 3));
  });
});

function volume({ positions: p, triangles }: { positions: Float32Array; triangles: Uint32Array }): number {
  let sum = 0;
  for (let t = 0; t < triangles.length; t += 3) {
    const [a, b, c] = [0, 1, 2].map((i) => Array.from(p.subarray(3 * triangles[t + i], 3 * triangles[t + i] + 3)));
    sum += a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) + a[2] * (b[0] * c[1] - b[1] * c[0]);
  }
  return sum / 6;
}

describe("Rays", () => {
  test("ReturnTheNearestHit", () => {
    const hit = nearestHit([tile(octahedron)], [5.1, 5.2, 20], [0, 0, -1])!;
    expect(hit.point[2]).toBeCloseTo(8.7, 5);
    expect(nearestHit([tile(octahedron)], [30, 5, 20], [0, 0, -1])).toBeNull();
  });

  test("IgnoreClippedTriangles", () => {
    const below = { normal: [0, 0, -1], constant: 5 };
    const hit = nearestHit([tile(octahedron)], [5.1, 5.2, 20], [0, 0, -1], [below])!;
    expect(hit.point[2]).toBeCloseTo(1.3, 5);
    expect(nearestHit([tile(octahedron)], [5.1, 5.2, 20], [0, 0, -1], [below, { normal: [1, 0, 0], constant: -6 }])).toBeNull();
  });
});

describe("MeshAddress", () => {
  test("NamesTheSettingsOfTheSurface", () => {
    const own = { ...writtenDefaults, isovalue: 3, error: 0.5, region: null, minComponent: "largest" as const, simplify: false, color: "#ff0000" };
    expect(meshAddress("wss://example.org/v1/stream", { name: "a b" } as DatasetInfo, 300.5, own, "stl")).toBe(
      "https://example.org/v1/datasets/a%20b/isosurface?isovalue=300.5&error=0.5&simplify=false&min_component=largest&format=stl",
    );
  });
});

describe("Normals", () => {
  test("PointOutwards", () => {
    const { positions, triangles } = mesh(octahedron);
    const sums = normalSums({ positions, triangles }, 16);
    for (let v = 0; v < 6; ++v) {
      const outwards = [0, 1, 2].map((axis) => (positions[3 * v + axis] - 5) * sums[3 * v + axis]);
      expect(outwards[0] + outwards[1] + outwards[2]).toBeGreaterThan(0);
    }
  });
});

describe("NormalSums", () => {
  // A sphere of radius 500 in patches, each of which is one large triangle and many small ones at a corner, as
  // simplified meshes have them: the normal at its top must be that of the sphere.
  test("AreNotDominatedByLargeTriangles", () => {
    const on = (x: number, y: number) => [x, y, Math.round(Math.sqrt(500 ** 2 - x * x - y * y))];
    const positions = Int32Array.from([on(0, 0), on(200, 0), on(0, 200), on(-40, 0), on(0, -40)].flat());
    const triangles = Uint32Array.from([0, 1, 2, 0, 2, 3, 0, 3, 4, 0, 4, 1]);
    const tilt = (sums: Float32Array) => Math.atan2(Math.hypot(sums[0], sums[1]), sums[2]);
    expect(tilt(normalSums({ positions, triangles }, 16))).toBeLessThan(0.12);
    // Weights by area tilt it more.
    expect(tilt(normalSums({ positions, triangles }, 1000))).toBeGreaterThan(0.17);
  });
});

describe("SpreadNormals", () => {
  // A plane of 13 x 13 points, each slightly above or below it.
  const side = 13;
  const positions = Int32Array.from({ length: 3 * side ** 2 }, (_, i) => {
    const v = Math.floor(i / 3);
    return [32 * (v % side), 32 * Math.floor(v / side), ((v * 2654435761) % 11) - 5][i % 3];
  });
  const cells = Array.from({ length: (side - 1) ** 2 }, (_, i) => (i % (side - 1)) + side * Math.floor(i / (side - 1)));
  const triangles = Uint32Array.from(cells.flatMap((v) => [v, v + 1, v + side, v + 1, v + side + 1, v + side]));
  const slope = (rounds: number) => {
    const sums = smoothedSums(normalSums({ positions, triangles }, 16), triangles, rounds);
    let steepest = 0;
    for (let v = 0; v < sums.length; v += 3) {
      if (Math.min(positions[v], positions[v + 1]) < 128 || Math.max(positions[v], positions[v + 1]) > 256) continue;
      steepest = Math.max(steepest, Math.hypot(sums[v], sums[v + 1]) / sums[v + 2]);
    }
    return steepest;
  };

  test("WeightTrianglesBySize", () => {
    expect(slope(1)).toBeLessThan(0.7 * slope(0));
    expect(slope(3)).toBeLessThan(0.4 * slope(0));
  });
});

describe("PayloadCounts", () => {
  test("RejectInvalidBytes", () => {
    expect(payloadCounts(new Uint8Array(0))).toContain("expected");
    expect(payloadCounts(new TextEncoder().encode("DRACO, or so it says"))).toContain("expected");
  });
});
