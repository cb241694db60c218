// The options and events of a viewer.
import type { DatasetInfo } from "./protocol/messages";
import type { Picked } from "./scene/picking";
import type { ShownComponents, StepFacts } from "./state/progress";
import type { Settings } from "./state/settings";

export interface ViewerOptions extends Partial<Settings> {
  // The server's address: "https://example.org/volumes/", or that of its WebSocket. Default: the page's own server.
  server?: string;
  token?: string | TokenStorage;
}

// Where a token is read, and where one typed by the user is stored.
export interface TokenStorage {
  get: () => string;
  set: (token: string) => void;
}

export interface PictureOptions {
  enlargement?: number; // Relative to the screen; default: 1.
  width?: number; // In pixels, instead of `enlargement`, within the GPU's limits.
  isTransparent?: boolean; // Without a background.
  signal?: AbortSignal; // Ends the wait for the surface, with the signal's reason.
  isVideoFrame?: boolean; // A video frame, which always shows its time.
}

export interface ViewerEvents {
  settings: Settings; // All of them, after any change.
  dataset: DatasetInfo; // Another dataset is selected, or the current one was prepared again.
  // A drawn step of a visible surface (0 for the first) and its visible components; null: all. Again when the surface
  // becomes visible or moves to another place.
  shown: StepFacts & { surface: number; components: ShownComponents | null };
  progress: { surface: number };
  failed: string; // A nonexistent dataset was named: the reason in a sentence. Failures of a surface are in its progress.
  picked: Picked;
}

// A token kept only in memory.
export function tokenInMemory(token: string): TokenStorage {
  let value = token;
  return { get: () => value, set: (typed) => (value = typed) };
}
