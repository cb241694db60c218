// A number input that is not overwritten while the user types.
import { h } from "../shared/elements";
import type { Control } from "./inputs";

// `emptied` is called when the input was cleared.
export function numberInput(label: string, entered: (value: number) => void, emptied?: () => void): Control<number | null> {
  let isTyping = false;
  const change = () => {
    isTyping = false;
    if (Number.isFinite(element.valueAsNumber)) entered(element.valueAsNumber);
    else if (element.value === "") emptied?.();
  };
  const element = h("input", { type: "number", step: "any", "aria-label": label, class: "number", input: () => (isTyping = true), change });
  return {
    element,
    show: (value) => {
      if (document.activeElement !== element) isTyping = false;
      if (!isTyping) element.value = value === null ? "" : String(value);
    },
  };
}
