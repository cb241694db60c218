// Named views of the user, stored as addresses in this browser.
import type { BrowserStorage } from "./browser_storage";

export interface Bookmark {
  name: string;
  address: string; // The result of toAddress(), without the token.
}

const key = "bookmarks";
const maxBookmarks = 50;

export class Bookmarks {
  constructor(private readonly memory: BrowserStorage) {}

  // Newest first.
  list(): Bookmark[] {
    try {
      const stored: unknown = JSON.parse(this.memory.get(key) ?? "[]");
      return Array.isArray(stored) ? stored.filter(isBookmark).slice(0, maxBookmarks) : [];
    } catch {
      return []; // Stored by something else under this name.
    }
  }

  // Replaces a bookmark of the same name.
  add(bookmark: Bookmark): void {
    const others = this.list().filter(({ name }) => name !== bookmark.name);
    this.keep([bookmark, ...others]);
  }

  remove(name: string): void {
    this.keep(this.list().filter((other) => other.name !== name));
  }

  private keep(list: Bookmark[]): void {
    this.memory.set(key, JSON.stringify(list.slice(0, maxBookmarks)));
  }
}

function isBookmark(one: unknown): one is Bookmark {
  const { name, address } = (one ?? {}) as Partial<Bookmark>;
  return typeof name === "string" && typeof address === "string";
}
