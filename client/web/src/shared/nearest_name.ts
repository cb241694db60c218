// Finds the name that was probably meant, for "did you mean".

// Returns null if no name is similar. Ignores case; up to a third of the letters may differ.
export function nearestName(given: string, names: readonly string[]): string | null {
  const distances = names.map((name) => editDistance(given.toLowerCase(), name.toLowerCase()));
  const least = Math.min(...distances);
  const longest = Math.max(given.length, names[distances.indexOf(least)]?.length ?? 0);
  return least <= Math.max(1, Math.floor(longest / 3)) ? names[distances.indexOf(least)] : null;
}

// Counts insertions, deletions, replacements and swaps of adjacent letters.
function editDistance(a: string, b: string): number {
  const rows = [Array.from({ length: b.length + 1 }, (_, j) => j)];
  for (let i = 1; i <= a.length; ++i) {
    const row = [i];
    for (let j = 1; j <= b.length; ++j) {
      const replaced = rows[i - 1][j - 1] + (a[i - 1] === b[j - 1] ? 0 : 1);
      row.push(Math.min(replaced, rows[i - 1][j] + 1, row[j - 1] + 1));
      const isSwap = i > 1 && j > 1 && a[i - 1] === b[j - 2] && a[i - 2] === b[j - 1];
      if (isSwap) row[j] = Math.min(row[j], rows[i - 2][j - 2] + 1);
    }
    rows.push(row);
  }
  return rows[a.length][b.length];
}
