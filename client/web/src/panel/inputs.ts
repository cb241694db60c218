// The controls of the panel, each with a label and an explanation.
import { button, h } from "../shared/elements";

export interface Control<T> {
  element: HTMLElement;
  show: (value: T) => void;
}

export interface SliderOptions {
  min: number;
  max: number;
  step: number;
  text: (value: number) => string;
  toPosition?: (value: number) => number;
  fromPosition?: (position: number) => number;
}

// A slider with a readout; `onChange` is called for every position, with `isDragging` until release.
export function slider(label: string, tip: string, options: SliderOptions, onChange: (value: number, isDragging: boolean) => void): Control<number> {
  const toPosition = options.toPosition ?? ((value) => value);
  const fromPosition = options.fromPosition ?? ((position) => position);
  const input = h("input", {
    type: "range",
    min: String(options.min),
    max: String(options.max),
    step: String(options.step),
    "aria-label": label,
    input: () => notify(true),
    change: () => notify(false),
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
    onChange(value, isDragging);
  };
  const element = h("label", { class: "control", "data-tip": tip }, h("span", { class: "control-head" }, h("span", {}, label), readout), input);
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

// The word of each value, and optionally an explanation.
export type Choices<T extends string> = Readonly<Record<T, string | readonly [word: string, tip: string]>>;

// A choice between a few words.
export function choice<T extends string>(label: string, tip: string, choices: Choices<T>, onChange: (value: T) => void): Control<T> {
  const values = Object.keys(choices) as T[];
  const buttons = values.map((value, at) => {
    const [word, ownTip] = [choices[value]].flat();
    const keydown = (event: KeyboardEvent) => {
      const step = { ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1 }[event.key];
      if (!step) return;
      event.preventDefault();
      event.stopPropagation();
      const next = (at + step + buttons.length) % buttons.length;
      buttons[next].focus();
      onChange(values[next]);
    };
    return button(word, () => onChange(value), { role: "radio", "aria-checked": "false", keydown, ...(ownTip && { "data-tip": ownTip }) });
  });
  const element = h(
    "div",
    { class: "control", role: "radiogroup", "aria-label": label },
    h("span", { class: "control-head", "data-tip": tip }, h("span", {}, label)),
    h("div", { class: "choice" }, ...buttons),
  );
  return {
    element,
    show: (value) =>
      buttons.forEach((one, at) => {
        one.setAttribute("aria-checked", String(values[at] === value));
        one.tabIndex = values[at] === value ? 0 : -1;
      }),
  };
}

export function toggle(label: string, tip: string, onChange: (isOn: boolean) => void): Control<boolean> {
  const input = h("input", { type: "checkbox", role: "switch", change: () => onChange(input.checked) });
  return { element: labeled(label, tip, input), show: (isOn) => (input.checked = isOn) };
}

export function colorInput(label: string, onChange: (color: string) => void): Control<string> {
  const element = h("input", { type: "color", "aria-label": label, input: () => onChange(element.value) });
  return { element, show: (color) => (element.value = color) };
}

// Shows or hides something.
export function eyeButton(onChange: (isVisible: boolean) => void): Control<boolean> {
  let isVisible = true;
  const element = button("", () => onChange(!isVisible), { class: "eye" });
  return {
    element,
    show: (isOn) => {
      isVisible = isOn;
      element.setAttribute("aria-pressed", String(isOn));
      element.textContent = isOn ? "◉" : "○";
    },
  };
}

export interface OpacitySlider extends Control<number> {
  show: (opacity: number, isMixed?: boolean) => void; // Mixed: of several surfaces; the slider shows the largest.
}

export function opacitySlider(of: string, onChange: (opacity: number) => void): OpacitySlider {
  const label = { "aria-label": `Opacity of ${of}`, "data-tip": "The opacity of the surface." };
  const element = h("input", { type: "range", min: "0", max: "1", step: "0.01", ...label, input: () => onChange(Number(element.value)) });
  return {
    element,
    show: (opacity, isMixed = false) => {
      element.value = String(opacity);
      element.setAttribute("aria-valuetext", isMixed ? "mixed" : `${Math.round(100 * opacity)} %`);
      element.style.setProperty("--share", `${100 * opacity}%`);
    },
  };
}

// A row of a label and its input.
export function labeled(label: string, tip: string, input: HTMLElement): HTMLElement {
  return h("label", { class: "control toggle", "data-tip": tip }, h("span", {}, label), input);
}

export function section(title: string, ...children: HTMLElement[]): HTMLElement {
  return h("section", {}, h("h2", {}, title), ...children);
}

export function foldedSection(title: string, isOpen: boolean, ...children: HTMLElement[]): HTMLElement {
  return h("details", isOpen ? { open: true } : {}, h("summary", {}, title), ...children);
}
