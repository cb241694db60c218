// What a user must know: a lost connection, a refused request, a failed check.
import type { Progress } from "../state/progress";
import { h } from "./dom";

export class Notices {
  readonly element = h("div", { class: "notice", role: "alert", hidden: true });
  private own: string | null = null;
  private timer = 0;
  private countdown = 0;
  private progress: Progress | null = null;

  constructor(
    private readonly connectNow: () => void,
    private readonly useToken: (token: string) => void,
  ) {}

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
    const isLost = progress?.phase === "lost";
    const trouble = progress?.trouble;
    const text = isLost && !trouble?.isFatal ? null : (trouble?.text ?? this.own);
    this.element.hidden = !isLost && !text;
    this.element.classList.toggle("is-trouble", isLost || Boolean(trouble));
    if (trouble?.needsToken) {
      if (!this.element.querySelector("form")) this.element.replaceChildren(this.tokenForm());
    } else if (text) {
      this.element.replaceChildren(text);
    } else if (isLost) {
      const seconds = Math.max(0, Math.ceil((progress.retryAt - performance.now()) / 1000));
      const again = h("button", { type: "button" }, "Try now");
      again.addEventListener("click", this.connectNow);
      const what = progress.shown ? "What you see stays; the rest follows." : "Is the server running?";
      this.element.replaceChildren(
        h("b", {}, "No connection to the server. "),
        `${what} Trying again${seconds > 0 ? ` in ${seconds} s` : ""}… `,
        again,
      );
      this.countdown = window.setTimeout(() => this.draw(), 500);
    }
  }

  private tokenForm(): HTMLElement {
    const input = h("input", { type: "password", "aria-label": "Token", autocomplete: "off" });
    const form = h("form", {}, h("b", {}, "This server asks for a token. "), input,
      h("button", { type: "submit" }, "Connect"));
    form.addEventListener("submit", (event) => {
      event.preventDefault();
      this.useToken(input.value);
    });
    return form;
  }
}
