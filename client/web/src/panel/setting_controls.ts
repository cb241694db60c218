// Controls for one setting each: each changes its setting, and show() updates all of them.
import type { Settings } from "../state/settings";
import { type Choices, type Control, choice, type SliderOptions, slider, toggle } from "./inputs";
import type { Change } from "./panel_section";

type NamesOf<T> = { [K in keyof Settings]: Settings[K] extends T ? K : never }[keyof Settings];
type Word = Exclude<NamesOf<string>, "dataset">;

export class SettingControls {
  private readonly shows: ((settings: Settings) => void)[] = [];

  constructor(private readonly change: Change) {}

  slider(name: NamesOf<number>, label: string, tip: string, options: SliderOptions): HTMLElement {
    return this.with(
      name,
      slider(label, tip, options, (value, isDragging) => this.change({ [name]: value }, isDragging)),
    );
  }

  choice<K extends Word>(name: K, label: string, tip: string, choices: Choices<Settings[K]>): HTMLElement {
    return this.with(
      name,
      choice<Settings[K]>(label, tip, choices, (value) => this.change({ [name]: value })),
    );
  }

  toggle(name: NamesOf<boolean>, label: string, tip: string): HTMLElement {
    return this.with(
      name,
      toggle(label, tip, (value) => this.change({ [name]: value })),
    );
  }

  show(settings: Settings): void {
    for (const show of this.shows) show(settings);
  }

  private with<K extends keyof Settings>(name: K, control: Control<Settings[K]>): HTMLElement {
    this.shows.push((settings) => control.show(settings[name]));
    return control.element;
  }
}
