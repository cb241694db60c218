// What a user must know: a lost connection, a refused request, a failed check, a surface too large to
// be sent unasked.
import type { Progress } from "../state/progress";
import { h, inBytes, inTriangles } from "./dom";

export interface NoticeActs {
  connectNow: () => void;
  useToken: (token: string) => void;
  insist: () => void; // On the surface that was held back.
}

export class Notices {
  readonly element = h("div", { class: "notice", role: "alert", hidden: true });
  private own: string | null = null;
  private timer = 0;
  private countdown = 0;
  private progress: Progress | null = null;
  private kind = ""; // Of what the element holds; its parts stay while that is the same.
  private readonly seconds = h("span", { "aria-hidden": "true" }); // Not said aloud twice a second.
  private readonly words = h("span");

  constructor(private readonly acts: NoticeActs) {}

  // Stays until clear(), or for some seconds.
  tell(text: string, isPassing = false): void {
    this.own = text;
    clearTimeout(this.timer);
    if (isPassing) this.timer = window.setTimeout(() => this.clear(), 4000);
    this.draw();
  }

  clear(): void {
    this.own = null;
    this.draw();
  }

  show(progress: Progress): void {
    this.progress = progress;
    this.draw();
  }

  private draw(): void {
    clearTimeout(this.countdown);
    const { progress } = this;
    const trouble = progress?.trouble;
    const isLost = progress?.phase === "lost";
    this.element.classList.toggle("is-trouble", isLost || Boolean(trouble));
    if (trouble?.needsToken) {
      this.hold("token", () => [this.tokenForm()]);
    } else if (isLost && !trouble?.isFatal) {
      this.drawLost(progress);
    } else if (trouble || this.own) {
      this.words.textContent = trouble?.text ?? this.own;
      this.hold("words", () => [this.words]);
    } else if (progress?.heldBack) {
      const { triangles, bytes } = progress.heldBack;
      this.words.textContent =
        `All of it has about ${inTriangles(triangles)} (${inBytes(bytes)}); this is the best with ` +
        "fewer. ";
      this.hold("size", () => [this.words, button("Show all of it", this.acts.insist)]);
    } else {
      this.hold("", () => []);
    }
  }

  private drawLost(progress: Progress): void {
    const seconds = Math.max(0, Math.ceil((progress.retryAt - performance.now()) / 1000));
    this.seconds.textContent = seconds > 0 ? `Trying again in ${seconds} s… ` : "Trying again… ";
    this.words.textContent = progress.shown
      ? "What you see stays; the rest follows. "
      : "Is the server running? ";
    this.hold("lost", () => [
      h("b", {}, "No connection to the server. "),
      this.words,
      this.seconds,
      button("Try now", this.acts.connectNow),
    ]);
    this.countdown = window.setTimeout(() => this.draw(), 500);
  }

  private hold(kind: string, parts: () => Node[]): void {
    this.element.hidden = kind === "";
    if (kind === this.kind) return;
    this.kind = kind;
    this.element.replaceChildren(...parts());
  }

  private tokenForm(): HTMLElement {
    const input = h("input", { type: "password", "aria-label": "Token", autocomplete: "off" });
    const form = h("form", {}, h("b", {}, "This server asks for a token. "), input,
      h("button", { type: "submit" }, "Connect"));
    form.addEventListener("submit", (event) => {
      event.preventDefault();
      this.acts.useToken(input.value);
    });
    return form;
  }
}

function button(word: string, act: () => void): HTMLElement {
  const element = h("button", { type: "button" }, word);
  element.addEventListener("click", act);
  return element;
}
