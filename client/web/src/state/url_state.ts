// Converts settings to and from the part of an address after '#', which is not sent to servers. It contains only
// differences from the defaults, in readable form:
//
//   #dataset=head&isovalue=500.5&error=0.5&region=box:0,0,0,10,10,10=0.25&eye=1,2,3&target=0,0,0
//
// Names are the settings' in snake_case; request fields are named as in HTTP queries, including `quality` for an error.
//
// Invalid settings are ignored and reported, so no address breaks the page.
import { colorMaps } from "../shared/color_maps";
import { defaults, type AdditionalSurface, type Crop, type LabelName, materials, type MeasuredPlace, maxHiddenParts, maxNoteLength, maxPlaces, type MinComponent, type Region, type Settings } from "./settings";
import { parseLabels } from "./label_ranges";
import { maxMinComponent, maxLabels } from "./surfaces";

export function toAddress(settings: Settings): string {
  const parameters = new URLSearchParams();
  const add = (name: string, value: string | number | boolean | null, usual: unknown) => {
    if (value !== usual && value !== null) parameters.set(addressName(name), String(value));
  };
  for (const name of plainNames) add(name, settings[name], defaults[name]);
  for (const name of ["color", "noValueColor"] as const) {
    if (settings[name] !== defaults[name]) parameters.set(addressName(name), settings[name].slice(1));
  }
  if (settings.surfaces.length > 0) parameters.set("surfaces", settings.surfaces.map(surfaceText).join(";"));
  if (settings.labelNames.length > 0) parameters.set("label_names", settings.labelNames.map(labelNameText).join(";"));
  if (settings.hiddenParts.length > 0) parameters.set("hidden_parts", settings.hiddenParts.map((part) => part.map(short).join(",")).join(";"));
  if (settings.crop) parameters.set("crop", [...settings.crop.low, ...settings.crop.high].map(short).join(","));
  if (settings.region) parameters.set("region", regionText(settings.region));
  if (settings.up.some((part, axis) => part !== defaults.up[axis])) parameters.set("up", settings.up.map(short).join(","));
  if (settings.clipNormal) parameters.set("clip_normal", settings.clipNormal.map(short).join(","));
  if (settings.places.length > 0) parameters.set("places", settings.places.map(placeText).join(";"));
  if (settings.cross) parameters.set("cross", settings.cross.map(short).join(","));
  if (settings.eye) parameters.set("eye", settings.eye.map(short).join(","));
  if (settings.target) parameters.set("target", settings.target.map(short).join(","));
  return parameters.toString().replace(/%(2C|2F|3A|3B|3D)/g, decodeURIComponent);
}

