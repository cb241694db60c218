// Lets an embedding page set and read the view, and sends it events, by window messages, which client/web/EMBEDDING.md
// documents. Only the parent page may send messages. It receives events only after its first message, at the origin of
// that message, beginning with the current state: what is shown, or why nothing is.
import type { Viewer, ViewerEvents } from "./viewer";
import type { DatasetInfo } from "./protocol/messages";
import type { Picked } from "./scene/picking";
import { parseSettings } from "./state/parse_settings";

const version = 1;
const together = 100; // Milliseconds: changes within this time are sent together.
const maxPictureWait = 60_000; // Milliseconds without progress.

interface Query {
  multitetra?: unknown;
  id?: unknown;
  state?: unknown;
  dragging?: unknown; // Of set: more will follow at once.
}

export class Embedding {
  private origin: string | null = null; // The origin of the parent page, after its first message.
  private timer = 0;
  private isFitDue = false; // When a step of the set isovalue is shown.
  private failure = ""; // Why the requested surface is not shown; empty: no failure.

  constructor(
    private readonly viewer: Viewer,
    private readonly around: Window,
    private readonly ignoredInAddress: string[] = [], // The names that the first reply to the page has.
    private readonly self: Window = window,
  ) {
    self.addEventListener("message", (event) => {
      if (event.source === this.around) void this.receive(event.data as Query, event.origin);
    });
    viewer.on("settings", () => this.schedulePostState());
    viewer.on("dataset", (info) => {
      this.failure = "";
      this.postDataset(info);
    });
    viewer.on("shown", (facts) => {
      this.failure = "";
      this.post("shown", stepMessage(facts));
      if (this.isFitDue) this.fit();
    });
    viewer.on("failed", (text) => this.fail(text));
    viewer.on("progress", ({ surface }) => this.fail(viewer.surfaces.progressOf(surface).failure?.text));
    viewer.on("picked", (place) => this.post("picked", pickMessage(place)));
    around.postMessage({ multitetra: "ready", version }, "*"); // Contains no other information.
  }

  private async receive(query: Query | null, origin: string): Promise<void> {
    const { multitetra: kind, id, state, dragging } = query ?? {};
    if (typeof kind !== "string") return; // From another sender.
    const { settings, ignored } = parseSettings(kind === "set" ? state : null);
    if (kind === "set") {
      this.failure = "";
      // Before `origin` is known: events of replaced settings are not sent to a page whose first message this is.
      this.viewer.set(settings, dragging === true);
    }
    const isFirst = this.origin === null;
    this.origin = origin;
    if (isFirst) this.postMissed();
    switch (kind) {
      case "set":
      case "get":
        return this.post("state", { id, state: this.viewer.get(), ignored: [...this.ignoredInAddress.splice(0), ...ignored] });
      case "fit":
        return this.fit();
      case "reset":
        return this.viewer.reset();
      case "picture":
        return this.postPicture(id);
      default:
        return this.post("error", { id, text: `Unknown message "${kind}"; the messages are set, get, fit, reset and picture.` });
    }
  }

  private fit(): void {
    this.isFitDue = !this.viewer.surfaces.isCurrent(0);
    if (!this.isFitDue) this.viewer.fit();
  }

  // A picture of a frame that the browser does not draw, or of a very slow surface, would never be complete.
  private async postPicture(id: unknown): Promise<void> {
    const wait = new AbortController();
    const error = new Error(`Nothing more of the surface arrived for ${maxPictureWait / 1000} s.`);
    const extend = () => {
      this.self.clearTimeout(timer);
      timer = this.self.setTimeout(() => wait.abort(error), maxPictureWait);
    };
    let timer: number | undefined;
    extend();
    const ignore = this.viewer.on("progress", extend);
    try {
      this.post("picture", { id, png: await this.viewer.picture({ signal: wait.signal }) });
    } catch (reason) {
      this.post("error", { id, text: `No picture: ${(reason as Error).message}` });
    } finally {
      this.self.clearTimeout(timer);
      ignore();
    }
  }

  private fail(text: string | undefined): void {
    if (!text || text === this.failure) return;
    this.failure = text;
    this.post("error", { text });
  }

  private postMissed(): void {
    const { info, surfaces } = this.viewer;
    if (info) this.postDataset(info);
    for (const shown of surfaces.reports.current) this.post("shown", stepMessage(shown));
    if (this.failure) this.post("error", { text: this.failure });
  }

  private postDataset(info: DatasetInfo): void {
    this.post("dataset", {
      name: info.name, dims: [...info.dims], spacing: [...info.spacing], min: info.min, max: info.max,
      lengthUnit: info.lengthUnit, valueUnit: info.valueUnit, suggestedIsovalues: [...info.suggestedIsovalues],
      member: memberOf(info), times: this.viewer.times?.all ?? [],
    });
  }

  private schedulePostState(): void {
    clearTimeout(this.timer);
    this.timer = this.self.setTimeout(() => this.post("state", { state: this.viewer.get(), ignored: [] }), together);
  }

  private post(kind: string, words: object): void {
    if (this.origin === null) return;
    // A page opened from a file has no origin, but is still the only parent page.
    this.around.postMessage({ multitetra: kind, ...words }, this.origin === "null" ? "*" : this.origin);
  }
}

function memberOf({ member }: DatasetInfo): object | null {
  if (!member) return null;
  const { series, field, time = null, timeUnit, label } = member;
  return { series, field, time, timeUnit, label: label ? { value: label.value, name: label.name } : null };
}

// Removes the error of previews: it is not a distance to the surface.
function stepMessage(facts: ViewerEvents["shown"]): object {
  return facts.spacing > 1 ? { ...facts, errorWorld: null, errorVoxels: null } : { ...facts };
}

function pickMessage({ world, index, surface }: Picked): object {
  return { world, index, isovalue: surface ? surface.tiles.shown.facts.isovalue : null };
}
