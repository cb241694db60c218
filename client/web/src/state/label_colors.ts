// Colors of labels that have no color in the file: deterministic per label, equally light, and far apart for
// consecutive labels (hues a golden angle apart), alternating between two lightnesses.

// Returns "#rrggbb"; `fileColor`: 0xRRGGBB, as in the file.
export function labelColor(value: number, fileColor?: number): string {
  if (fileColor !== undefined && fileColor >= 0 && fileColor <= 0xffffff) return `#${fileColor.toString(16).padStart(6, "0")}`;
  const at = Math.abs(Math.round(value));
  return oklch(at % 2 === 0 ? 0.66 : 0.78, 0.11, 40 + goldenAngle * at);
}

const goldenAngle = 180 * (3 - Math.sqrt(5));

// Converts from the polar form of Björn Ottosson's OKLab: lightness 0 to 1, chroma, hue in degrees.
function oklch(lightness: number, chroma: number, hue: number): string {
  const angle = (hue * Math.PI) / 180;
  const [a, b] = [chroma * Math.cos(angle), chroma * Math.sin(angle)];
  const l = (lightness + 0.3963377774 * a + 0.2158037573 * b) ** 3;
  const m = (lightness - 0.1055613458 * a - 0.0638541728 * b) ** 3;
  const s = (lightness - 0.0894841775 * a - 1.291485548 * b) ** 3;
  const linear = [
    4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s,
    -1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s,
    -0.0041960863 * l - 0.7034186147 * m + 1.707614701 * s,
  ];
  return `#${linear.map(byteOf).join("")}`;
}

// Converts linear light to two hexadecimal digits of sRGB.
function byteOf(light: number): string {
  const inside = Math.min(1, Math.max(0, light));
  const coded = inside <= 0.0031308 ? 12.92 * inside : 1.055 * inside ** (1 / 2.4) - 0.055;
  return Math.round(255 * coded)
    .toString(16)
    .padStart(2, "0");
}
