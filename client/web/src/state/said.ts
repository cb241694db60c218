// Settings that somebody else says, with the names and forms that Settings have: a page around this one,
// a notebook. What means nothing is passed over and named; nothing they say breaks anything.
import { defaults, type Settings } from "./settings";
import { fromAddress, toAddress } from "./url_state";

export interface SaidSettings {
  settings: Partial<Settings>;
  passedOver: string[]; // Names.
}

export function settingsFrom(said: unknown): SaidSettings {
  const found: SaidSettings = { settings: {}, passedOver: [] };
  if (typeof said !== "object" || said === null) return found;
  for (const [name, value] of Object.entries(said)) {
    const read = Object.hasOwn(defaults, name) ? settingFrom(name as keyof Settings, value) : undefined;
    if (read) Object.assign(found.settings, read);
    else found.passedOver.push(name);
  }
  return found;
}

// What is usual, the address does not say; all else it says and reads again, in its ranges.
function settingFrom(name: keyof Settings, value: unknown): Partial<Settings> | undefined {
  if (JSON.stringify(value) === JSON.stringify(defaults[name])) return { [name]: defaults[name] };
  try {
    const read = fromAddress(toAddress({ ...defaults, [name]: value }));
    return Object.hasOwn(read, name) ? { [name]: read[name] } : undefined;
  } catch {
    return undefined; // Of another form altogether.
  }
}
