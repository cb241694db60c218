// One line about the shown surfaces and the progress, starting with the error. The certificate has the details.
// Progress is that of the first visible surface, totals are of all; the state is complete only when all are.

import { button, h } from "../shared/elements";
import { grouped, inBytes, inSeconds } from "../shared/quantities";
import type { DrawnSurface, SurfacesStatus } from "../state/progress";
import { accuracyInUnits, certificateOf, certificateSummary, errorExplanation, errorSummary, isEmpty, leastAccurate, trianglesOf } from "./certificate";
import { isFullResolution } from "./expected_text";

// A value with its name below; the elements stay while the text changes.
class Fact {
  private readonly value = h("b");
  private readonly label = h("span");
  readonly element: HTMLElement;

  constructor(name: string, tip: string) {
    this.element = h("span", { class: `fact ${name}`, "data-tip": tip }, this.value, this.label);
  }

  show(value: string | null, label: string, tip?: string): void {
    this.element.hidden = value === null;
    if (this.value.textContent !== (value ?? "")) this.value.textContent = value;
    if (this.label.textContent !== label) this.label.textContent = label;
    if (tip) this.element.setAttribute("data-tip", tip);
  }
}

function waitsForOthers({ progress, done, visible }: SurfacesStatus): boolean {
  const isDone = progress.shown?.isFinal === true && !progress.isStreaming;
  return isDone && progress.phase === "ready" && done < visible;
}

// "about 3 s left" of a step, extrapolated from the tiles received; empty in the first second and without tiles.
export function timeLeft(milliseconds: number, received: number, toCome: number): string {
  if (milliseconds < 1000 || received === 0 || received >= toCome) return "";
  const seconds = (milliseconds * (toCome - received)) / received / 1000;
  if (seconds > 90) return `about ${Math.round(seconds / 60)} min left`;
  return `about ${Math.max(1, Math.round(seconds))} s left`;
}

export class StatusBar {
  readonly element: HTMLElement;
  private readonly meter = h("div", { class: "meter" });
  private readonly state = new Fact(
    "state",
    "The surface arrives in steps, each complete and without cracks; a step replaces the previous one " + "when all of its tiles have arrived.",
  );
  private readonly triangles = new Fact("triangles", "Of all surfaces shown.");
  private readonly error = new Fact("error", "");
  private readonly bytes = new Fact("bytes", "");
  private readonly firstTile = new Fact("first-tile", "From the request to the first tile.");
  private readonly complete = new Fact("complete", "From the request until its final surface was checked and displayed.");
  private readonly certificateButton = button("", () => this.open(this.certificate.hidden), {
    class: "seal",
    hidden: true,
    "aria-expanded": "false",
    "aria-controls": "certificate",
    "data-tip": "Checks of the surface by this page. Click for details.",
  });
  private readonly certificates = h("div");
  private readonly certificate = h("div", { class: "certificate", id: "certificate", hidden: true, tabindex: "0" });
  private certified: DrawnSurface[] = [];
  private stepBegan = { step: -1, toCome: -1, at: 0 }; // The step being received, and performance.now() of its beginning.
  // For screen readers: steps, not tiles.
  private readonly spoken = h("span", { class: "spoken", role: "status" });

  // `isOfFiles`: there is no server.
  constructor(private readonly isOfFiles = false) {
    const came = [this.bytes, this.firstTile, this.complete].map(({ element }) => element);
    this.certificate.append(this.certificates, h("h2", { class: "is-promise" }, "How it was received"), h("div", { class: "came" }, ...came));
    const facts = [this.state, this.error, this.triangles];
    this.element = h(
      "footer",
      { class: "bar" },
      this.meter,
      this.certificate,
      h("div", { class: "facts", role: "group", "aria-label": "The surface in numbers", tabindex: "0" }, ...facts.map(({ element }) => element)),
      this.spoken,
      this.certificateButton,
    );
  }

  // Closes the certificate; returns false if it was not open.
  closeCertificate(): boolean {
    if (this.certificate.hidden) return false;
    const hadKeyboard = this.certificate.contains(document.activeElement);
    this.open(false);
    if (hadKeyboard) this.certificateButton.focus();
    return true;
  }

  private open(isOpen: boolean): void {
    this.certificate.hidden = !isOpen;
    this.certificateButton.setAttribute("aria-expanded", String(isOpen));
  }

