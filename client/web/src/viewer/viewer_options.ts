// The options of a viewer.
import type { Settings } from "../state/settings";

export interface ViewerOptions extends Partial<Settings> {
  // The server's address: "https://example.org/volumes/", that of its WebSocket, or that of a file
  // that needs none: "static:https://example.org/head.mtd". Default: the page's own server.
  server?: string;
  token?: string | TokenStorage;
  showAgain?: () => void; // Begins again when the browser has taken the scene's graphics away.
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

// A token kept only in memory.
export function tokenInMemory(token: string): TokenStorage {
  let value = token;
  return { get: () => value, set: (typed) => (value = typed) };
}
