// A number that one types; what is half written is left alone.
import { h } from "../shared/elements";
import type { Control } from "./inputs";

// `emptied` hears when nothing is left, where that means something.
export function numberInput(label: string, entered: (value: number) => void, emptied?: () => void): Control<number | null> {
  const element = h("input", { type: "number", step: "any", "aria-label": label, class: "number" });
  let isTyping = false;
  element.addEventListener("input", () => (isTyping = true));
  element.addEventListener("change", () => {
    isTyping = false;
    if (Number.isFinite(element.valueAsNumber)) entered(element.valueAsNumber);
    else if (element.value === "") emptied?.();
  });
  return {
    element,
    show: (value) => {
      if (document.activeElement !== element) isTyping = false;
      if (!isTyping) element.value = value === null ? "" : String(value);
    },
  };
}
