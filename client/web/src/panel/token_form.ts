// A form for the server's token, with the server's error. The input stays until the server accepts it.
import { h } from "../shared/elements";

export class TokenForm {
  readonly element: HTMLFormElement;
  private readonly input = h("input", {
    type: "password",
    placeholder: "Token",
    "aria-label": "Token",
    "aria-describedby": "token-words",
    autocomplete: "off",
    spellcheck: "false",
    required: true,
  });
  private readonly send = h("button", { type: "submit" }, "Connect");
  private readonly words = h("p", { id: "token-words" });
  private isWaiting = false;
  private wasSent = false;

  constructor(useToken: (token: string) => void) {
    this.element = h("form", {}, this.words, this.input, this.send);
    this.element.addEventListener("submit", (event) => {
      event.preventDefault();
      if (this.isWaiting) return;
      this.wasSent = true;
      useToken(this.input.value.trim());
    });
  }

  // Call when the token was sent and the server has not replied.
  wait(): void {
    this.isWaiting = true;
    this.send.textContent = "Connecting…";
  }

  // Call when the server has rejected the token.
  showError(text: string): void {
    this.send.textContent = "Connect";
    this.words.textContent = text;
    this.input.setAttribute("aria-invalid", String(this.wasSent));
    if (this.isWaiting) this.input.select();
    this.isWaiting = false;
  }

  focus(): void {
    this.input.focus();
  }
}
