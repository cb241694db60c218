// Settings and the page's address agree: what is turned is in the address, what is edited there is
// done, and the browser's "Back" takes back another dataset or isovalue.
import type { Token } from "./server_address";
import { named, shortened, startOf } from "./state/series";
import type { Settings } from "./state/settings";
import { edited, misread, toAddress } from "./state/url_state";
import type { Viewer } from "./viewer";

export class AddressKeeper {
  private initialOutput: string;
  private timer = 0;
  private remembered: string | null = null; // What "Back" would leave: dataset and isovalue of the address.
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
    // What was edited is in the event: the address itself may be replaced before the event arrives.
    window.addEventListener("hashchange", ({ newURL }) => this.useEdited(new URL(newURL).hash));
    this.rememberSoon();
  }

  // While something is dragged nothing is remembered.
  drags(isDragging: boolean): void {
    this.isDragging = isDragging;
  }

  // The settings as the address has them: with the dataset's name, also of the one shown unasked, and with many labels in few words.
  addressed(): Settings {
    const now = this.viewer.get();
    const { info, surfaces } = this.viewer;
    return shortened(surfaces.datasets.get().list ?? [], now.dataset || !info ? now : { ...now, dataset: info.name });
  }

  // The user has edited the address, or followed a link to this page.
  useEdited(hash: string): void {
    this.rememberSoon(); // As it is understood, without a token.
    if (this.token.takeFrom(hash)) this.viewer.surfaces.connect();
    this.remembered = null; // Where the browser is by now.
    if (hash.slice(1) === toAddress(this.addressed())) return;
    const { dataset, ...now } = edited(this.viewer.get(), hash);
    const { list } = this.viewer.surfaces.datasets.get();
    const isUnknown = dataset !== "" && list !== null && named(list, dataset) === null;
    const wanted = { ...now, dataset: dataset && !isUnknown ? dataset : this.addressed().dataset };
    const labels = list && wanted.labels ? startOf(list, wanted)?.changes : null; // At once: labels that stay are not loaded again.
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

  // Another dataset or isovalue is a step that the browser's "Back" takes back; all else is not.
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