export function fromAddress(text: string): Partial<Settings> {
  const parameters = new Map(wordsOf(text).map(({ setting, value }) => [setting, value]));
  const settings: Partial<Settings> = {};
  const set = <K extends keyof Settings>(name: K, value: Settings[K] | undefined) => {
    if (value !== undefined) settings[name] = value;
  };
  const word = <T extends string>(name: string, ...known: T[]) =>
    known.find((value) => value === parameters.get(name));
  const number = (name: string, low: number, high: number) => {
    const value = parameters.get(name)?.trim() ? Number(parameters.get(name)) : NaN;
    return value >= low && value <= high ? value : undefined;
  };
  const yes = (name: string) => switches.get(parameters.get(name) ?? "");
  set("dataset", parameters.get("dataset") ?? undefined);
  set("t", number("t", -Number.MAX_VALUE, Number.MAX_VALUE));
  set("isovalue", number("isovalue", -Number.MAX_VALUE, Number.MAX_VALUE));
  set("error", number("error", 0, 1e6) ?? qualities.get(parameters.get("quality") ?? ""));
  set("bound", word("bound", "certified", "paper"));
  set("topologyRule", word("topologyRule", "exact", "paper"));
  set("topologyTolerance", number("topologyTolerance", 0, 1e6));
  set("followView", yes("followView"));
  set("pixels", number("pixels", 0.1, 100));
  set("maxTriangles", number("maxTriangles", 0, 1e9));
  set("simplify", yes("simplify"));
  set("shading", word("shading", "field", "smooth", "facets"));
  set("wireframe", yes("wireframe"));
  set("coloring", word("coloring", "plain", "tiles", "steps"));
  set("clip", word("clip", "off", "x", "y", "z", "oblique"));
  set("clipAt", number("clipAt", 0, 1));
  set("clipNormal", directionFrom(parameters.get("clipNormal") ?? null));
  set("clipFlipped", yes("clipFlipped"));
  set("filled", yes("filled"));
  set("colorBy", parameters.get("colorBy") ?? undefined);
  set("colors", word("colors", ...colorMaps));
  set("fieldLevel", number("fieldLevel", -Number.MAX_VALUE, Number.MAX_VALUE));
  set("fieldWindow", number("fieldWindow", 0, Number.MAX_VALUE));
  set("fieldLog", yes("fieldLog"));
  set("noValueColor", colorFrom(parameters.get("noValueColor")));
  set("slice", word("slice", "off", "x", "y", "z"));
  set("samplesOf", parameters.get("samplesOf") ?? undefined);
  set("transparentAir", yes("transparentAir"));
  set("sliceAt", number("sliceAt", 0, 1));
  set("layout", word("layout", "surface", "four"));
  set("cross", numbersFrom(parameters.get("cross"), 3) as Settings["cross"] | undefined);
  set("sliceColors", word("sliceColors", ...colorMaps));
  set("level", number("level", -Number.MAX_VALUE, Number.MAX_VALUE));
  set("windowWidth", number("windowWidth", 0, Number.MAX_VALUE));
  set("samplesLog", yes("samplesLog"));
  set("axes", yes("axes"));
  set("projection", word("projection", "perspective", "orthographic"));
  set("occlusion", yes("occlusion"));
  set("color", colorFrom(parameters.get("color")));
  set("material", word("material", ...materials));
  set("opacity", number("opacity", 0, 1));
  set("visible", yes("visible"));
  set("minComponent", minComponentFrom(parameters.get("minComponent")));
  set("hiddenParts", partsFrom(parameters.get("hiddenParts"), ";", ","));
  set("surfaces", surfacesFrom(parameters.get("surfaces") ?? null));
  set("labels", parseLabels(parameters.get("labels") ?? "") ? parameters.get("labels") : undefined);
  set("labelNames", labelNamesFrom(parameters.get("labelNames") ?? null));
  set("logScale", yes("logScale"));
  set("playing", yes("playing"));
  set("speed", number("speed", 0.1, 60));
  set("loop", yes("loop"));
  set("theme", word("theme", "auto", "dark", "light"));
  set("crop", boxFrom(parameters.get("crop")));
  set("region", regionFrom(parameters.get("region") ?? null));
  set("up", directionFrom(parameters.get("up") ?? null));
  set("places", placesFrom(parameters.get("places") ?? null));
  set("eye", numbersFrom(parameters.get("eye"), 3) as Settings["eye"] | undefined);
  set("target", numbersFrom(parameters.get("target"), 3) as Settings["target"] | undefined);
  return settings;
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
export function afterEdit(now: Settings, text: string): Settings {
  const kept = ignoredParts(text)
    .map((parameters) => settingName(parameters.slice(0, parameters.indexOf("="))))
    .filter((name): name is keyof Settings => Object.hasOwn(now, name));
  const asTheyWere = Object.fromEntries(kept.map((name) => [name, now[name]]));
  return { ...defaults, ...asTheyWere, ...fromAddress(text) };
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

const switches: ReadonlyMap<string, boolean> = new Map([["true", true], ["on", true], ["false", false], ["off", false]]);

// Errors in voxels by their names in commands and HTTP.
export const qualities: ReadonlyMap<string, number> = new Map([["draft", 2], ["normal", 0.5], ["fine", 0.25], ["exact", 0]]);

const plainNames = [
  "dataset", "labels", "t", "isovalue", "error", "bound", "topologyRule", "topologyTolerance", "followView", "pixels",
  "maxTriangles", "simplify", "shading", "wireframe", "coloring", "clip", "clipAt", "clipFlipped", "filled",
  "slice", "sliceAt", "samplesOf", "transparentAir", "layout", "sliceColors", "level", "windowWidth", "colorBy", "colors",
  "fieldLevel", "fieldWindow", "fieldLog", "samplesLog", "axes",
  "projection", "occlusion", "material", "opacity", "visible", "minComponent", "logScale", "playing", "speed", "loop", "theme",
] as const;

function short(value: number): string {
  return String(Number(value.toPrecision(6)));
}

// "300.5,d9775f,0.4": isovalue, color, opacity; then, each optional: error, "hidden", dataset (with separators
// percent-encoded), size of the smallest visible component in samples or "largest", material, hidden parts
// "1:2:3/4:5:6".
function surfaceText(surface: AdditionalSurface): string {
  const { dataset = "", isovalue, error, color, opacity, visible, minComponent = 0, material = "neutral", hiddenParts = [] } = surface;
  const words = [
    isovalue, color.slice(1), opacity === 1 ? "" : short(opacity), error === null ? "" : short(error),
    visible ? "" : "hidden", dataset.replace(/[,;%]/g, encodeURIComponent), minComponent === 0 ? "" : typeof minComponent === "number" ? short(minComponent) : minComponent,
    material === "neutral" ? "" : material, hiddenParts.map((part) => part.map(short).join(":")).join("/"),
  ];
  return words.join(",").replace(/,+$/, "");
}

function surfacesFrom(text: string | null): AdditionalSurface[] | undefined {
  if (!text) return undefined;
  const surfaces = text.split(";").map((one): AdditionalSurface | null => {
    const [value, colorText, opacityText, errorText, hidden, name, leastText, materialText, partsText] = one.split(",");
    const [isovalue] = numbersFrom(value, 1) ?? [];
    const [opacity] = numbersFrom(opacityText || "1", 1) ?? [];
    const [error] = errorText ? (numbersFrom(errorText, 1) ?? [NaN]) : [null];
    const color = colorFrom(colorText);
    if (isovalue === undefined || opacity === undefined || !color || (hidden && hidden !== "hidden")) return null;
    if (!(opacity >= 0 && opacity <= 1) || (error !== null && !(error >= 0))) return null;
    const dataset = nameFrom(name ?? "");
    if (dataset === undefined) return null;
    const minComponent = minComponentFrom(leastText || "0");
    if (minComponent === undefined) return null;
    const material = materials.find((word) => word === (materialText || "neutral"));
    const hiddenParts = partsText ? partsFrom(partsText, "/", ":") : [];
    if (!material || !hiddenParts) return null;
    const surface = { isovalue, error, color, opacity, visible: hidden !== "hidden" };
    return {
      ...(dataset ? { dataset } : {}), ...surface, ...(minComponent ? { minComponent } : {}),
      ...(material !== "neutral" ? { material } : {}), ...(hiddenParts.length > 0 ? { hiddenParts } : {}),
    };
  });
  return surfaces.length < maxLabels && surfaces.every((one) => one !== null) ? surfaces : undefined;
}

// "3:liver", with separators percent-encoded.
function labelNameText({ label, name }: LabelName): string {
  return `${label}:${name.replace(/[;%]/g, encodeURIComponent)}`;
}

function labelNamesFrom(text: string | null): LabelName[] | undefined {
  if (!text) return undefined;
  const names = text.split(";").map((one) => {
    const [, label, words = ""] = one.match(/^(-?\d+):(.+)$/) ?? [];
    return { label: Number(label ?? NaN), name: nameFrom(words)?.slice(0, maxNoteLength) ?? "" };
  });
  return names.length <= maxLabels && names.every(({ label, name }) => Number.isFinite(label) && name) ? names : undefined;
}

// Parses places separated by `between`, their coordinates by `within`.
function partsFrom(text: string | undefined, between: string, within: string): Settings["hiddenParts"] | undefined {
  if (!text) return undefined;
  const parts = text.split(between).map((one) => numbersFrom(one.replaceAll(within, ","), 3));
  return parts.length <= maxHiddenParts && parts.every((part) => part !== undefined) ? (parts as [number, number, number][]) : undefined;
}

// "12.5,3,-4,0.25,a note": the place, its bound (may be empty) and its note, with separators percent-encoded.
function placeText({ world, bound, note = "" }: MeasuredPlace): string {
  const words = [...world.map(short), bound === null ? "" : short(bound), note.replace(/[,;%]/g, encodeURIComponent)];
  return words.join(",").replace(/,+$/, "");
}

function placesFrom(text: string | null): MeasuredPlace[] | undefined {
  if (!text) return undefined;
  const places = text.split(";").map((one): MeasuredPlace | null => {
    const [x, y, z, boundText, noteText = "", ...rest] = one.split(",");
    const world = numbersFrom([x, y, z].join(","), 3);
    const [bound] = boundText ? (numbersFrom(boundText, 1) ?? [NaN]) : [null];
    const note = nameFrom(noteText)?.slice(0, maxNoteLength);
    if (!world || (bound !== null && !(bound >= 0)) || note === undefined || rest.length > 0) return null;
    return { world: world as [number, number, number], bound, ...(note ? { note } : {}) };
  });
  return places.length <= maxPlaces && places.every((one) => one !== null) ? places : undefined;
}

// Parses a direction or an axis such as "-y".
function directionFrom(text: string | null): Settings["up"] | undefined {
  const [, sign, axis] = text?.match(/^([+-]?)([xyz])$/) ?? [];
  const numbers = axis ? [..."xyz"].map((one) => (one === axis ? (sign === "-" ? -1 : 1) : 0)) : numbersFrom(text, 3);
  const length = numbers ? Math.hypot(...numbers) : 0;
  if (!numbers || !(length > 0) || !Number.isFinite(length)) return undefined;
  return numbers.map((part) => part / length) as Settings["up"];
}

function nameFrom(text: string): string | undefined {
  try {
    return decodeURIComponent(text);
  } catch {
    return undefined;
  }
}

function minComponentFrom(text: string | undefined): MinComponent | undefined {
  if (text === "largest") return text;
  const [samples] = numbersFrom(text, 1) ?? [];
  return samples !== undefined && samples >= 0 && samples <= maxMinComponent ? samples : undefined;
}

function colorFrom(text: string | null | undefined): string | undefined {
  return text && /^[0-9a-f]{6}$/i.test(text) ? `#${text.toLowerCase()}` : undefined;
}

// In the form of the --region option.
function regionText(region: Region): string {
  const numbers =
    region.kind === "box" ? [...region.low, ...region.high] : [...region.center, region.radius];
  return `${region.kind}:${numbers.map(short).join(",")}=${short(region.error)}`;
}

function regionFrom(text: string | null): Region | undefined {
  const [, kind, place, errorText] = text?.match(/^(box|ball):([^=]+)=([^=]+)$/) ?? [];
  const error = numbersFrom(errorText ?? null, 1)?.[0];
  if (error === undefined || error < 0) return undefined;
  if (kind === "box") {
    const box = boxFrom(place);
    return box && { kind, ...box, error };
  }
  const n = numbersFrom(place, 4);
  if (!n || n[3] < 0) return undefined;
  return { kind: "ball", center: [n[0], n[1], n[2]], radius: n[3], error };
}

// Parses two corners.
function boxFrom(text: string | undefined): Crop | undefined {
  const n = numbersFrom(text, 6);
  if (!n || n[0] > n[3] || n[1] > n[4] || n[2] > n[5]) return undefined;
  return { low: [n[0], n[1], n[2]], high: [n[3], n[4], n[5]] };
}

function numbersFrom(text: string | null | undefined, count: number): number[] | undefined {
  if (!text) return undefined;
  const numbers = text.split(",").map((part) => (part.trim() ? Number(part) : NaN));
  return numbers.length === count && numbers.every(Number.isFinite) ? numbers : undefined;
}
