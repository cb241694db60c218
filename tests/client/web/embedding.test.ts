import { EmbeddedViewer } from "../../../client/web/src/embed/embedded_viewer";
import { Embedding } from "../../../client/web/src/embed/embedding";
import { defaults } from "../../../client/web/src/state/settings";
import type { Viewer } from "../../../client/web/src/viewer/viewer";

const facts = { isovalue: 3, spacing: 1 };

// A frame with a page around it; `said` has the messages to the page.
function framed(parts: object = {}, ignoredInAddress: string[] = []) {
  const set: unknown[] = [];
  const listeners: [string, (what: unknown) => void][] = [];
  const viewer = {
    on: (...words: (typeof listeners)[number]) => {
      listeners.push(words);
      return () => listeners.splice(listeners.indexOf(words), 1);
    },
    get: () => defaults,
    setWritten: (...words: unknown[]) => set.push(words),
    info: null,
    surfaces: { reports: { current: [facts] } },
    ...parts,
  };
  const said: { multitetra: string; [name: string]: unknown }[] = [];
  const page = { postMessage: (message: (typeof said)[number]) => said.push(message) } as unknown as Window;
  const frame = Object.assign(new EventTarget(), { setTimeout, clearTimeout });
  const embedded = new EmbeddedViewer(viewer as unknown as Viewer, frame as unknown as Window);
  new Embedding(embedded, page, ignoredInAddress, [], frame as unknown as Window);
  const say = (message: object) => frame.dispatchEvent(Object.assign(new Event("message"), { source: page, origin: "https://a.example", data: message }));
  return { set, say, said, emit: (kind: string, what: unknown) => listeners.forEach(([one, listener]) => one === kind && listener(what)) };
}

describe("Embedding", () => {
  test("ForwardsDraggingOfSettings", () => {
    const { set, say } = framed();
    for (const more of [{ dragging: true }, {}]) say({ multitetra: "set", state: { isovalue: 3 }, ...more });
    expect(set).toEqual([
      [{ isovalue: 3 }, true],
      [{ isovalue: 3 }, false],
    ]);
  });

  test("ReportsAFailureAgainAfterTheNextSet", () => {
    const { say, said, emit } = framed();
    say({ multitetra: "get" });
    for (let i = 0; i < 2; ++i) {
      say({ multitetra: "set", state: { dataset: "nope" } });
      emit("failed", "No dataset named nope.");
      emit("failed", "No dataset named nope.");
    }
    expect(said.filter(({ multitetra }) => multitetra === "error").length).toBe(2);
  });

  test("SendsNoSurfaceThatIsReplaced", () => {
    const reports = { current: [facts] };
    const { say, said } = framed({ surfaces: { reports }, setWritten: () => (reports.current = []) });
    say({ multitetra: "set", state: { isovalue: 4 } });
    expect(said.map(({ multitetra }) => multitetra)).toEqual(["state"]);
  });

  test("FitsTheSurfaceThatIsSet", () => {
    let [isCurrent, fits] = [false, 0];
    const surfaces = { reports: { current: [] }, isCurrent: () => isCurrent };
    const { say, emit } = framed({ surfaces, fit: () => ++fits });
    say({ multitetra: "fit" });
    emit("shown", facts);
    expect(fits).toBe(0);
    isCurrent = true;
    for (let i = 0; i < 2; ++i) emit("shown", facts);
    expect(fits).toBe(1);
    say({ multitetra: "fit" });
    expect(fits).toBe(2);
  });

  test("ReportsIgnoredNamesOfTheAddressOnce", () => {
    const { say, said } = framed({}, ["isovalue"]);
    say({ multitetra: "set", state: { error: NaN } });
    say({ multitetra: "get" });
    expect(said.filter(({ multitetra }) => multitetra === "state").map(({ ignored }) => ignored)).toEqual([["isovalue", "error"], []]);
  });

  test("RepliesToEveryPicture", async () => {
    const { say, said } = framed({ picture: () => Promise.reject(new Error("the context is lost")) });
    say({ multitetra: "picture", id: 7 });
    await vi.waitFor(() => expect(said.at(-1)).toEqual({ multitetra: "error", id: 7, text: "No picture: the context is lost" }));
    vi.useFakeTimers();
    const picture = ({ signal }: { signal: AbortSignal }) => new Promise((_, reject) => (signal.onabort = () => reject(signal.reason as Error)));
    const hidden = framed({ picture, surfaces: { reports: { current: [] }, progressOf: () => ({}) } });
    hidden.say({ multitetra: "picture", id: 8 });
    await vi.advanceTimersByTimeAsync(59_000);
    hidden.emit("progress", { surface: 0 }); // A slow device continues.
    await vi.advanceTimersByTimeAsync(59_000);
    expect(hidden.said).toHaveLength(0);
    await vi.advanceTimersByTimeAsync(1000);
    vi.useRealTimers();
    expect(hidden.said.at(-1)).toEqual({ multitetra: "error", id: 8, text: "No picture: Nothing more of the surface arrived for 60 s." });
  });

  test("ReportsAndShowsNothingWhereNothingCanBeDrawn", () => {
    const { say, said, emit } = framed({ isBlank: true });
    say({ multitetra: "get" });
    emit("failed", "The browser took the graphics.");
    emit("shown", facts);
    expect(said.slice(-1)).toEqual([{ multitetra: "error", text: "The browser took the graphics." }]);
  });

  test("EndsPicturesBySignals", async () => {
    const picture = ({ signal }: { signal: AbortSignal }) => new Promise((_, reject) => (signal.onabort = () => reject(signal.reason as Error)));
    const viewer = new EmbeddedViewer({ on: () => () => {}, picture } as unknown as Viewer, globalThis as unknown as Window);
    const end = new AbortController();
    const pending = viewer.picture({ signal: end.signal });
    end.abort(new Error("enough"));
    await expect(pending).rejects.toThrow("enough");
    await expect(viewer.picture({ signal: end.signal })).rejects.toThrow("enough");
  });
});
