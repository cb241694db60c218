// The module `multitetra-viewer`: surfaces of a dataset in an element of a page.
//
//   import { Viewer } from "multitetra-viewer";
//   const viewer = new Viewer(element, { server: "https://example.org/", dataset: "head", isovalue: 500.5 });
//   viewer.on("shown", ({ isovalue, triangles }) => ...);
//   viewer.set({ error: 1, surfaces: [{ isovalue: 1200.5, opacity: 0.4 }] });
import type { EmbeddedEvents } from "./embed/embedded_events";
import { EmbeddedViewer } from "./embed/embedded_viewer";
import { parseSettings } from "./state/parse_settings";
import { defaults, type SurfaceSettings, type WrittenSettings } from "./state/settings";
import { fromWritten } from "./state/written_settings";
import { Viewer as SceneViewer } from "./viewer/viewer";
import type { PictureOptions, TokenStorage } from "./viewer/viewer_options";

export type { EmbeddedDataset, EmbeddedEvents, EmbeddedPick, EmbeddedStep } from "./embed/embedded_events";
export type { SurfaceSettings, WrittenSettings as Settings } from "./state/settings";
export type { PictureOptions, TokenStorage } from "./viewer/viewer_options";

// Surfaces need only an isovalue.
export type GivenSettings = Partial<Omit<WrittenSettings, "surfaces">> & {
  surfaces?: (Partial<SurfaceSettings> & { isovalue: number })[];
};

export interface ViewerOptions extends GivenSettings {
  // The server's address: "https://example.org/volumes/", that of its WebSocket, or that of a file
  // that needs none: "static:https://example.org/head.mtd". Default: the page's own server.
  server?: string;
  token?: string | TokenStorage;
}

const kinds: (keyof EmbeddedEvents)[] = ["state", "dataset", "shown", "picked", "error"];

export class Viewer {
  private readonly viewer: SceneViewer;
  private readonly embedded: EmbeddedViewer;

  // Throws TypeError for unknown or invalid settings, and Error if the browser cannot draw in three dimensions.
  constructor(element: HTMLElement, { server, token, ...given }: ViewerOptions = {}) {
    const { settings, ignored } = parseSettings(given);
    if (ignored.length > 0) throw new TypeError(`Unknown or invalid: ${ignored.join(", ")}.`);
    this.viewer = new SceneViewer(element, { ...fromWritten(defaults, settings), server, token });
    this.embedded = new EmbeddedViewer(this.viewer);
    if (given.maxTriangles === undefined) this.embedded.limitOnWeakDevices();
  }

  // Changes settings; `isDragging`: more changes follow immediately. Returns the names of unknown or invalid ones, such
  // as "error" or "surfaces[1].opacity", which are ignored.
  set(changes: GivenSettings, isDragging = false): string[] {
    return this.embedded.set(changes, isDragging);
  }

  get(): WrittenSettings {
    return this.embedded.get();
  }

  // Registers a listener; returns a function that removes it. Throws TypeError for an unknown event.
  on<K extends keyof EmbeddedEvents>(kind: K, listener: (what: EmbeddedEvents[K]) => void): () => void {
    if (!kinds.includes(kind)) throw new TypeError(`No event "${kind}"; the events are ${kinds.join(", ")}.`);
    return this.embedded.on(kind, listener);
  }

  // Shows the whole surface as set.
  fit(): void {
    this.embedded.fit();
  }

  // Returns to the first view.
  reset(): void {
    this.embedded.reset();
  }

  // Resolves when everything visible is complete or has failed.
  settled(): Promise<void> {
    return this.viewer.settled();
  }

  // Returns the complete scene as PNG. Rejects after a minute without progress.
  picture(options: PictureOptions = {}): Promise<Blob> {
    return this.embedded.picture(options);
  }

  // Ends all work; empties the element.
  dispose(): void {
    this.viewer.dispose();
  }
}
