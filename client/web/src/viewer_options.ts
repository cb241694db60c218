// What a viewer is made with, and what it reports.
import type { DatasetInfo } from "./protocol/messages";
import type { Picked } from "./scene/picking";
import type { ShownComponents, StepFacts } from "./state/progress";
import type { Settings } from "./state/settings";

export interface ViewerOptions extends Partial<Settings> {
  // The server's address: "https://example.org/volumes/", or that of its WebSocket. The page's own by default.
  server?: string;
  token?: string | TokenPlace;
}

// Where a token is, and where one goes that the user has typed.
export interface TokenPlace {
  get: () => string;
  set: (token: string) => void;
}

export interface PictureOptions {
  enlargement?: number; // Relative to the screen; default 1.
  width?: number; // In pixels, instead; as far as the graphics card can.
  isTransparent?: boolean; // Without a background.
  isOfFilm?: boolean; // One of many: its time is always written on it.
}

export interface ViewerEvents {
  settings: Settings; // All of them, after any change.
  dataset: DatasetInfo; // Another one is looked at, or the same one was prepared anew.
  // A step of the surface of that number, 0 for the first, and what of it is shown; null: all.
  shown: StepFacts & { surface: number; components: ShownComponents | null };
  progress: { surface: number };
  failed: string; // A dataset that does not exist is named: why, in a sentence. Failures of a surface are in its progress.
  picked: Picked;
}

// A token that is kept in memory alone.
export function placeOf(token: string): TokenPlace {
  let value = token;
  return { get: () => value, set: (typed) => (value = typed) };
}
