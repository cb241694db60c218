// The address of the page's server, or of the files that it reads without one, and its token.
import { sessionValues } from "../state/browser_storage";
import { addressOfFiles } from "../static/file_channel";

// Returns the address of a server's stream. By default it is relative to the page, which may be below a path of a site
// (https://example.org/volumes/), or to the configured page. `?server=` selects another server, for development: a page
// served by a server may not connect to another one (viewer_answer.cpp); other pages may.
//
// `?static=head.mtd` reads a prepared file, or an index of files, instead. Pages that `export --page` wrote name theirs.
export function serverAddress(configured?: string): string {
  const query = new URLSearchParams(location.search);
  const named = configured ?? query.get("server");
  const files = named === null ? (query.get("static") ?? filesOfPage()) : null;
  if (files) return addressOfFiles(files);
  if (named !== null && !/^https?:\/\//.test(named)) return named;
  const stream = new URL("v1/stream", named ?? location.href);
  stream.protocol = stream.protocol === "https:" ? "wss:" : "ws:";
  return stream.href;
}

function filesOfPage(): string | null {
  return document.querySelector<HTMLMetaElement>('meta[name="multitetra-static"]')?.content ?? null;
}

// Moves `static=` from the part of the address after '#', where it is short to write, to the query, where it stays.
export function keepStaticAddress(): void {
  const words = location.hash.slice(1).split("&");
  const named = words.find((word) => word.startsWith("static="));
  if (!named) return;
  const address = new URL(location.href);
  address.searchParams.set("static", decodeURIComponent(named.slice("static=".length)));
  address.hash = words.filter((word) => word !== named).join("&");
  history.replaceState(null, "", address);
}

// The token for one server, from the page's address (#token=..., once) or the user. It is sent only to that server.
export class Token {
  private readonly name: string;
  private value: string;

  constructor(server: string) {
    this.name = `token:${server}`;
    this.value = sessionValues.get(this.name) ?? "";
    this.readFrom(location.hash);
  }

  get(): string {
    return this.value;
  }

  set(value: string): void {
    this.value = value;
    sessionValues.set(this.name, value);
  }

  // Removes the token from the address of the page, from where it could be copied.
  static hide(): void {
    const { hash } = location;
    const shown = hash
      .slice(1)
      .split("&")
      .filter((word) => !word.startsWith("token="));
    if (shown.join("&") !== hash.slice(1)) history.replaceState(null, "", `#${shown.join("&")}`);
  }

  // Returns whether the address has a new token.
  readFrom(hash: string): boolean {
    const configured = new URLSearchParams(hash.replace(/^#/, "")).get("token");
    if (!configured || configured === this.value) return false;
    this.set(configured);
    return true;
  }
}