  show(status: SurfacesStatus): void {
    const { progress, drawn } = status;
    const { isStreaming, tilesReceived, tilesToCome, shareRead } = progress;
    const share = isStreaming && shareRead > 0 ? shareRead : tilesToCome > 0 ? tilesReceived / tilesToCome : isStreaming ? 0 : 1;
    this.meter.style.setProperty("--share", String(share));
    this.meter.classList.toggle("is-active", isStreaming || waitsForOthers(status));
    this.showState(status);
    this.showTriangles(status);
    const coarsest = leastAccurate(drawn);
    const accuracy = coarsest && accuracyInUnits(coarsest);
    this.error.show(
      accuracy && accuracy.value,
      accuracy?.label ?? "",
      coarsest ? (drawn.length > 1 ? "Of the coarsest surface. " : "") + errorExplanation(coarsest) : undefined,
    );
    const [bytes, tiles, heldTiles] = (["bytes", "tiles", "heldTiles"] as const).map((what) => drawn.reduce((sum, { shown }) => sum + shown[what], 0));
    this.bytes.show(
      coarsest && inBytes(bytes),
      `in ${grouped(tiles)} ${tiles === 1 ? "tile" : "tiles"}`,
      `${this.isOfFiles ? "Size of the samples, unpacked," : "Compressed size"} of what is shown. ${grouped(heldTiles)} of its tiles were cached. ` +
        `${inBytes(progress.bytesReceived)} were received for the last request${drawn.length > 1 ? " of the first surface" : ""}.`,
    );
    const { firstTile, complete } = progress;
    const isAlone = drawn.length === 1;
    this.firstTile.show(isAlone && firstTile !== null ? inSeconds(firstTile) : null, "first tile");
    this.complete.show(isAlone && complete !== null ? inSeconds(complete) : null, "all shown");
    this.showCertificate(drawn.filter(({ shown }) => !isEmpty(shown)));
  }

  private showState(status: SurfacesStatus): void {
    const { progress, drawn, done, visible } = status;
    const { shown, isStreaming, step, tilesReceived, tilesToCome } = progress;
    const timeLeft = this.timeLeft(status);
    if (waitsForOthers(status)) {
      this.say(`${done} of ${visible}`, "surfaces complete");
      return;
    }
    if (visible === 0 && progress.phase === "ready") return this.say("Hidden", "no surface is visible");
    const atRest = shown ? (!shown.isFinal ? "Preview" : isEmpty(shown) ? "No surface" : "Complete") : "Waiting";
    if (!isStreaming) return this.say(progress.phase === "ready" ? atRest : "Not connected", shown ? errorSummary(drawn) || `step ${shown.step + 1}` : "");
    const isFirst = progress.firstSurface === null;
    const share = `${Math.round((100 * tilesReceived) / Math.max(1, tilesToCome))} %`;
    const read = progress.shareRead > 0 ? `${Math.round(100 * progress.shareRead)} % of the samples read` : "";
    const tiles = read
      ? read
      : tilesToCome > 0
        ? timeLeft
          ? `${share}, ${timeLeft}`
          : `${share} of step ${step + 1}`
        : `waiting for the ${this.isOfFiles ? "file" : "server"}`;
    // Until the first step of the new surface, the previous surface is shown, and the badge applies to it.
    this.say(
      !isFirst ? "Refining…" : drawn.length > 0 ? "Updating…" : "First preview…",
      tiles,
      `${isFirst ? "The first preview" : `Step ${step + 1}`} is loading`,
    );
  }

  private timeLeft({ progress: { isStreaming, step, tilesReceived, tilesToCome } }: SurfacesStatus): string {
    const now = performance.now();
    if (!isStreaming || step !== this.stepBegan.step || tilesToCome !== this.stepBegan.toCome) {
      this.stepBegan = { step: isStreaming ? step : -1, toCome: tilesToCome, at: now };
    }
    return timeLeft(now - this.stepBegan.at, tilesReceived, tilesToCome);
  }

  private say(word: string, label: string, aloud = `${word} ${label}`): void {
    this.state.show(word, label);
    if (this.spoken.textContent !== aloud) this.spoken.textContent = aloud;
  }

  private showTriangles({ progress, drawn }: SurfacesStatus): void {
    const triangles = drawn.reduce((sum, surface) => sum + trianglesOf(surface), 0);
    const isFull = drawn.length === 1 && isFullResolution(drawn[0].shown);
    const label = drawn.length > 1 ? `triangles of ${drawn.length} surfaces` : isFull ? "triangles, not simplified" : "triangles";
    this.triangles.show(progress.shown && grouped(triangles), label);
  }

  private showCertificate(drawn: DrawnSurface[]): void {
    this.certificateButton.hidden = drawn.length === 0;
    if (drawn.length === 0) this.open(false);
    const isKnown =
      drawn.length === this.certified.length &&
      drawn.every(({ number, shown, components }, at) => {
        const known = this.certified[at];
        return number === known.number && shown === known.shown && components === known.components;
      });
    if (isKnown || drawn.length === 0) return;
    this.certified = drawn;
    this.certificateButton.textContent = certificateSummary(drawn);
    this.certificateButton.classList.toggle(
      "is-quiet",
      drawn.every(({ components }) => components?.shown === 0),
    );
    this.certificates.replaceChildren(...certificateOf(drawn, this.isOfFiles));
  }
}
