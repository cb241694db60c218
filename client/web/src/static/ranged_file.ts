// A file of a web server or an object store, read by ranges. A server without ranges is refused; a file that changes while
// it is read is noticed by its ETag or the time of its last change.

const retries = [300, 1000, 3000]; // Milliseconds between attempts.
const busy = new Set([429, 500, 502, 503, 504]);

export class RangedFile {
  bytesRead = 0; // Received so far.
  private tag: string | null = null; // Of the first reply; null: the server names none.

  constructor(readonly address: string) {}

  // Returns the bytes from `offset` to before `end`, fewer at the end of the file. Rejects with one sentence.
  async read(offset: number, end: number): Promise<Uint8Array> {
    const reply = await this.fetched(offset, end);
    if (reply.status === 200) {
      void reply.body?.cancel();
      throw new Error(
        `${this.host} ignores ranges and would send ${this.name} as a whole, as Python's http.server does: use nginx, Apache, Caddy, GitHub Pages or an object store.`,
      );
    }
    if (reply.status === 416) throw new Error(`${this.name} ends too early: upload it again.`);
    if (reply.status === 412) throw this.changed();
    if (reply.status !== 206) throw new Error(`${this.host} answered the request for ${this.name} with status ${reply.status}.`);
    const tag = reply.headers.get("ETag") ?? reply.headers.get("Last-Modified");
    this.tag ??= tag;
    if (tag !== this.tag) throw this.changed();
    const bytes = new Uint8Array(await reply.arrayBuffer());
    this.bytesRead += bytes.length;
    const range = reply.headers.get("Content-Range"); // Other sites may hide it.
    if (bytes.length > end - offset || (range !== null && !range.startsWith(`bytes ${offset}-${offset + bytes.length - 1}/`))) {
      throw new Error(`${this.host} sent other bytes of ${this.name} than those from ${offset} to ${end}.`);
    }
    return bytes;
  }

  private async fetched(offset: number, end: number): Promise<Response> {
    const headers: Record<string, string> = { Range: `bytes=${offset}-${end - 1}` };
    // Weak tags never match; and other sites would have to permit the header.
    const isOwn = new URL(this.address).origin === globalThis.location?.origin;
    if (isOwn && this.tag?.startsWith('"')) headers["If-Match"] = this.tag;
    for (const wait of retries) {
      const reply = await fetch(this.address, { headers, cache: "no-store" }).catch(() => null);
      if (reply && !busy.has(reply.status)) return reply;
      await new Promise((resolve) => setTimeout(resolve, wait));
    }
    try {
      return await fetch(this.address, { headers, cache: "no-store" });
    } catch {
      const permission = isOwn ? "" : ", or it does not permit this page to read it (CORS)";
      throw new Error(`${this.name} cannot be read: ${this.host} does not answer${permission}.`);
    }
  }

  // A name that identifies the content, for caches; null: unknown.
  get identity(): string | null {
    return this.tag && `${this.address} ${this.tag}`;
  }

  get name(): string {
    const name = new URL(this.address).pathname.split("/").at(-1)!;
    try {
      return `"${decodeURIComponent(name)}"`;
    } catch {
      return `"${name}"`; // It has a percent sign alone.
    }
  }

  private get host(): string {
    return new URL(this.address).host;
  }

  private changed(): Error {
    return new Error(`${this.name} has changed on ${this.host} while it was read: load the page again.`);
  }
}
