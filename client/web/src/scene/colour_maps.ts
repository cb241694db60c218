// Colours for numbers: maps whose lightness tells more from less also in print and to those who see few
// colours (viridis, cividis), one with a middle (coolwarm), and grey. Given by colours at equal steps.
const maps = {
  grey: ["#000000", "#ffffff"],
  viridis: ["#440154", "#482878", "#3e4989", "#31688e", "#26828e", "#1f9e89", "#35b779", "#6ece58", "#b5de2b", "#fde725"],
  cividis: ["#00224e", "#123570", "#3b496c", "#575d6d", "#707173", "#8a8678", "#a59c74", "#c3b369", "#e1cc55", "#fee838"],
  coolwarm: ["#3b4cc0", "#6788ee", "#9abbff", "#c9d7f0", "#edd1c2", "#f7a889", "#e26952", "#b40426"],
} as const;

export type ColourMap = keyof typeof maps;
export const colourMaps = Object.keys(maps) as ColourMap[];

// Red, green and blue, 0 to 255 (sRGB), at a share of the map from 0 to 1; beyond, its ends.
export function colourAt(map: ColourMap, share: number): [number, number, number] {
  const colours = maps[map];
  const at = Math.min(1, Math.max(0, share)) * (colours.length - 1);
  const first = Math.min(colours.length - 2, Math.floor(at));
  const [a, b] = [rgb(colours[first]), rgb(colours[first + 1])];
  const part = at - first;
  return [0, 1, 2].map((i) => Math.round(a[i] + part * (b[i] - a[i]))) as [number, number, number];
}

// A row of `count` colours as bytes: red, green, blue and 255.
export function colourRow(map: ColourMap, count: number): Uint8Array<ArrayBuffer> {
  const row = new Uint8Array(4 * count).fill(255);
  for (let i = 0; i < count; ++i) row.set(colourAt(map, i / (count - 1)), 4 * i);
  return row;
}

// For style sheets.
export function gradientOf(map: ColourMap): string {
  return `linear-gradient(90deg, ${maps[map].join(", ")})`;
}

function rgb(text: string): number[] {
  return [1, 3, 5].map((at) => parseInt(text.slice(at, at + 2), 16));
}
