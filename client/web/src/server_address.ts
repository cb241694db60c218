// The address of the page's server, and the token for it.
import { session } from "./state/browser_storage";

// The address of a server's stream. The page's own server is beside the page, which may be below a path of a site
// (https://example.org/volumes/); the same holds for the address of any other page. `?server=` names another server,
// for development: a page from a server may not connect to another one (viewer_answer.cpp); one from elsewhere may.
export function serverAddress(configured?: string): string {
  const named = configured ?? new URLSearchParams(location.search).get("server");
  if (named !== null && !/^https?:\/\//.test(named)) return named;
  const stream = new URL("v1/stream", named ?? location.href);
  stream.protocol = stream.protocol === "https:" ? "wss:" : "ws:";
  return stream.href;
}

// Where the same server answers single queries: the folder of its stream.
export function httpAddress(stream: string): string {
  const folder = new URL(".", stream);
  folder.protocol = folder.protocol === "wss:" ? "https:" : "http:";
  return folder.href;
}

// The token for one server. It comes with the page's address once (#token=...), or from the user, and is sent to that
// server only.
export class Token {
  private readonly name: string;
  private value: string;

  constructor(server: string) {
    this.name = `token:${server}`;
    this.value = session.get(this.name) ?? "";
    this.takeFrom(location.hash);
  }

  get(): string {
    return this.value;
  }

  set(value: string): void {
    this.value = value;
    session.set(this.name, value);
  }

  // Whether the address brought one that is news.
  takeFrom(hash: string): boolean {
    const configured = new URLSearchParams(hash.replace(/^#/, "")).get("token");
    if (!configured || configured === this.value) return false;
    this.set(configured);
    return true;
  }
}
