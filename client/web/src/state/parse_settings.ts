// Parses settings from outside, such as an embedding page or a notebook. Names and forms are those of Settings; invalid
// values are skipped and their names returned. Missing fields of a surface have defaults.
import { defaultSurface, type SurfaceSettings, type WrittenSettings, writtenDefaults } from "./settings";
import { surfaceColors } from "./surfaces";
import { checkedSetting } from "./url_state";

export interface ParsedSettings {
  settings: Partial<WrittenSettings>;
  ignored: string[]; // Names: "error", "surfaces[1].opacity".
}

export function parseSettings(given: unknown): ParsedSettings {
  const found: ParsedSettings = { settings: {}, ignored: [] };
  if (typeof given !== "object" || given === null) return found;
  for (const [name, value] of Object.entries(given)) {
    const isList = name === "surfaces" && Array.isArray(value);
    const checked = isList ? surfacesFrom(value, found.ignored) : value;
    if (isList && value.length > 0 && checked.length === 0) continue; // No entry is valid.
    const read = Object.hasOwn(writtenDefaults, name) ? settingFrom(name as keyof WrittenSettings, checked) : undefined;
    if (read) Object.assign(found.settings, read);
    else found.ignored.push(name);
  }
  return found;
}

// Values are written as in an address and read again, which checks their range.
function settingFrom(name: keyof WrittenSettings, value: unknown): Partial<WrittenSettings> | undefined {
  const usual = writtenDefaults[name];
  if (value === usual || (Array.isArray(value) && JSON.stringify(value) === JSON.stringify(usual))) return { [name]: usual };
  try {
    const read = checkedSetting(name, value);
    return read === undefined ? undefined : { [name]: read };
  } catch {
    return undefined; // Malformed settings.
  }
}

// Skips entries without a valid isovalue.
function surfacesFrom(entries: readonly unknown[], ignored: string[]): SurfaceSettings[] {
  return entries.flatMap((entry, at) => {
    const surface = { ...defaultSurface, color: surfaceColors[(at + 1) % surfaceColors.length] };
    for (const [name, value] of Object.entries(entry ?? {})) {
      const read = value === undefined ? {} : surfaceFieldFrom(name, value);
      if (read) Object.assign(surface, read);
      else ignored.push(`surfaces[${at}].${name}`);
    }
    const isMissing = surface.isovalue === null;
    const name = `surfaces[${at}].isovalue`;
    if (isMissing && !ignored.includes(name)) ignored.push(name);
    return isMissing ? [] : [surface];
  });
}

function surfaceFieldFrom(name: string, value: unknown): Partial<SurfaceSettings> | undefined {
  if (!Object.hasOwn(defaultSurface, name)) return undefined;
  const [read] = settingFrom("surfaces", [{ ...defaultSurface, isovalue: 0, [name]: value }])?.surfaces ?? [];
  const field = name as keyof SurfaceSettings;
  return read && typeof read[field] === typeof value ? { [field]: read[field] } : undefined;
}
