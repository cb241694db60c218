// Where the page's server is, and the token that it is told.
import { session } from "./state/remembered";

// `?server=` names another one than the page's own, for those who work on the page. A page that a
// server has sent may not talk with another one (viewer_files.cpp); one from elsewhere may. Its own
// is beside the page, which may be below a path of a site (https://example.org/volumes/).
export function serverAddress(): string {
  const own = new URL("v1/stream", location.href);
  own.protocol = own.protocol === "https:" ? "wss:" : "ws:";
  return new URLSearchParams(location.search).get("server") ?? own.href;
}

// The token for one server. It comes with the page's address once (#token=...), or from the user,
// and is told to no other server than the one for which it came.
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
    const said = new URLSearchParams(hash.replace(/^#/, "")).get("token");
    if (!said || said === this.value) return false;
    this.set(said);
    return true;
  }
}
