// Color maps for numbers: sequential ones, ordered by lightness for print and color-blind readers (viridis, cividis), a
// diverging one (coolwarm), and gray. Maps and scales are identical, to the byte, with common/image/color_map.cpp,
// which documents their sources.
const maps = {
  gray: ["#000000", "#ffffff"],
  viridis: ["#440154", "#482878", "#3e4989", "#31688e", "#26828e", "#1f9e89", "#35b779", "#6ece58", "#b5de2b", "#fde725"],
  cividis: ["#00204d", "#00306f", "#2a406c", "#48526b", "#5e626e", "#727374", "#878479", "#9e9677", "#b6a971", "#d0be67", "#ead357", "#ffea46"],
  coolwarm: ["#3b4cc0", "#6282ea", "#8db0fe", "#b8d0f9", "#dddddd", "#f5c4ad", "#f49a7b", "#de604d", "#b40426"],
} as const;

export type ColorMap = keyof typeof maps;
export const colorMaps = Object.keys(maps) as ColorMap[];

// The text of a legend.
export interface LegendText {
  map: ColorMap;
  name: string; // Empty: the meaning of the colors is clear.
  low: string; // With the unit, as is `high`.
  high: string;
}

// Maps values to colors.
export interface ColorScale {
  map: ColorMap;
  low: number; // Has the first color of the map.
  high: number; // Has the last color.
  isLog: boolean; // Requires 0 < low < high; values that are not positive have the first color.
}

// Returns red, green and blue, 0 to 255 (sRGB), at a share of the map from 0 to 1; clamped.
export function colorAt(map: ColorMap, share: number): [number, number, number] {
  const colors = maps[map];
  const at = (Number.isNaN(share) ? 0 : Math.min(1, Math.max(0, share))) * (colors.length - 1);
  const first = Math.min(colors.length - 2, Math.floor(at));
  const [a, b] = [rgb(colors[first]), rgb(colors[first + 1])];
  const part = at - first;
  return [0, 1, 2].map((i) => Math.round((1 - part) * a[i] + part * b[i])) as [number, number, number];
}

// Returns the position of a value along the map, not clamped to 0 to 1.
export function fractionOf(value: number, { low, high, isLog }: Omit<ColorScale, "map">): number {
  if (!(high > low)) return value > low ? 1 : 0;
  if (!isLog) return (value - low) / (high - low);
  return value > 0 ? Math.log(value / low) / Math.log(high / low) : 0;
}

// The same in GLSL. Takes the scale as (low, high), or their logarithms for a logarithmic one.
export const fractionInShader = /* glsl */ `
  float fractionOf(float value, vec2 ends, bool isLog) {
    if (isLog) return value > 0.0 ? clamp((log(value) - ends.x) / (ends.y - ends.x), 0.0, 1.0) : 0.0;
    return clamp((value - ends.x) / (ends.y - ends.x), 0.0, 1.0);
  }`;

// Returns different ends for fractionInShader, in 32-bit precision.
export function endsOf({ low, high, isLog }: Omit<ColorScale, "map">): [number, number] {
  const [first, last] = isLog ? [Math.log(low), Math.log(high)] : [low, high];
  return [first, last > first ? last : first + 1e-6 * Math.max(1, Math.abs(first))];
}

// Returns a row of `count` colors as bytes: red, green, blue and 255.
export function colorRow(map: ColorMap, count: number): Uint8Array<ArrayBuffer> {
  const row = new Uint8Array(4 * count).fill(255);
  for (let i = 0; i < count; ++i) row.set(colorAt(map, i / (count - 1)), 4 * i);
  return row;
}

// For style sheets.
export function gradientOf(map: ColorMap): string {
  return `linear-gradient(90deg, ${maps[map].join(", ")})`;
}

function rgb(text: string): number[] {
  return [1, 3, 5].map((at) => parseInt(text.slice(at, at + 2), 16));
}
