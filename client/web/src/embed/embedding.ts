// Lets a page around a frame set and read the view, and sends it events, by window messages, which
// client/web/EMBEDDING.md documents. Only the parent page may send messages. It receives events only after its first
// message, at the origin of that message, beginning with the current state: what is shown, or why nothing is.
import type { EmbeddedViewer } from "./embedded_viewer";

const version = 1;

interface Query {
  multitetra?: unknown;
  id?: unknown;
  state?: unknown;
  dragging?: unknown; // In a `set` message: whether more will follow at once.
}

// Announces a frame to the page around it, and waits until it is seen or the page sends a message. Returns the messages
// until then.
export function firstSight(around: Window): Promise<MessageEvent[]> {
  return new Promise((resolve) => {
    const messages: MessageEvent[] = [];
    const end = () => {
      seen.disconnect();
      window.removeEventListener("message", receive);
      resolve(messages);
    };
    const receive = (event: MessageEvent) => {
      if (event.source !== around) return;
      messages.push(event);
      end();
    };
    const seen = new IntersectionObserver((entries) => entries.some(({ isIntersecting }) => isIntersecting) && end());
    window.addEventListener("message", receive);
    seen.observe(document.body);
    around.postMessage({ multitetra: "ready", version }, "*"); // Contains no other information.
  });
}

export class Embedding {
  private origin: string | null = null; // The origin of the parent page, after its first message.

  constructor(
    private readonly viewer: EmbeddedViewer,
    private readonly around: Window,
    private readonly ignoredInAddress: string[] = [], // The names that the first reply to the page has.
    early: readonly MessageEvent[] = [], // The messages of the page until now.
    self: Window = window,
  ) {
    const receive = ({ source, data, origin }: MessageEvent) => {
      if (source === this.around) void this.receive(data as Query, origin);
    };
    self.addEventListener("message", receive);
    viewer.on("state", (state) => this.post("state", { state, ignored: [] }));
    viewer.on("dataset", (dataset) => this.post("dataset", dataset));
    viewer.on("shown", (step) => this.post("shown", step));
    viewer.on("picked", (place) => this.post("picked", place));
    viewer.on("error", (text) => this.post("error", { text }));
    early.forEach(receive);
  }

  private async receive(query: Query | null, origin: string): Promise<void> {
    const { multitetra: kind, id, state, dragging } = query ?? {};
    if (typeof kind !== "string") return; // From another sender.
    // Before `origin` is known: events of replaced settings are not sent to a page whose first message this is.
    const ignored = kind === "set" ? this.viewer.set(state, dragging === true) : [];
    const isFirst = this.origin === null;
    this.origin = origin;
    if (isFirst) this.viewer.emitMissed();
    if (kind === "fit") this.viewer.fit();
    if (kind === "reset") this.viewer.reset();
    if (kind === "picture") return this.postPicture(id);
    if (["set", "get", "fit", "reset"].includes(kind)) {
      return this.post("state", { id, state: this.viewer.get(), ignored: [...this.ignoredInAddress.splice(0), ...ignored] });
    }
    this.post("error", { id, text: `Unknown message "${kind}"; the messages are set, get, fit, reset and picture.` });
  }

  private async postPicture(id: unknown): Promise<void> {
    try {
      this.post("picture", { id, png: await this.viewer.picture() });
    } catch (reason) {
      this.post("error", { id, text: `No picture: ${(reason as Error).message}` });
    }
  }

  private post(kind: string, words: object): void {
    if (this.origin === null) return;
    // A page opened from a file has no origin, but is still the only parent page.
    this.around.postMessage({ multitetra: kind, ...words }, this.origin === "null" ? "*" : this.origin);
  }
}
