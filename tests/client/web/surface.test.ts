import { createRequire } from "node:module";

import type { FieldColors } from "../../../client/web/src/scene/field_colors";
import { layers } from "../../../client/web/src/scene/layers";
import type { Programs } from "../../../client/web/src/scene/programs";
import { Surface } from "../../../client/web/src/scene/surface";
import type { DecodedTile } from "../../../client/web/src/workers/worker_messages";

// Packages are installed next to the viewer, not above its tests.
const installed = createRequire(new URL("../../../client/web/package.json", import.meta.url));
type Scene = ConstructorParameters<typeof Surface>[0];
const { Scene } = installed("three") as { Scene: new () => Scene };

interface Drawn {
  geometry: {
    getAttribute: (name: string) => { array: unknown } | undefined;
    getIndex: () => { array: Uint16Array };
    drawRange: { count: number };
  };
}

const toWorld = [1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0];

function tile(id: string, triangles = 1): DecodedTile {
  return {
    kind: "decoded",
    id,
    positions: new Float32Array(9),
    normals: new Int16Array(12),
    triangles: new Uint16Array(3 * triangles),
  };
}

function drawn() {
  const scene = new Scene();
  const dropped: string[] = [];
  const programs = { areReady: () => true } as unknown as Programs;
  const surface = new Surface(
    scene,
    () => {},
    () => {},
    (ids) => dropped.push(...ids),
    {} as FieldColors,
    programs,
  );
  const scalarOf = (at: number) => (scene.children[at] as unknown as Drawn).geometry.getAttribute("scalar")?.array;
  const partOf = (at: number) => {
    const { geometry } = scene.children[at] as unknown as Drawn;
    return { triangles: [...geometry.getIndex().array], drawn: geometry.drawRange.count };
  };
  const meshOf = (at: number) => scene.children[at];
  return { surface, scalarOf, partOf, meshOf, dropped };
}

describe("Surface", () => {
  test("AcceptsScalarsBeforeTheirTile", () => {
    const { surface, scalarOf } = drawn();
    const [early, late] = [Float32Array.of(1, 1.5, 2), Float32Array.of(2, 2, 2)];
    surface.use(["a", "b"], surface);
    surface.setScalars("a", early);
    surface.add(tile("a"), toWorld, 0);
    surface.add(tile("b"), toWorld, 0);
    surface.setScalars("b", late);
    surface.uploadSome();
    expect([scalarOf(0), scalarOf(1)]).toEqual([early, late]);
  });

  test("UploadsTilesBeforeTheyAreVisible", async () => {
    const { surface, meshOf } = drawn();
    surface.add(tile("a"), toWorld, 0);
    expect(surface.uploadSome()).toBe(true);
    expect(meshOf(0).layers.mask).toBe(1 << layers.upload);
    await surface.uploaded(["a"]);
    expect([meshOf(0).layers.mask, meshOf(0).visible]).toEqual([1 << layers.solid, false]);
    expect(surface.uploadSome()).toBe(false);
    surface.show(["a"]);
    expect(meshOf(0).visible).toBe(true);
  });

  test("EvictsLeastRecentlyUsedTiles", () => {
    const { surface, dropped } = drawn();
    surface.budget = 25;
    for (const id of ["a", "b", "c", "d"]) surface.add(tile(id, 10), toWorld, 0);
    surface.use(["a"], {});
    surface.show(["d"]);
    surface.dropUnused();
    expect(dropped).toEqual(["b", "c"]);
    expect(surface.hasAll(["a", "d"])).toBe(true);
  });

  test("DrawsOnlySelectedComponents", () => {
    const { surface, partOf } = drawn();
    for (const id of ["a", "b"]) {
      const triangles = Uint16Array.of(0, 1, 2, 3, 4, 5);
      surface.add({ ...tile(id), positions: Float32Array.from({ length: 18 }, (_, i) => i), triangles }, [2, 0, 0, 0, 2, 0, 0, 0, 2, 1, 1, 1], 0);
    }
    surface.uploadSome();
    surface.show(["a", "b"]);
    expect([partOf(0).drawn, partOf(1).drawn]).toEqual([Infinity, Infinity]);
    expect(surface.worldBox().max.x).toBe(31);
    const parted = [{ id: "a", triangles: Uint16Array.of(3, 4, 5, 0, 1, 2), shown: 1 }];
    surface.show(["a", "b"], { components: 3, shown: 2, triangles: 3, largest: [0, 0, 0, 1, 2, 3], parted });
    expect([partOf(0), partOf(1).drawn]).toEqual([{ triangles: [3, 4, 5, 0, 1, 2], drawn: 3 }, Infinity]);
    expect(surface.worldBox().max.toArray()).toEqual([3, 5, 7]);
    surface.show(["a", "b"], { components: 3, shown: 0, triangles: 0, largest: null, parted: [{ ...parted[0], shown: 0 }] });
    expect([partOf(0).drawn, surface.worldBox().isEmpty()]).toEqual([0, true]);
    surface.show(["a", "b"]);
    expect([partOf(0).drawn, surface.worldBox().max.x]).toEqual([Infinity, 31]);
  });

  test("RejectsTilesAfterDisposal", () => {
    const { surface, dropped } = drawn();
    surface.dispose();
    surface.add(tile("a"), toWorld, 0);
    expect(dropped).toEqual(["a"]);
  });
});
