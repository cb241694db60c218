// Controls for one setting each: each changes its setting, and show() updates all of them.
import type { Settings } from "../state/settings";
import { type ChoiceOptions, type Control, choice, type SliderOptions, slider, type ToggleOptions, toggle } from "./inputs";
import type { Change } from "./panel_section";

type NamesOf<T> = { [K in keyof Settings]: Settings[K] extends T ? K : never }[keyof Settings];
type Word = Exclude<NamesOf<string>, "dataset">;

export class SettingControls {
  private readonly shows: ((settings: Settings) => void)[] = [];

  constructor(private readonly change: Change) {}

  slider(name: NamesOf<number>, options: Omit<SliderOptions, "onChange">): HTMLElement {
    const onChange = (value: number, isDragging: boolean) => this.change({ [name]: value }, isDragging);
    return this.with(name, slider({ ...options, onChange }));
  }

  choice<K extends Word>(name: K, options: Omit<ChoiceOptions<Settings[K]>, "onChange">): HTMLElement {
    const onChange = (value: Settings[K]) => this.change({ [name]: value });
    return this.with(name, choice<Settings[K]>({ ...options, onChange }));
  }

  toggle(name: NamesOf<boolean>, options: Omit<ToggleOptions, "onChange">): HTMLElement {
    return this.with(name, toggle({ ...options, onChange: (value) => this.change({ [name]: value }) }));
  }

  show(settings: Settings): void {
    for (const show of this.shows) show(settings);
  }

  private with<K extends keyof Settings>(name: K, control: Control<Settings[K]>): HTMLElement {
    this.shows.push((settings) => control.show(settings[name]));
    return control.element;
  }
}
