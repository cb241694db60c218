// How settings are written in addresses, and read from there and from embedding pages. A format reads only valid values.
import { inResolution } from "../shared/numbers";
import { parseLabels } from "./label_ranges";
import {
  type Crop,
  type LabelName,
  type MeasuredPlace,
  type MinComponent,
  materials,
  maxHiddenParts,
  maxLabels,
  maxMinComponent,
  maxNoteLength,
  maxOpacityPoints,
  maxPlaces,
  type OpacityPoint,
  type Place,
  type Region,
  type SurfaceSettings,
} from "./setting_types";

export interface Format<T> {
  read: (text: string) => T | undefined; // Undefined: not valid.
  write: (value: T, resolution: number) => string; // World coordinates have this resolution; 0: are exact.
}

export const text: Format<string> = { read: (written) => written, write: (value) => value };

export function number(low: number, high: number): Format<number> {
  return {
    read: (written) => {
      const value = written.trim() ? Number(written) : NaN;
      return value >= low && value <= high ? value : undefined;
    },
    write: String,
  };
}

export const anyNumber = number(-Number.MAX_VALUE, Number.MAX_VALUE);

export function oneOf<const T extends string>(...words: readonly T[]): Format<T> {
  return { read: (written) => words.find((word) => word === written), write: (value) => value };
}

const switches: ReadonlyMap<string, boolean> = new Map([
  ["true", true],
  ["on", true],
  ["false", false],
  ["off", false],
]);

export const onOff: Format<boolean> = { read: (written) => switches.get(written), write: String };

// Errors in voxels by their names in commands and HTTP.
export const qualities: ReadonlyMap<string, number> = new Map([
  ["draft", 2],
  ["normal", 0.5],
  ["fine", 0.25],
  ["exact", 0],
]);

export const color: Format<string> = {
  read: (written) => (/^[0-9a-f]{6}$/i.test(written) ? `#${written.toLowerCase()}` : undefined),
  write: (value) => value.slice(1),
};

export const place: Format<Place> = {
  read: (written) => numbersFrom(written, 3) as Place | undefined,
  write: (value, resolution) => coordinates(value, resolution),
};

// A unit vector, or an axis such as "-y".
export const direction: Format<Place> = {
  read: (written) => {
    const [, sign, axis] = written.match(/^([+-]?)([xyz])$/) ?? [];
    const numbers = axis ? [..."xyz"].map((one) => (one === axis ? (sign === "-" ? -1 : 1) : 0)) : numbersFrom(written, 3);
    const length = numbers ? Math.hypot(...numbers) : 0;
    if (!numbers || !(length > 0) || !Number.isFinite(length)) return undefined;
    return numbers.map((part) => part / length) as Place;
  },
  write: (value) => value.map(short).join(","),
};

// Two corners.
export const box: Format<Crop> = {
  read: (written) => {
    const n = numbersFrom(written, 6);
    if (!n || n[0] > n[3] || n[1] > n[4] || n[2] > n[5]) return undefined;
    return { low: [n[0], n[1], n[2]], high: [n[3], n[4], n[5]] };
  },
  write: ({ low, high }, resolution) => coordinates([...low, ...high], resolution),
};

// In the form of the --region option.
export const region: Format<Region> = {
  read: (written) => {
    const [, kind, within, errorText] = written.match(/^(box|ball):([^=]+)=([^=]+)$/) ?? [];
    const error = numbersFrom(errorText, 1)?.[0];
    if (error === undefined || error < 0) return undefined;
    if (kind === "box") {
      const corners = box.read(within);
      return corners && { kind, ...corners, error };
    }
    const n = numbersFrom(within, 4);
    return n && n[3] >= 0 ? { kind: "ball", center: [n[0], n[1], n[2]], radius: n[3], error } : undefined;
  },
  write: (value, resolution) => {
    const numbers = value.kind === "box" ? [...value.low, ...value.high] : [...value.center, value.radius];
    return `${value.kind}:${coordinates(numbers, resolution)}=${short(value.error)}`;
  },
};

export const minComponent: Format<MinComponent> = {
  read: (written) => (written === "largest" ? written : number(0, maxMinComponent).read(written)),
  write: String,
};

// Places separated by `between`, their coordinates by `within`.
function parts(between: string, within: string): Format<readonly Place[]> {
  return {
    read: (written) => {
      const found = written ? written.split(between).map((one) => place.read(one.replaceAll(within, ","))) : [];
      return found.length <= maxHiddenParts && found.every((part) => part !== undefined) ? found : undefined;
    },
    write: (value, resolution) => value.map((part) => coordinates(part, resolution, within)).join(between),
  };
}

export const hiddenParts = nonempty(parts(";", ","));
const hiddenPartsOfSurface = parts("/", ":");

export const labels: Format<string> = { read: (written) => (parseLabels(written) ? written : undefined), write: (value) => value };

