// Notices: a lost connection, a required token, a refused request, a failed check, a surface too large to be sent
// without confirmation.
//
// The focused element stays in the page while the reason is the same, even over failed attempts to connect. When the
// reason is resolved, focus moves to the scene.

import { button, h } from "../shared/elements";
import { inBytes, inTriangleRange } from "../shared/quantities";
import type { ServedProgress } from "../state/progress";
import { TokenForm } from "./token_form";

export interface NoticeActions {
  connectNow: () => void;
  useToken: (token: string) => void;
  confirmSize: () => void; // Requests the surface in full size.
  focusScene: () => void; // Moves the focus to the scene.
  showAgain?: () => void; // Begins again, where nothing can be drawn any more.
}

type Kind = "lost" | "later" | "token" | "words" | "size" | "blank" | "nothing";

export class Notices {
  readonly element = h("div", { class: "notice", role: "alert", hidden: true });
  private announced: string | null = null;
  private isTemporary = false;
  private timer = 0;
  private countdown = 0;
  private progress: ServedProgress | null = null;
  private empty: string | null = null;
  private blank: string | null = null;
  private kind: Kind = "nothing"; // The kind being shown; its elements are reused while it is the same.
  private readonly seconds = h("span", { "aria-hidden": "true" }); // Changes twice a second, so hidden from screen readers.
  private readonly words = h("span");
  private form: TokenForm | null = null;

  // `isElsewhere`: the page is not the server's own.
  constructor(
    private readonly actions: NoticeActions,
    private readonly isElsewhere = false,
  ) {}

  // Stays until clear(); a temporary notice stays as long as it takes to read, or until nothing is visible.
  announce(text: string, isTemporary = false): void {
    this.announced = text;
    this.isTemporary = isTemporary;
    clearTimeout(this.timer);
    if (isTemporary) this.timer = window.setTimeout(() => this.clear(), 2000 + 60 * text.length);
    this.draw();
  }

  clear(): void {
    this.announced = null;
    this.draw();
  }

  // `empty`: the reason if the surface has no triangles.
  show(progress: ServedProgress, empty: string | null): void {
    this.progress = progress;
    if (empty !== null && empty !== this.empty && this.isTemporary) this.announced = null;
    this.empty = empty;
    this.draw();
  }

  // Nothing can be drawn any more, for this reason.
  showBlank(text: string): void {
    this.blank = text;
    this.draw();
  }

  private draw(): void {
    clearTimeout(this.countdown);
    const { showAgain } = this.actions;
    this.element.classList.toggle("is-blank", this.blank !== null);
    if (this.blank !== null) {
      this.words.textContent = `${this.blank} `;
      return this.showKind("blank", () => (showAgain ? [this.words, button("Show it again", showAgain)] : [this.words]));
    }
    const { progress } = this;
    const failure = progress?.failure;
    const isTrying = progress?.phase === "connecting" || progress?.phase === "greeting";
    const isLost = progress?.phase === "lost" || (isTrying && this.kind === "lost");
    const isFailure = failure ? !failure.needsToken : isLost;
    this.element.classList.toggle("is-failure", isFailure);
    if (failure?.needsToken) {
      this.drawToken().showError(failure.text);
    } else if (isTrying && this.kind === "token") {
      this.drawToken().wait();
    } else if (isLost && !failure?.isFatal) {
      this.drawLost(progress!);
    } else if (failure || this.announced || this.empty) {
      this.words.textContent = failure?.text ?? this.announced ?? this.empty;
      this.showKind("words", () => [this.words]);
    } else if (progress?.postponed) {
      this.drawPostponed(progress.postponed);
    } else if (progress?.sizeToConfirm) {
      const { triangles, budget, bytes } = progress.sizeToConfirm;
      this.words.textContent = `The complete surface has ${inTriangleRange(triangles, budget)} (about ${inBytes(bytes)}); this is the finest surface with fewer. `;
      this.showKind("size", () => [this.words, button("Show the complete surface", this.actions.confirmSize)]);
    } else {
      this.showKind("nothing", () => []);
    }
  }

  private drawToken(): TokenForm {
    const form = (this.form ??= new TokenForm(this.actions.useToken));
    this.showKind("token", () => [form.element]);
    return form;
  }

  private drawPostponed({ text, until }: NonNullable<ServedProgress["postponed"]>): void {
    this.countDown("Retrying", until);
    this.words.textContent = `${text} `;
    this.showKind("later", () => [h("b", {}, "The server is busy. "), this.words, this.seconds]);
  }

  private countDown(doing: string, until: number): void {
    const seconds = Math.max(0, Math.ceil((until - performance.now()) / 1000));
    this.seconds.textContent = seconds > 0 ? `${doing} in ${seconds} s… ` : `${doing}… `;
    this.countdown = window.setTimeout(() => this.draw(), 500);
  }

  private drawLost(progress: ServedProgress): void {
    this.countDown("Retrying", progress.retryAt);
    const permission = this.isElsewhere ? ` and allows this page (--allow-origin ${location.origin})` : "";
    this.words.textContent = progress.shown ? "The picture stays; the missing parts follow. " : `Check that the server is running${permission}. `;
    this.showKind("lost", () => [h("b", {}, "No connection to the server. "), this.words, this.seconds, button("Try now", this.actions.connectNow)]);
  }

  private showKind(kind: Kind, parts: () => Node[]): void {
    if (kind === this.kind) return;
    const { activeElement } = document;
    const hadKeyboard = this.element.contains(activeElement);
    const isFree = activeElement === null || activeElement === document.body;
    this.kind = kind;
    this.element.hidden = kind === "nothing";
    this.element.replaceChildren(...parts());
    if (kind !== "token") this.form = null;
    if (this.form && (hadKeyboard || isFree)) this.form.focus();
    else if (hadKeyboard) this.actions.focusScene();
  }
}
