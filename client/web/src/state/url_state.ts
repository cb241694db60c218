// Converts settings to and from the part of an address after '#', which is not sent to servers. It contains only
// differences from the defaults, in readable form:
//
//   #dataset=head&isovalue=500.5&error=0.5&region=box:0,0,0,10,10,10=0.25&eye=1,2,3&target=0,0,0
//
// Names are the settings' in snake_case; request fields are named as in HTTP queries, including `quality` for an error.
//
// Invalid settings are ignored and reported, so no address breaks the page.
import { type Format, qualities } from "./setting_formats";
import { type Settings, settingTable, type WrittenSettings, writtenDefaults, writtenNames } from "./settings";
import { written } from "./written_settings";

// `resolution`: that of world coordinates, as of coordinateResolution(); 0: they are exact.
export function toAddress(settings: Settings, resolution = 0): string {
  return addressOf(written(settings), resolution);
}

export function addressOf(settings: WrittenSettings, resolution = 0): string {
  const parameters = new URLSearchParams();
  for (const name of writtenNames) {
    const text = textOf(name, settings[name], resolution);
    if (text !== textOf(name, writtenDefaults[name], 0)) parameters.set(addressName(name), text);
  }
  return parameters.toString().replace(/%(2C|2F|3A|3B|3D)/g, decodeURIComponent);
}

export function fromAddress(text: string): Partial<WrittenSettings> {
  const settings: Record<string, unknown> = {};
  for (const { setting, value } of wordsOf(text)) {
    const read = readSetting(setting, value);
    if (read !== undefined) settings[setting] = read;
    else if (setting === "quality" && qualities.has(value)) settings.error ??= qualities.get(value);
  }
  return settings;
}

// Undefined: unknown or invalid.
export function readSetting(name: string, text: string): unknown {
  return Object.hasOwn(settingTable, name) ? formatOf(name as keyof WrittenSettings).read(text) : undefined;
}

// Empty: none.
function textOf(name: keyof WrittenSettings, value: unknown, resolution: number): string {
  return value === null ? "" : formatOf(name).write(value, resolution);
}

// The same value as it would be read from an address; undefined: it is invalid.
export function checkedSetting(name: keyof WrittenSettings, value: unknown): unknown {
  return value === null ? undefined : readSetting(name, textOf(name, value, 0));
}

function formatOf(name: keyof WrittenSettings): Format<unknown> {
  return settingTable[name].format as Format<unknown>;
}

// Returns the parts that fromAddress() skipped, as written: "error=-1". Never includes the token.
export function ignoredParts(text: string): string[] {
  const read = fromAddress(text);
  const isRead = ({ setting, value }: Word) => Object.hasOwn(read, setting) || (setting === "quality" && qualities.has(value));
  return wordsOf(text)
    .filter((word) => word.name !== "token" && !isRead(word))
    .map(({ name, value }) => `${name}=${value}`);
}

// Returns the settings after an edit of the address: missing parts get defaults, invalid ones keep their values.
export function afterEdit(now: WrittenSettings, text: string): WrittenSettings {
  const kept = ignoredParts(text)
    .map((parameters) => settingName(parameters.slice(0, parameters.indexOf("="))))
    .filter((name): name is keyof WrittenSettings => Object.hasOwn(now, name));
  const asTheyWere = Object.fromEntries(kept.map((name) => [name, now[name]]));
  return { ...writtenDefaults, ...asTheyWere, ...fromAddress(text) };
}

// "clipAt" <-> "clip_at".
function addressName(name: string): string {
  return name.replace(/[A-Z]/g, (letter) => `_${letter.toLowerCase()}`);
}
function settingName(name: string): string {
  return name.replace(/_([a-z])/g, (_, letter: string) => letter.toUpperCase());
}

interface Word {
  name: string; // The name as written in the address.
  setting: string; // Empty for names with capitals, which addresses do not have.
  value: string;
}

function wordsOf(text: string): Word[] {
  const words = [...new URLSearchParams(text.replace(/^#/, ""))];
  return words.map(([name, value]) => ({ name, setting: /[A-Z]/.test(name) ? "" : settingName(name), value }));
}
