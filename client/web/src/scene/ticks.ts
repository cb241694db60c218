import { rounded } from "../shared/numbers";

// Returns the greatest round length, 1, 2 or 5 times a power of ten, up to `maxLength`; NaN unless that is positive.
export function roundLength(maxLength: number): number {
  const magnitude = 10 ** Math.floor(Math.log10(maxLength));
  return [5, 2, 1].map((n) => n * magnitude).find((value) => value <= maxLength) ?? magnitude;
}

export interface Tick {
  value: number;
  text: string;
}

// Returns about `count` round numbers from `low` to `high`, inclusive; empty for an empty range.
export function ticks(low: number, high: number, count: number): Tick[] {
  const raw = (high - low) / Math.max(1, count);
  if (!(raw > 0) || !Number.isFinite(raw)) return [];
  const magnitude = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 5, 10].map((n) => n * magnitude).find((value) => value >= raw * 0.999)!;
  const first = Math.ceil(low / step - 1e-9);
  const last = Math.floor(high / step + 1e-9);
  // Multiples instead of sums, so that errors do not accumulate.
  const values = Array.from({ length: last - first + 1 }, (_, i) => rounded((first + i) * step, step));
  return values.map((value) => ({ value, text: String(value) }));
}
