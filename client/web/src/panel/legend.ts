// The color legend over the scene, of a slice or of a field on the surfaces. Dragging horizontally changes the level
// and vertically the window, as in medical viewers; so do arrow keys, and a double click resets. The values of the
// first and last color can be typed.

import { scaleOf, windowOf } from "../samples/slices";
import { gradientOf, type LegendText } from "../shared/color_maps";
import { h } from "../shared/elements";
import { inDigits, roundedWithin } from "../shared/quantities";
import type { Settings } from "../state/settings";
import type { Control } from "./inputs";
import { numberInput } from "./number_input";

// The settings that a legend shows and changes.
export interface LegendNames {
  label: string;
  colors: "sliceColors" | "colors";
  level: "level" | "fieldLevel";
  width: "windowWidth" | "fieldWindow";
  isLog: "samplesLog" | "fieldLog";
}

// The range and unit of the values.
export interface LegendValues {
  min: number;
  max: number;
  valueUnit: string;
  usual?: { level: number; width: number }; // The default window; absent: all values.
}

interface Ends {
  low: number; // The value of the first color.
  high: number; // The value of the last color.
}

const keys: Record<string, [number, number]> = {
  ArrowLeft: [-1, 0],
  ArrowRight: [1, 0],
  ArrowUp: [0, 1],
  ArrowDown: [0, -1],
};

export class Legend {
  readonly element = h("div", { class: "legend", hidden: true, role: "group" });
  private readonly slider = h("div", {
    class: "legend-slider",
    tabindex: "0",
    role: "slider",
    "data-tip": "Drag sideways for the level, up and down for the window; a double click resets them.",
  });
  private readonly name = h("span", { class: "legend-name" });
  private readonly bar = h("div", { class: "legend-bar" });
  private readonly low: Control<number | null>;
  private readonly high: Control<number | null>;
  private readonly unit = h("span");
  private info: LegendValues | null = null;
  private settings: Settings | null = null;

  constructor(
    private readonly names: LegendNames,
    private readonly turn: (changes: Partial<Settings>, isDragging: boolean) => void,
  ) {
    this.element.setAttribute("aria-label", `Colors of ${names.label}`);
    this.slider.setAttribute("aria-label", `Window and level of ${names.label}`);
    this.low = this.endInput("first", (low, ends) => ({ ...ends, low }));
    this.high = this.endInput("last", (high, ends) => ({ ...ends, high }));
    this.slider.append(this.name, this.bar);
    this.element.append(this.slider, h("div", { class: "legend-ends" }, this.low.element, this.high.element, this.unit));
    this.listen();
  }

  // Null hides the legend. `name`: names the values.
  show(settings: Settings, info: LegendValues | null, name = ""): void {
    this.settings = settings;
    this.info = info;
    this.element.hidden = !info;
    if (!info) return;
    const { low, high, isLog } = this.scale(settings, info);
    const span = high - low;
    this.name.textContent = isLog ? `${name || "samples"}, logarithmic` : name;
    this.bar.style.background = gradientOf(settings[this.names.colors]);
    this.low.show(roundedWithin(low, span));
    this.high.show(roundedWithin(high, span));
    this.unit.textContent = info.valueUnit;
    this.slider.setAttribute("aria-valuemin", String(info.min));
    this.slider.setAttribute("aria-valuemax", String(info.max));
    this.slider.setAttribute("aria-valuenow", String((low + high) / 2));
    this.slider.setAttribute("aria-valuetext", `level ${roundedWithin((low + high) / 2, span)}, window ${inDigits(span)}`);
  }

  // Null: not shown.
  get words(): LegendText | null {
    const { settings, info } = this;
    if (this.element.hidden || !settings || !info) return null;
    const { low, high } = this.scale(settings, info);
    const [first, last] = [low, high].map((value) => String(roundedWithin(value, high - low)));
    const unit = info.valueUnit && ` ${info.valueUnit}`;
    return { map: settings[this.names.colors], name: this.name.textContent ?? "", low: first, high: last + unit };
  }

  // An input for the value of the first or last color. Rejects ends in the wrong order.
  private endInput(which: string, entered: (value: number, ends: Ends) => Ends): Control<number | null> {
    return numberInput(
      `Value of the ${which} color of ${this.names.label}`,
      (value) => {
        const { settings, info } = this;
        if (!settings || !info) return;
        const { low, high } = entered(value, this.scale(settings, info));
        if (low < high) this.turn({ [this.names.level]: (low + high) / 2, [this.names.width]: high - low }, false);
        else this.show(settings, info, this.name.textContent ?? "");
      },
      () => this.reset(),
    );
  }

  private scale(settings: Settings, info: LegendValues): Ends & { isLog: boolean } {
    return scaleOf(settings[this.names.level], settings[this.names.width], settings[this.names.isLog], info);
  }

  private reset(): void {
    this.turn({ [this.names.level]: null, [this.names.width]: null }, false);
  }

  private listen(): void {
    const { slider } = this;
    let last: { x: number; y: number } | null = null;
    slider.addEventListener("pointerdown", (event) => {
      if (event.button !== 0) return;
      slider.setPointerCapture(event.pointerId);
      last = { x: event.clientX, y: event.clientY };
    });
    slider.addEventListener("pointermove", (event) => {
      if (!last) return;
      this.move((event.clientX - last.x) / 250, (last.y - event.clientY) / 150, true);
      last = { x: event.clientX, y: event.clientY };
    });
    const end = () => {
      if (last) this.move(0, 0, false);
      last = null;
    };
    slider.addEventListener("pointerup", end);
    slider.addEventListener("pointercancel", end);
    slider.addEventListener("dblclick", () => this.reset());
    slider.addEventListener("keydown", (event) => {
      const step = keys[event.key];
      if (!step) return;
      event.preventDefault();
      event.stopPropagation();
      this.move(0.02 * step[0], 0.05 * step[1], false);
    });
  }

  // Moves the level by shares of the values, and scales the window by factors.
  private move(sideways: number, upwards: number, isDragging: boolean): void {
    const { info, settings } = this;
    if (!info || !settings) return;
    const { low, high } = windowOf(settings[this.names.level], settings[this.names.width], info);
    const all = (info.usual?.width ?? info.max - info.min) || 1;
    const level = Math.min(info.max, Math.max(info.min, (low + high) / 2 + sideways * all));
    const windowWidth = Math.min(2 * (info.max - info.min || 1), Math.max(all / 2000, (high - low) * Math.exp(2 * upwards)));
    const digits = windowWidth / 1000;
    const turned = { [this.names.level]: roundedWithin(level, digits), [this.names.width]: roundedWithin(windowWidth, digits) };
    this.turn(turned, isDragging);
  }
}
