import { createRequire } from "node:module";

import type { FieldColours } from "../../../client/web/src/scene/field_colours";
import type { Programs } from "../../../client/web/src/scene/programs";
import { Surface } from "../../../client/web/src/scene/surface";
import type { DecodedTile } from "../../../client/web/src/workers/worker_messages";

// Packages are installed beside the viewer, not above its tests.
const installed = createRequire(new URL("../../../client/web/package.json", import.meta.url));
type Scene = ConstructorParameters<typeof Surface>[0];
const { Scene } = installed("three") as { Scene: new () => Scene };

interface Drawn {
  geometry: { getAttribute: (name: string) => { array: unknown } | undefined };
}

const toWorld = [1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0];

function tile(id: string, triangles = 1): DecodedTile {
  return {
    kind: "decoded", id, positions: new Float32Array(9), normals: new Int16Array(12), triangles: new Uint16Array(3 * triangles),
  };
}

function drawn() {
  const scene = new Scene();
  const dropped: string[] = [];
  const programs = { areReady: () => true } as unknown as Programs;
  const surface = new Surface(scene, () => {}, (ids) => dropped.push(...ids), {} as FieldColours, programs);
  const scalarOf = (at: number) => (scene.children[at] as unknown as Drawn).geometry.getAttribute("scalar")?.array;
  return { surface, scalarOf, dropped };
}

describe("Surface", () => {
  test("HasTheValuesOfATileAlsoWhereTheyAreHereFirst", () => {
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

  test("DropsWhatWasUnusedForLongestAndNothingThatSomebodyUses", () => {
    const { surface, dropped } = drawn();
    surface.budget = 25;
    for (const id of ["a", "b", "c", "d"]) surface.add(tile(id, 10), toWorld, 0);
    surface.use(["a"], {});
    surface.show(["d"]);
    surface.dropUnused();
    expect(dropped).toEqual(["b", "c"]);
    expect(surface.hasAll(["a", "d"])).toBe(true);
  });

  test("TakesNothingAnyMoreWhenItIsGone", () => {
    const { surface, dropped } = drawn();
    surface.dispose();
    surface.add(tile("a"), toWorld, 0);
    expect(dropped).toEqual(["a"]);
  });
});
