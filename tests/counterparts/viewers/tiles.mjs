// Shows 3D Tiles in 3d-tiles-renderer, with the token in a header field, and in CesiumJS, with the token in the
// address: nothing fails, approaching loads finer tiles, and the finest level is complete when all of it is requested.
//
//   node tiles.mjs TOKEN DATASET/iso/SETTINGS HTTPS-URL...
import assert from "node:assert/strict";

import { inChromium, origin, picture, settled } from "./in_chromium.mjs";
import { leavesOf } from "./trees.mjs";

const [token, tree, ...listeners] = process.argv.slice(2);
const leaves = await leavesOf(`${listeners[0]}/v1/3dtiles/${tree}/tileset.json`, token);
assert(leaves.tiles > 8, "more than two levels");

const viewers = {
  tiles: (listener) => [`${listener}/v1/3dtiles/${tree}/tileset.json`, token],
  cesium: (listener) => [`${listener}/v1/token/${token}/3dtiles/${tree}/tileset.json`],
};

await inChromium(async (page, failure) => {
  for (const [number, listener] of listeners.entries()) {
    for (const [viewer, words] of Object.entries(viewers)) {
      await page.goto(`${origin}/${viewer}.html`);
      await page.waitForFunction("window.counterpart");
      await page.evaluate((words) => window.counterpart.open(...words), words(listener));
      const look = async (radii, error, name) => {
        await page.evaluate(([radii, error]) => window.counterpart.look(radii, error), [radii, error]);
        await settled(page, () => page.evaluate("!counterpart.isBusy()"));
        await picture(page, `${viewer}_${number}_${name}`);
        const facts = await page.evaluate("counterpart.facts()");
        console.log(`${viewer} ${name}: ${facts.tiles} tiles, ${facts.triangles} triangles`);
        failure.push(...facts.failed);
        return facts;
      };
      const far = await look(40, 16, "far");
      const near = await look(1.2, 16, "near");
      const all = await look(3, 1e-3, "all");
      assert.equal(far.tiles, 1, `${viewer}: from afar the first tile is enough`);
      assert(near.tiles > 1 && near.triangles > far.triangles, `${viewer}: more comes when the camera is near`);
      assert.deepEqual([all.tiles, all.triangles], [leaves.tiles, leaves.triangles], `${viewer}: nothing is missing`);
    }
  }
});
