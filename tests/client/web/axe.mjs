// Expects axe-core to find nothing serious in a page.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { createRequire } from "node:module";

const installed = createRequire(new URL("../../../client/web/package.json", import.meta.url));
const axe = readFileSync(installed.resolve("axe-core"), "utf8");

export async function examine(page) {
  // The page's policy forbids external scripts, but not evaluated code.
  await page.evaluate(axe);
  const { violations } = await page.evaluate(() => window.axe.run());
  const serious = violations.filter(({ impact }) => impact === "serious" || impact === "critical");
  const words = serious.map(({ id, help, nodes }) => `${id}: ${help}: ${nodes.slice(0, 4).map(({ html, failureSummary }) => `${html.slice(0, 160)} ${failureSummary}`).join(" | ")}`);
  assert.deepEqual(words, []);
  console.log(`     ${violations.length} lesser findings: ${violations.map(({ id }) => id).join(", ")}`);
}