// "150:0,400:0.1": opacities by ascending value.
export const opacities: Format<readonly OpacityPoint[]> = {
  read: (written) => {
    const points = written.split(",").map((part) => {
      const [value, opacity] = part.split(":").map((one) => one.trim());
      return { value: anyNumber.read(value), opacity: number(0, 1).read(opacity ?? "") };
    });
    const isAscending = points.every(({ value = NaN }, at) => at === 0 || value >= (points[at - 1].value ?? NaN));
    const isValid = isAscending && points.every(({ value, opacity }) => value !== undefined && opacity !== undefined);
    return isValid && points.length <= maxOpacityPoints ? (points as OpacityPoint[]) : undefined;
  },
  write: (points) => points.map(({ value, opacity }) => `${value}:${short(opacity)}`).join(","),
};

// "3:liver", with separators percent-encoded.
export const labelNames = listOf<LabelName>(
  {
    read: (written) => {
      const [, label, words = ""] = written.match(/^(-?\d+):(.+)$/) ?? [];
      const name = nameFrom(words)?.slice(0, maxNoteLength);
      return label && name ? { label: Number(label), name } : undefined;
    },
    write: ({ label, name }) => `${label}:${name.replace(/[;%]/g, encodeURIComponent)}`,
  },
  maxLabels,
);

// "12.5,3,-4,0.25,a note": the place, its bound (may be empty) and its note, with separators percent-encoded.
export const places = listOf<MeasuredPlace>(
  {
    read: (written) => {
      const [x, y, z, boundText, noteText = "", ...rest] = written.split(",");
      const world = place.read([x, y, z].join(","));
      const bound = boundText ? number(0, Number.MAX_VALUE).read(boundText) : null;
      const note = nameFrom(noteText)?.slice(0, maxNoteLength);
      if (!world || bound === undefined || note === undefined || rest.length > 0) return undefined;
      return { world, bound, ...(note ? { note } : {}) };
    },
    write: ({ world, bound, note = "" }, resolution) =>
      joined([coordinates(world, resolution), bound === null ? "" : short(bound), note.replace(/[,;%]/g, encodeURIComponent)]),
  },
  maxPlaces,
);

// "300.5,d9775f,0.4": isovalue, color, opacity; then, each optional: error, "hidden", dataset (with separators
// percent-encoded), size of the smallest visible component in samples or "largest", material, hidden parts
// "1:2:3/4:5:6".
export const surfaces = listOf<SurfaceSettings>(
  {
    read: (written) => {
      const [isovalueText, colorText = "", opacityText, errorText, hidden, name, leastText, materialText, partsText] = written.split(",");
      const surface = {
        isovalue: anyNumber.read(isovalueText),
        error: errorText ? number(0, Number.MAX_VALUE).read(errorText) : null,
        color: color.read(colorText),
        opacity: number(0, 1).read(opacityText || "1"),
        visible: hidden !== "hidden",
        dataset: nameFrom(name ?? ""),
        minComponent: minComponent.read(leastText || "0"),
        material: oneOf(...materials).read(materialText || "neutral"),
        hiddenParts: hiddenPartsOfSurface.read(partsText ?? ""),
      };
      const isValid = !Object.values(surface).includes(undefined) && (!hidden || hidden === "hidden");
      return isValid ? (surface as SurfaceSettings) : undefined;
    },
    write: ({ dataset, isovalue, error, color: shown, opacity, visible, minComponent: least, material, hiddenParts: places }, resolution) =>
      joined([
        String(isovalue ?? ""),
        color.write(shown, 0),
        opacity === 1 ? "" : short(opacity),
        error === null ? "" : short(error),
        visible ? "" : "hidden",
        dataset.replace(/[,;%]/g, encodeURIComponent),
        least === 0 ? "" : String(least),
        material === "neutral" ? "" : material,
        hiddenPartsOfSurface.write(places, resolution),
      ]),
  },
  maxLabels - 1,
);

function listOf<T>(entry: Format<T>, maxEntries: number): Format<readonly T[]> {
  return nonempty<readonly T[]>({
    read: (written) => {
      const entries = written.split(";").map(entry.read);
      return entries.length <= maxEntries && entries.every((one) => one !== undefined) ? entries : undefined;
    },
    write: (value, resolution) => value.map((one) => entry.write(one, resolution)).join(";"),
  });
}

function nonempty<T>(format: Format<T>): Format<T> {
  return { ...format, read: (written) => (written ? format.read(written) : undefined) };
}

function coordinates(numbers: readonly number[], resolution: number, separator = ","): string {
  return numbers.map((value) => inResolution(value, resolution)).join(separator);
}

// Shares, errors and parts of unit vectors.
function short(value: number): string {
  return String(Number(value.toPrecision(6)));
}

// Leaves out empty words at the end.
function joined(words: readonly string[]): string {
  return words.join(",").replace(/,+$/, "");
}

function nameFrom(written: string): string | undefined {
  try {
    return decodeURIComponent(written);
  } catch {
    return undefined;
  }
}

function numbersFrom(written: string | undefined, count: number): number[] | undefined {
  if (!written) return undefined;
  const numbers = written.split(",").map((part) => (part.trim() ? Number(part) : NaN));
  return numbers.length === count && numbers.every(Number.isFinite) ? numbers : undefined;
}
