// One label of the table: color, name, size, opacity and visibility.
import type { Label } from "../protocol/messages";
import { button, h } from "../shared/elements";
import { grouped } from "../shared/quantities";
import type { Progress } from "../state/progress";
import { labelName } from "../state/series";
import { maxNoteLength, type SurfaceSettings } from "../state/settings";
import { colorInput, eyeButton, opacitySlider } from "./inputs";

export type LabelLook = Partial<Pick<SurfaceSettings, "color" | "opacity" | "visible">>;

export interface LabelRow {
  element: HTMLElement;
  name: HTMLElement; // Its button.
  show: (surface: SurfaceSettings, label: Label) => void;
  showProgress: (progress: Progress) => void;
  showSelected: (isSelected: boolean) => void;
}

export interface LabelRowEvents {
  change: (changes: LabelLook) => void;
  isolate: () => void;
  click: (event: MouseEvent) => void; // Called for clicks on the name.
  rename: (name: string) => void;
}

export function labelRow({ change, isolate, click, rename }: LabelRowEvents): LabelRow {
  const color = colorInput("", (value) => change({ color: value }));
  const name = h("button", {
    type: "button",
    class: "label-name",
    "aria-pressed": "false",
    "data-tip": "Zooms to the label. Ctrl or Shift: selects several, which are then changed together. Double-click or F2: rename.",
    click,
    dblclick: () => editName(name, rename),
    keydown: ({ key }: KeyboardEvent) => key === "F2" && editName(name, rename),
  });
  const opacity = opacitySlider("", (value) => change({ opacity: value }));
  const eye = eyeButton((visible) => change({ visible }));
  const only = button("only", isolate, { class: "only", "data-tip": "Shows only this label, or the selected ones." });
  let isVisible = true;
  const element = h("li", { class: "label-row" }, eye.element, color.element, name, only, opacity.element);
  let hasFinal = false;
  let size = "";
  let isComing = false;
  const showComing = () => {
    if (isComing !== (isComing = isVisible && !hasFinal)) element.classList.toggle("is-coming", isComing);
  };
  return {
    element,
    name,
    showSelected: (isSelected) => {
      if (element.classList.contains("is-selected") === isSelected) return;
      element.classList.toggle("is-selected", isSelected);
      name.setAttribute("aria-pressed", String(isSelected));
    },
    showProgress: ({ shown, isStreaming, failure }) => {
      hasFinal = failure !== null || (!isStreaming && shown?.isFinal === true);
      const title = failure?.text ?? size;
      if (name.title !== title) name.title = title;
      showComing();
    },
    show: (surface, label) => {
      const word = labelName(label);
      isVisible = surface.visible;
      showComing();
      if (name.textContent !== word) {
        name.textContent = element.dataset.label = word;
        size = name.title = label.samples > 0n ? `${word}: ${grouped(Number(label.samples))} samples` : word;
        eye.element.setAttribute("aria-label", `Show ${word}`);
        color.element.setAttribute("aria-label", `Color of ${word}`);
        only.setAttribute("aria-label", `Show only ${word}`);
        opacity.element.setAttribute("aria-label", `Opacity of ${word}`);
      }
      color.show(surface.color);
      eye.show(isVisible);
      opacity.show(surface.opacity);
    },
  };
}

// Replaces the name by an input; an empty input restores the file's name.
function editName(name: HTMLElement, rename: (name: string) => void): void {
  const keydown = (event: KeyboardEvent) => {
    event.stopPropagation(); // Typed letters must not trigger shortcuts.
    if (event.key === "Enter" || event.key === "Escape") end(event.key === "Enter");
  };
  const attributes = { type: "text", class: "label-rename", maxlength: String(maxNoteLength), "aria-label": `Name of ${name.textContent}` };
  const input = h("input", { ...attributes, blur: () => end(true), keydown });
  input.value = name.textContent ?? "";
  let hasEnded = false; // Removing an input also blurs it.
  const end = (isTaken: boolean) => {
    if (hasEnded) return;
    hasEnded = true;
    const given = input.value.trim();
    input.replaceWith(name);
    if (isTaken && given !== name.textContent) rename(given);
  };
  name.replaceWith(input);
  input.select();
}
