import { Bookmarks } from "../../../client/web/src/state/bookmarks";
import { History } from "../../../client/web/src/state/history";
import { defaults, type Settings } from "../../../client/web/src/state/settings";
import { withSurface } from "../../../client/web/src/state/surfaces";

class Turned {
  settings: Settings = defaults;
  now = 0;
  readonly history = new History();

  turn(change: Partial<Settings>, after = 5000): void {
    const before = this.settings;
    this.settings = { ...before, ...change };
    this.history.note(this.settings, before, (this.now += after));
  }

  undo(): boolean {
    return this.history.undo(this.settings, (to) => this.turn(to));
  }
  redo(): boolean {
    return this.history.redo(this.settings, (to) => this.turn(to));
  }
}

describe("History", () => {
  test("UndoesAndRedoes", () => {
    const turned = new Turned();
    turned.turn({ error: 1 });
    turned.turn({ wireframe: true });
    expect(turned.undo()).toBe(true);
    expect(turned.settings).toMatchObject({ error: 1, wireframe: false });
    expect(turned.undo()).toBe(true);
    expect(turned.undo()).toBe(false);
    expect(turned.settings).toEqual(defaults);
    expect(turned.redo()).toBe(true);
    expect(turned.redo()).toBe(true);
    expect(turned.redo()).toBe(false);
    expect(turned.settings).toMatchObject({ error: 1, wireframe: true });
  });

  test("UndoesADragAsOneChange", () => {
    const turned = new Turned();
    for (const isovalue of [1, 2, 3, 4]) turned.turn(withSurface(turned.settings, 0, { isovalue }), 20);
    expect(turned.undo()).toBe(true);
    expect(turned.settings).toEqual(defaults);
    turned.turn({ error: 2 });
    expect(turned.redo()).toBe(false);
  });

  test("IgnoresTheCamera", () => {
    const turned = new Turned();
    turned.turn({ error: 1 });
    turned.turn({ eye: [1, 2, 3], target: [0, 0, 0] });
    expect(turned.undo()).toBe(true);
    expect(turned.settings).toMatchObject({ error: defaults.error, eye: [1, 2, 3] });
  });
});

describe("Bookmarks", () => {
  const memory = () => {
    const kept = new Map<string, string>();
    return { get: (name: string) => kept.get(name) ?? null, set: (name: string, value: string) => void kept.set(name, value) };
  };

  test("AreReplacedByName", () => {
    const place = memory() as never;
    const bookmarks = new Bookmarks(place);
    bookmarks.add({ name: "skull", address: "isovalue=400" });
    bookmarks.add({ name: "skin", address: "isovalue=-300" });
    bookmarks.add({ name: "skull", address: "isovalue=500" });
    expect(new Bookmarks(place).list().map(({ address }) => address)).toEqual(["isovalue=500", "isovalue=-300"]);
    bookmarks.remove("skull");
    expect(bookmarks.list()).toHaveLength(1);
  });

  test("IgnoreInvalidStorage", () => {
    for (const overrides of ["", "{", "7", '{"a":1}', '[1,null,{"name":"x"}]']) {
      const place = memory();
      place.set("bookmarks", overrides);
      expect(new Bookmarks(place as never).list()).toEqual([]);
    }
  });
});
