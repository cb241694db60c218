// Tooltips for elements with data-tip, on hover and keyboard focus; one at a time.
import { h } from "../shared/elements";

export function installTooltips(): void {
  const tip = h("div", { class: "tooltip", role: "tooltip", id: "tooltip" });
  document.body.append(tip);
  let owner: Element | null = null;
  let timer = 0;
  const hide = () => {
    clearTimeout(timer);
    owner?.removeAttribute("aria-describedby");
    owner = null;
    tip.classList.remove("is-visible");
  };
  const showFor = (element: Element) => {
    tip.textContent = element.getAttribute("data-tip");
    element.setAttribute("aria-describedby", tip.id);
    const box = element.getBoundingClientRect();
    const { offsetWidth: width, offsetHeight: height } = tip;
    const left = Math.min(Math.max(8, box.left), window.innerWidth - width - 8);
    const isAbove = box.bottom + height + 12 > window.innerHeight;
    tip.style.left = `${left}px`;
    tip.style.top = `${isAbove ? box.top - height - 6 : box.bottom + 6}px`;
    tip.classList.add("is-visible");
  };
  const consider = (event: Event, delay: number) => {
    const element = (event.target as Element).closest?.("[data-tip]") ?? null;
    if (element === owner) return;
    hide();
    if (!element) return;
    owner = element;
    timer = window.setTimeout(() => showFor(element), delay);
  };
  document.addEventListener("pointerover", (event) => {
    // No tooltips while dragging.
    if (event.pointerType === "mouse" && event.buttons === 0) consider(event, 450);
  });
  document.addEventListener("focusin", (event) => {
    if ((event.target as Element).matches(":focus-visible")) consider(event, 450);
  });
  document.addEventListener("pointerdown", hide);
  document.addEventListener("focusout", hide);
  document.addEventListener("keydown", (event) => event.key === "Escape" && hide());
}
