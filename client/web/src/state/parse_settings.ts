// Parses settings from outside, such as an embedding page or a notebook. Names and forms are those of Settings; invalid
// values are skipped and their names returned.
import { defaults, type Settings } from "./settings";
import { fromAddress, toAddress } from "./url_state";

export interface ParsedSettings {
  settings: Partial<Settings>;
  ignored: string[]; // Names.
}

export function parseSettings(given: unknown): ParsedSettings {
  const found: ParsedSettings = { settings: {}, ignored: [] };
  if (typeof given !== "object" || given === null) return found;
  for (const [name, value] of Object.entries(given)) {
    const read = Object.hasOwn(defaults, name) ? settingFrom(name as keyof Settings, value) : undefined;
    if (read) Object.assign(found.settings, read);
    else found.ignored.push(name);
  }
  return found;
}

// Addresses omit defaults; other values are written to an address and parsed again, which checks their range.
function settingFrom(name: keyof Settings, value: unknown): Partial<Settings> | undefined {
  if (JSON.stringify(value) === JSON.stringify(defaults[name])) return { [name]: defaults[name] };
  try {
    const read = fromAddress(toAddress({ ...defaults, [name]: value }));
    return Object.hasOwn(read, name) ? { [name]: read[name] } : undefined;
  } catch {
    return undefined; // Malformed settings.
  }
}
