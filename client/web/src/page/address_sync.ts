// Synchronizes settings and the page's address: changed settings appear in the address, edits of it are applied, and
// the browser's "Back" reverts a change of dataset or isovalue.

import { withShortLabels } from "../state/label_surfaces";
import { findByName } from "../state/series";
import { defaults, type Settings } from "../state/settings";
import { afterEdit, ignoredParts, toAddress } from "../state/url_state";
import { fromWritten, written } from "../state/written_settings";
import { coordinateResolution } from "../stream/dataset";
import type { Viewer } from "../viewer/viewer";
import { Token } from "./server_address";

export class AddressSync {
  private initialHash: string;
  private timer = 0;
  private historyStep: string | null = null; // Dataset and isovalues of the current history entry.
  private isDragging = false;

  constructor(
    private readonly viewer: Viewer,
    private readonly token: Token,
    hash: string,
  ) {
    this.initialHash = hash;
    viewer.on("settings", () => this.scheduleUpdate());
    viewer.on("dataset", () => {
      this.reportIgnored(this.initialHash);
      this.initialHash = "";
    });
    // The event has the edited address; the address itself may be replaced before the event arrives.
    window.addEventListener("hashchange", ({ newURL }) => this.applyAddress(new URL(newURL).hash));
    this.scheduleUpdate();
  }

  // The address is not updated while dragging.
  setDragging(isDragging: boolean): void {
    this.isDragging = isDragging;
  }

  // Returns the settings for the address, always with the dataset's name, and with labels in short form.
  settingsForAddress(): Settings {
    const now = this.viewer.get();
    const { info, queries } = this.viewer;
    return withShortLabels(queries.datasets.get().list ?? [], now.dataset || !info ? now : { ...now, dataset: info.name });
  }

  private addressOf(settings: Settings): string {
    const { info } = this.viewer;
    return toAddress(settings, info ? coordinateResolution(info) : 0);
  }

  // Called when the user has edited the address or followed a link to this page.
  applyAddress(hash: string): void {
    this.scheduleUpdate(); // Rewrites the address in canonical form, without the token.
    if (this.token.readFrom(hash)) this.viewer.surfaces.connect();
    Token.hide();
    this.historyStep = null; // The browser has already made a history entry.
    if (hash.slice(1) === this.addressOf(this.settingsForAddress())) return;
    const { dataset, ...now } = afterEdit(written(this.viewer.get()), hash);
    const { list } = this.viewer.queries.datasets.get();
    this.viewer.set({ ...fromWritten(defaults, now), dataset: dataset || this.settingsForAddress().dataset });
    const isUnknown = dataset !== "" && list !== null && findByName(list, dataset) === null;
    if (!isUnknown) this.reportIgnored(hash);
  }

  private reportIgnored(hash: string): void {
    const ignored = ignoredParts(hash);
    if (ignored.length === 0) return;
    const words = ignored.slice(0, 3).map((word) => (word.length > 40 ? `${word.slice(0, 39)}…` : word));
    const rest = ignored.length > words.length ? " and more" : "";
    this.viewer.notices.announce(`Ignored in the URL: ${words.join(", ")}${rest}.`, true);
  }

  private scheduleUpdate(): void {
    clearTimeout(this.timer);
    this.timer = window.setTimeout(() => (this.isDragging ? this.scheduleUpdate() : this.updateAddress()), 300);
  }

  // A change of dataset or isovalue adds a history entry; other changes replace it.
  private updateAddress(): void {
    const now = this.settingsForAddress();
    const step = [now.dataset, ...now.surfaces.map(({ isovalue }) => isovalue)].join(" ");
    const isStep = this.historyStep !== null && this.historyStep !== step;
    this.historyStep = step;
    const address = `#${this.addressOf(now)}`;
    if (isStep) history.pushState(null, "", address);
    else history.replaceState(null, "", address);
  }
}
