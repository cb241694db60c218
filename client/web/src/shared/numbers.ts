// Numbers as text. A number is written with the resolution that it was made with: a coordinate with that of the grid, a
// time with that of its series; only sizes and errors have a fixed number of significant digits (quantities.ts).

// Rounds to the power of ten that is at most `resolution`; 0 or less: not at all.
export function rounded(value: number, resolution: number): number {
  if (!(resolution > 0) || !Number.isFinite(value)) return value;
  const decimals = -Math.floor(Math.log10(resolution) + 1e-9);
  if (decimals > 0) return Number(value.toFixed(Math.min(100, decimals))) + 0; // Not -0.
  return Math.round(value / 10 ** -decimals) * 10 ** -decimals + 0;
}

// 5400012.3456 with the resolution 0.005 -> "5400012.346".
export function inResolution(value: number, resolution: number): string {
  return String(rounded(value, resolution));
}

// Returns the resolution for a value among others that span `span`: three digits of the span, and at least four of the
// value.
export function resolutionWithin(value: number, span: number): number {
  const own = Math.abs(value) / 1000;
  return span > 0 ? Math.min(span / 100, own) : own;
}
