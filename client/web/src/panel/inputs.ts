// The controls of the panel, each with a label and an explanation.
import { h } from "../shared/elements";

export interface Control<T> {
  element: HTMLElement;
  show: (value: T) => void;
}

export interface SliderOptions {
  label: string;
  tip: string;
  min: number;
  max: number;
  step: number;
  text: (value: number) => string;
  toPosition?: (value: number) => number;
  fromPosition?: (position: number) => number;
  onChange: (value: number, isDragging: boolean) => void;
}

// A slider with a readout; `moved` is called for every position, with `isDragging` until release.
export function slider(options: SliderOptions): Control<number> {
  const toPosition = options.toPosition ?? ((value) => value);
  const fromPosition = options.fromPosition ?? ((position) => position);
  const input = h("input", {
    type: "range",
    min: String(options.min),
    max: String(options.max),
    step: String(options.step),
    "aria-label": options.label,
  });
  const readout = h("output");
  // Screen readers announce the displayed value, not the slider's position.
  const say = (value: number) => {
    const text = options.text(value);
    readout.textContent = text;
    input.setAttribute("aria-valuetext", text);
  };
  const notify = (isDragging: boolean) => {
    const value = fromPosition(Number(input.value));
    say(value);
    options.onChange(value, isDragging);
  };
  input.addEventListener("input", () => notify(true));
  input.addEventListener("change", () => notify(false));
  const element = h("label", { class: "control", "data-tip": options.tip }, h("span", { class: "control-head" }, h("span", {}, options.label), readout), input);
  return {
    element,
    show: (value) => {
      if (document.activeElement !== input || Number(input.value) !== toPosition(value)) {
        input.value = String(toPosition(value));
      }
      say(value);
      const share = (toPosition(value) - options.min) / (options.max - options.min);
      input.style.setProperty("--share", `${100 * Math.min(1, Math.max(0, share))}%`);
    },
  };
}

export interface ChoiceOptions<T extends string> {
  label: string;
  tip: string;
  choices: readonly (readonly [T, string, string?])[]; // Value, word and optional explanation.
  onChange: (value: T) => void;
}

// A choice between a few words.
export function choice<T extends string>(options: ChoiceOptions<T>): Control<T> {
  const buttons = options.choices.map(([value, word, tip]) => {
    const button = h("button", { type: "button", role: "radio", "aria-checked": "false" }, word);
    if (tip) button.setAttribute("data-tip", tip);
    button.addEventListener("click", () => options.onChange(value));
    button.addEventListener("keydown", (event) => {
      const step = { ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1 }[event.key];
      if (!step) return;
      event.preventDefault();
      event.stopPropagation();
      const at = options.choices.findIndex(([other]) => other === value);
      const next = (at + step + buttons.length) % buttons.length;
      buttons[next].focus();
      options.onChange(options.choices[next][0]);
    });
    return button;
  });
  const element = h(
    "div",
    { class: "control", role: "radiogroup", "aria-label": options.label },
    h("span", { class: "control-head", "data-tip": options.tip }, h("span", {}, options.label)),
    h("div", { class: "choice" }, ...buttons),
  );
  return {
    element,
    show: (value) =>
      options.choices.forEach(([word], i) => {
        buttons[i].setAttribute("aria-checked", String(word === value));
        buttons[i].tabIndex = word === value ? 0 : -1;
      }),
  };
}

export interface ToggleOptions {
  label: string;
  tip: string;
  onChange: (isOn: boolean) => void;
}

export function toggle(options: ToggleOptions): Control<boolean> {
  const input = h("input", { type: "checkbox", role: "switch" });
  input.addEventListener("change", () => options.onChange(input.checked));
  const element = h("label", { class: "control toggle", "data-tip": options.tip }, h("span", {}, options.label), input);
  return { element, show: (isOn) => (input.checked = isOn) };
}

export function section(title: string, ...children: HTMLElement[]): HTMLElement {
  return h("section", {}, h("h2", {}, title), ...children);
}

export function foldedSection(title: string, isOpen: boolean, ...children: HTMLElement[]): HTMLElement {
  return h("details", isOpen ? { open: true } : {}, h("summary", {}, title), ...children);
}
