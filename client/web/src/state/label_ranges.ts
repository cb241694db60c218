// Sets of labels as text, for addresses: "1-322,-17" is 1 to 322 without 17, "-17" all but 17, "none" the empty set.

const item = /^(-?)(\d+)(?:-(\d+))?$/;
const none = "none";

// The labels of the shown segmentation, or "organs:1-3": those of a named one; "organs:": its first ones.
export interface NamedLabels {
  series: string; // Empty: not named.
  ranges: string; // Empty: the labels that are shown by default.
}

// Returns null if the text is malformed.
export function parseLabels(text: string): NamedLabels | null {
  const at = text.lastIndexOf(":");
  const ranges = text.slice(at + 1);
  const isValid = ranges === none || (ranges === "" && at > 0) || ranges.split(",").every((one) => item.test(one));
  return isValid && at !== 0 ? { series: text.slice(0, Math.max(0, at)), ranges } : null;
}

// `all` must be ascending. Returns null if labels cannot be written this way.
export function labelRanges(all: readonly number[], shown: ReadonlySet<number>): string | null {
  if (!all.every((value) => Number.isInteger(value) && value >= 0)) return null;
  const ranges = (isIn: (value: number) => boolean, sign: string) =>
    runsOf(all, isIn).map(([first, last]) => sign + (first === last ? String(first) : `${first}-${last}`));
  const named = ranges((value) => shown.has(value), "").join(",") || none;
  const others = ranges((value) => !shown.has(value), "-");
  const without = [`${all[0]}-${all[all.length - 1]}`, ...others].join(",");
  return others.length > 0 && without.length < named.length ? without : named;
}

// Returns the labels in `all` that the text includes; ignores unknown labels.
export function labelsOfRanges(text: string, all: readonly number[]): Set<number> {
  const words = text === none ? [] : text.split(",");
  const shown = new Set(words[0]?.startsWith("-") ? all : []);
  for (const word of words) {
    const [, sign, first, last = first] = item.exec(word) ?? [];
    const inside = all.filter((value) => Number(first) <= value && value <= Number(last));
    for (const value of inside) sign ? shown.delete(value) : shown.add(value);
  }
  return shown;
}

// Returns first and last of each run of consecutive entries of `all`.
function runsOf(all: readonly number[], isIn: (value: number) => boolean): [number, number][] {
  const runs: [number, number][] = [];
  all.forEach((value, at) => {
    if (!isIn(value)) return;
    const isNext = at > 0 && runs.length > 0 && runs[runs.length - 1][1] === all[at - 1];
    if (isNext) runs[runs.length - 1][1] = value;
    else runs.push([value, value]);
  });
  return runs;
}
