// Synchronizes settings and the page's address: changed settings appear in the address, edits of it are applied, and
// the browser's "Back" reverts a change of dataset or isovalue.
import type { Token } from "./server_address";
import { named, shortened, startOf } from "./state/series";
import type { Settings } from "./state/settings";
import { edited, misread, toAddress } from "./state/url_state";
import type { Viewer } from "./viewer";

export class AddressKeeper {
  private initialOutput: string;
  private timer = 0;
  private remembered: string | null = null; // Dataset and isovalue of the current history entry.
  private isDragging = false;

  constructor(
    private readonly viewer: Viewer,
    private readonly token: Token,
    hash: string,
  ) {
    this.initialOutput = hash;
    viewer.on("settings", () => this.rememberSoon());
    viewer.on("dataset", () => {
      this.reportMisread(this.initialOutput);
      this.initialOutput = "";
    });
    // The event has the edited address; the address itself may be replaced before the event arrives.
    window.addEventListener("hashchange", ({ newURL }) => this.useEdited(new URL(newURL).hash));
    this.rememberSoon();
  }

  // Nothing is remembered while dragging.
  drags(isDragging: boolean): void {
    this.isDragging = isDragging;
  }

  // Returns the settings for the address, always with the dataset's name, and with labels in short form.
  addressed(): Settings {
    const now = this.viewer.get();
    const { info, surfaces } = this.viewer;
    return shortened(surfaces.datasets.get().list ?? [], now.dataset || !info ? now : { ...now, dataset: info.name });
  }

  // Called when the user has edited the address or followed a link to this page.
  useEdited(hash: string): void {
    this.rememberSoon(); // Rewrites the address in canonical form, without the token.
    if (this.token.takeFrom(hash)) this.viewer.surfaces.connect();
    this.remembered = null; // The browser has already made a history entry.
    if (hash.slice(1) === toAddress(this.addressed())) return;
    const { dataset, ...now } = edited(this.viewer.get(), hash);
    const { list } = this.viewer.surfaces.datasets.get();
    const isUnknown = dataset !== "" && list !== null && named(list, dataset) === null;
    const wanted = { ...now, dataset: dataset && !isUnknown ? dataset : this.addressed().dataset };
    // Resolved immediately, so that remaining labels are not loaded again.
    const labels = list && wanted.labels ? startOf(list, wanted)?.changes : null;
    this.viewer.set({ ...wanted, ...labels });
    if (isUnknown) this.viewer.reportUnknown(dataset);
    else this.reportMisread(hash);
  }

  private reportMisread(hash: string): void {
    const ignored = misread(hash);
    if (ignored.length === 0) return;
    const words = ignored.slice(0, 3).map((word) => (word.length > 40 ? `${word.slice(0, 39)}…` : word));
    const rest = ignored.length > words.length ? " and more" : "";
    this.viewer.notices.announce(`Ignored in the URL: ${words.join(", ")}${rest}.`, true);
  }

  private rememberSoon(): void {
    clearTimeout(this.timer);
    this.timer = window.setTimeout(() => (this.isDragging ? this.rememberSoon() : this.remember()), 300);
  }

  // A change of dataset or isovalue adds a history entry; other changes replace it.
  private remember(): void {
    const now = this.addressed();
    const step = `${now.dataset} ${now.isovalue}`;
    const isStep = this.remembered !== null && this.remembered !== step;
    this.remembered = step;
    const address = `#${toAddress(now)}`;
    if (isStep) history.pushState(null, "", address);
    else history.replaceState(null, "", address);
  }
}
