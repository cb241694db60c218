// Colors and the values that they mean, over the picture: of a slice, of a field on the surfaces. Dragged sideways it turns the level, up and
// down the window, as readers of medical pictures do; arrow keys do the same, a double click resets.
import { gradientOf, type LegendWords } from "../shared/color_maps";
import { scaleOf, windowOf } from "../slices";
import type { Settings } from "../state/settings";
import { h } from "../shared/elements";
import { inDigits } from "../shared/quantities";

// The names of the settings that a legend shows and turns.
export interface LegendNames {
  label: string;
  colors: "sliceColors" | "colors";
  level: "level" | "fieldLevel";
  width: "windowWidth" | "fieldWindow";
  isLog: "samplesLog" | "fieldLog";
}

// The values that it is about.
export interface LegendValues {
  min: number;
  max: number;
  valueUnit: string;
  usual?: { level: number; width: number }; // The default window; all values if there is none.
}

const keys: Record<string, [number, number]> = {
  ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1],
};

export class Legend {
  readonly element = h("div", {
    class: "legend", hidden: true, tabindex: "0", role: "slider",
    "data-tip": "Drag sideways for the level, up and down for the window; a double click resets them.",
  });
  private readonly name = h("span", { class: "legend-name" });
  private readonly bar = h("div", { class: "legend-bar" });
  private readonly low = h("span");
  private readonly high = h("span");
  private info: LegendValues | null = null;
  private settings: Settings | null = null;

  constructor(
    private readonly names: LegendNames,
    private readonly turn: (changes: Partial<Settings>, isDragging: boolean) => void,
  ) {
    this.element.setAttribute("aria-label", `Window and level of ${names.label}`);
    this.element.append(this.name, this.bar, h("div", { class: "legend-ends" }, this.low, this.high));
    this.listen();
  }

  // Null: no such values are shown. `name`: what they are.
  show(settings: Settings, info: LegendValues | null, name = ""): void {
    this.settings = settings;
    this.info = info;
    this.element.hidden = !info;
    if (!info) return;
    const { low, high, isLog } = scaleOf(settings[this.names.level], settings[this.names.width], settings[this.names.isLog], info);
    this.name.textContent = isLog ? `${name || "samples"}, logarithmic` : name;
    this.bar.style.background = gradientOf(settings[this.names.colors]);
    this.low.textContent = inDigits(low, 4);
    this.high.textContent = `${inDigits(high, 4)}${info.valueUnit ? ` ${info.valueUnit}` : ""}`;
    this.element.setAttribute("aria-valuemin", String(info.min));
    this.element.setAttribute("aria-valuemax", String(info.max));
    this.element.setAttribute("aria-valuenow", String((low + high) / 2));
    this.element.setAttribute("aria-valuetext", `level ${inDigits((low + high) / 2)}, window ${inDigits(high - low)}`);
  }

  // Null: it is not shown.
  get words(): LegendWords | null {
    const [name, low, high] = [this.name, this.low, this.high].map(({ textContent }) => textContent ?? "");
    return this.element.hidden || !this.settings ? null : { map: this.settings[this.names.colors], name, low, high };
  }

  private window(settings: Settings, info: LegendValues): { low: number; high: number } {
    return windowOf(settings[this.names.level], settings[this.names.width], info);
  }

  private listen(): void {
    const { element } = this;
    let last: { x: number; y: number } | null = null;
    element.addEventListener("pointerdown", (event) => {
      if (event.button !== 0) return;
      element.setPointerCapture(event.pointerId);
      last = { x: event.clientX, y: event.clientY };
    });
    element.addEventListener("pointermove", (event) => {
      if (!last) return;
      this.move((event.clientX - last.x) / 250, (last.y - event.clientY) / 150, true);
      last = { x: event.clientX, y: event.clientY };
    });
    const end = () => {
      if (last) this.move(0, 0, false);
      last = null;
    };
    element.addEventListener("pointerup", end);
    element.addEventListener("pointercancel", end);
    element.addEventListener("dblclick", () => this.turn({ [this.names.level]: null, [this.names.width]: null }, false));
    element.addEventListener("keydown", (event) => {
      const step = keys[event.key];
      if (!step) return;
      event.preventDefault();
      event.stopPropagation();
      this.move(0.02 * step[0], 0.05 * step[1], false);
    });
  }

  // By shares of all the values; the window grows and shrinks by factors.
  private move(sideways: number, upwards: number, isDragging: boolean): void {
    const { info, settings } = this;
    if (!info || !settings) return;
    const { low, high } = this.window(settings, info);
    const all = (info.usual?.width ?? info.max - info.min) || 1;
    const level = Math.min(info.max, Math.max(info.min, (low + high) / 2 + sideways * all));
    const windowWidth = Math.min(2 * (info.max - info.min || 1), Math.max(all / 2000, (high - low) * Math.exp(2 * upwards)));
    const turned = { [this.names.level]: Number(level.toPrecision(6)), [this.names.width]: Number(windowWidth.toPrecision(6)) };
    this.turn(turned, isDragging);
  }
}
