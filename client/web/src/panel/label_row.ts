// One label of the table: color, name, size, opacity and visibility.
import type { Label } from "../protocol/messages";
import { h } from "../shared/elements";
import { grouped } from "../shared/quantities";
import type { Progress } from "../state/progress";
import { labelName } from "../state/series";
import { maxNoteLength, type SurfaceSettings } from "../state/settings";

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
  const color = h("input", { type: "color" });
  color.addEventListener("input", () => change({ color: color.value }));
  const name = h("button", {
    type: "button",
    class: "label-name",
    "aria-pressed": "false",
    "data-tip": "Zooms to the label. Ctrl or Shift: selects several, which are then changed together. Double-click or F2: rename.",
  });
  name.addEventListener("click", click);
  name.addEventListener("dblclick", () => editName(name, rename));
  name.addEventListener("keydown", ({ key }) => key === "F2" && editName(name, rename));
  const opacity = opacitySlider("", (value) => change({ opacity: value }));
  const eye = h("button", { type: "button", class: "eye" });
  const only = h("button", { type: "button", class: "only", "data-tip": "Shows only this label, or the selected ones." }, "only");
  let isVisible = true;
  eye.addEventListener("click", () => change({ visible: !isVisible }));
  const element = h("li", { class: "label-row" }, eye, color, name, only, opacity);
  only.addEventListener("click", isolate);
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
        eye.setAttribute("aria-label", `Show ${word}`);
        color.setAttribute("aria-label", `Color of ${word}`);
        only.setAttribute("aria-label", `Show only ${word}`);
        opacity.setAttribute("aria-label", `Opacity of ${word}`);
      }
      color.value = surface.color;
      eye.setAttribute("aria-pressed", String(isVisible));
      eye.textContent = isVisible ? "◉" : "○";
      showOpacity(opacity, surface.opacity);
    },
  };
}

// Replaces the name by an input; an empty input restores the file's name.
function editName(name: HTMLElement, rename: (name: string) => void): void {
  const input = h("input", { type: "text", class: "label-rename", maxlength: String(maxNoteLength), "aria-label": `Name of ${name.textContent}` });
  input.value = name.textContent ?? "";
  let hasEnded = false; // Removing an input also blurs it.
  const end = (isTaken: boolean) => {
    if (hasEnded) return;
    hasEnded = true;
    const given = input.value.trim();
    input.replaceWith(name);
    if (isTaken && given !== name.textContent) rename(given);
  };
  input.addEventListener("blur", () => end(true));
  input.addEventListener("keydown", (event) => {
    event.stopPropagation(); // Typed letters must not trigger shortcuts.
    if (event.key === "Enter" || event.key === "Escape") end(event.key === "Enter");
  });
  name.replaceWith(input);
  input.select();
}

export function opacitySlider(what: string, turned: (value: number) => void): HTMLInputElement {
  const input = h("input", { type: "range", min: "0", max: "1", step: "0.01", "aria-label": `Opacity of ${what}` });
  input.setAttribute("data-tip", "The opacity of the surface.");
  input.addEventListener("input", () => turned(Number(input.value)));
  return input;
}

// `isMixed`: surfaces with different opacities; the slider shows the largest.
export function showOpacity(input: HTMLInputElement, opacity: number, isMixed = false): void {
  input.value = String(opacity);
  input.setAttribute("aria-valuetext", isMixed ? "mixed" : `${Math.round(100 * opacity)} %`);
  input.style.setProperty("--share", `${100 * opacity}%`);
}
