// Views to come back to, each an address with a name. They stay in this browser.
import type { Memory } from "./browser_storage";

export interface Bookmark {
  name: string;
  address: string; // As toAddress() writes it: no token.
}

const key = "bookmarks";
const most = 50;

export class Bookmarks {
  constructor(private readonly memory: Memory) {}

  // The newest first.
  list(): Bookmark[] {
    try {
      const stored: unknown = JSON.parse(this.memory.get(key) ?? "[]");
      return Array.isArray(stored) ? stored.filter(isBookmark).slice(0, most) : [];
    } catch {
      return []; // What else is there under this name is not ours.
    }
  }

  // One of the same name is replaced.
  add(bookmark: Bookmark): void {
    const others = this.list().filter(({ name }) => name !== bookmark.name);
    this.keep([bookmark, ...others]);
  }

  remove(name: string): void {
    this.keep(this.list().filter((other) => other.name !== name));
  }

  private keep(list: Bookmark[]): void {
    this.memory.set(key, JSON.stringify(list.slice(0, most)));
  }
}

function isBookmark(one: unknown): one is Bookmark {
  const { name, address } = (one ?? {}) as Partial<Bookmark>;
  return typeof name === "string" && typeof address === "string";
}
