import { Embedding } from "../../../client/web/src/embedding";
import { defaults } from "../../../client/web/src/state/settings";
import type { Viewer } from "../../../client/web/src/viewer";

test("ForwardsDraggingOfSettings", () => {
  const set: unknown[] = [];
  const viewer = { on: () => {}, get: () => defaults, set: (...words: unknown[]) => set.push(words), info: null, surfaces: {
    progressOf: () => ({ shown: null, components: null }),
  } };
  const page = { postMessage: () => {} } as unknown as Window;
  const frame = new EventTarget();
  new Embedding(viewer as unknown as Viewer, page, frame as unknown as Window);
  for (const more of [{ dragging: true }, {}]) {
    const data = { multitetra: "set", state: { isovalue: 3 }, ...more };
    frame.dispatchEvent(Object.assign(new Event("message"), { source: page, origin: "https://a.example", data }));
  }
  expect(set).toEqual([[{ isovalue: 3 }, true], [{ isovalue: 3 }, false]]);
});
