// The isovalue: a line in the histogram that one drags, a number, and values worth a look.
import type { DatasetInfo } from "../protocol/messages";
import { forever } from "../state/remembered";
import { suggestedIsovalue } from "../stream/request";
import { h, inDigits } from "./dom";
import { HistogramView } from "./histogram";
import { toggle } from "./inputs";
import type { Change, Part } from "./part";

export function isovaluePart(change: Change): Part & { histogram: HistogramView } {
  const hasDragged = forever.get("hasDragged") !== null; // Once is enough.
  const hint = h("p", { class: "hint", hidden: hasDragged },
    "Drag the line: the surface runs where the data has this value.");
  const histogram = new HistogramView({
    moved: (isovalue, isDragging) => {
      hint.classList.add("is-read");
      histogram.invite(false);
      forever.set("hasDragged", "yes");
      change({ isovalue }, isDragging);
    },
  });
  histogram.invite(!hasDragged);
  const input = h("input", { type: "number", step: "any", "aria-label": "Isovalue", class: "number" });
  let isTyping = false; // What is half written is left alone.
  input.addEventListener("input", () => (isTyping = true));
  input.addEventListener("change", () => {
    isTyping = false;
    if (Number.isFinite(input.valueAsNumber)) change({ isovalue: input.valueAsNumber });
  });
  const log = toggle({
    label: "log", tip: "Logarithmic heights: rare values become visible.",
    turned: (logScale) => change({ logScale }),
  });
  const chips = h("div", { class: "chips", role: "group", "aria-label": "Isovalues worth a look" });
  let info: DatasetInfo | null = null;
  const chip = (value: number) => {
    const button = h("button", { type: "button", "data-tip": "A value that parts the data well." },
      inDigits(value));
    button.dataset.value = String(value);
    button.addEventListener("click", () => change({ isovalue: value }));
    return button;
  };
  return {
    histogram,
    elements: [
      h("div", { class: "section-head" }, h("h2", {}, "Isovalue"), input, log.element),
      histogram.element, chips, hint,
    ],
    show: (settings, shown) => {
      log.show(settings.logScale);
      if (!shown) return;
      if (shown !== info) {
        const values = shown.suggestedIsovalues.slice(0, 5).sort((a, b) => a - b);
        chips.replaceChildren(...(values.length > 1 ? values.map(chip) : []));
      }
      info = shown;
      const isovalue = settings.isovalue ?? suggestedIsovalue(shown);
      histogram.show(shown, isovalue, settings.logScale);
      for (const button of chips.querySelectorAll("button")) {
        button.setAttribute("aria-pressed", String(Number(button.dataset.value) === isovalue));
      }
      if (document.activeElement !== input) isTyping = false;
      if (!isTyping) input.value = String(isovalue);
    },
  };
}
