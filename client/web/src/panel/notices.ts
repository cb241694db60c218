// What a user must know: a lost connection, a refused request, a failed check.
import type { Progress } from "../state/progress";
import { h } from "./dom";

export class Notices {
  readonly element = h("div", { class: "notice", role: "alert", hidden: true });
  private own: string | null = null;
  private timer = 0;
  private countdown = 0;
  private progress: Progress | null = null;

  constructor(private readonly connectNow: () => void) {}

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
    if (text) {
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
}
