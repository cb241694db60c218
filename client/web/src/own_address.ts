// Where the page's server is, and the token that it is told.
import { session } from "./state/remembered";

// `?server=` names another one than the page's own, for those who work on the page.
export function serverAddress(): string {
  const scheme = location.protocol === "https:" ? "wss:" : "ws:";
  const own = `${scheme}//${location.host}/v1/stream`;
  return new URLSearchParams(location.search).get("server") ?? own;
}

// The token for one server. It comes with the page's address once (#token=...), or from the user,
// and is told to no other server than the one for which it came.
export class Token {
  private readonly name: string;
  private value: string;

  constructor(server: string) {
    this.name = `token:${server}`;
    const said = new URLSearchParams(location.hash.slice(1)).get("token");
    if (said) session.set(this.name, said);
    this.value = said ?? session.get(this.name) ?? "";
  }

  get(): string {
    return this.value;
  }

  set(value: string): void {
    this.value = value;
    session.set(this.name, value);
  }
}
