// Shows slices and a surface in neuroglancer in Chromium: all chunks arrive, nothing fails, and along each axis the
// section and the surface of a body cover the same pixels.
//
//   node slices.mjs TOKEN HTTPS-URL...
//
// The body is that of make_lump.py: dataset "lump", isovalue 0.
import assert from "node:assert/strict";

import { inChromium, origin, picture, settled } from "./in_chromium.mjs";

const [token, ...listeners] = process.argv.slice(2);
const kSegment = (1n << 63n).toString(); // The bits of -0, which represents 0.
const kMiddle = [50.5, 18.5, 57.5]; // In voxels, from the origin of the world.
const kDimensions = { x: [0.0005, "m"], y: [0.00075, "m"], z: [0.00125, "m"] }; // The size of a voxel.
const kScale = 0.15; // One pixel per smallest side of a voxel.
const kAlongAxes = { z: [0, 0, 0, 1], y: [Math.SQRT1_2, 0, 0, Math.SQRT1_2], x: [0, Math.SQRT1_2, 0, Math.SQRT1_2] };

function layers(listener) {
  const folder = `precomputed://${listener}/v1/token/${token}/neuroglancer/lump`;
  const shader = "void main() { emitRGB(toRaw(getDataValue()) > 0.0 ? vec3(1, 0, 0) : vec3(0, 0, 0.3)); }";
  return [
    { type: "image", name: "image", source: `${folder}/image`, shader },
    {
      type: "segmentation",
      name: "surface",
      source: `${folder}/surfaces,error=0`,
      segments: [kSegment],
      segmentColors: { [kSegment]: "#00ff00" },
    },
  ];
}

async function show(page, state) {
  await page.goto("about:blank");
  const look = { dimensions: kDimensions, position: kMiddle, showAxisLines: false, showScaleBar: false, showDefaultAnnotations: false };
  await page.goto(`${origin}/neuroglancer.html#!${encodeURIComponent(JSON.stringify({ ...look, ...state }))}`);
  await page.waitForFunction("window.pieces");
  await settled(page, async () => {
    const pieces = await page.evaluate("pieces()");
    return pieces.length === state.layers.length && pieces.every(({ needed, there }) => needed > 0 && needed === there);
  });
}

// The bounding box of all pixels in which red, green or blue (0, 1, 2) dominates, in the largest central square of the
// only panel; labels are outside this square.
async function box(page, color) {
  const panel = await page.locator(".neuroglancer-rendered-data-panel").boundingBox();
  const side = Math.min(panel.height, panel.width - 300);
  const clip = { x: panel.x + (panel.width - side) / 2, y: panel.y + (panel.height - side) / 2, width: side, height: side };
  const png = (await page.screenshot({ clip })).toString("base64");
  return page.evaluate(
    async ([png, color]) => {
      const bitmap = await createImageBitmap(await (await fetch(`data:image/png;base64,${png}`)).blob());
      const { width, height } = bitmap;
      const context = new OffscreenCanvas(width, height).getContext("2d");
      context.drawImage(bitmap, 0, 0);
      const { data } = context.getImageData(0, 0, width, height);
      const found = { left: width, top: height, right: -1, bottom: -1 };
      for (let at = 0; at < data.length; at += 4) {
        const others = Math.max(data[at + ((color + 1) % 3)], data[at + ((color + 2) % 3)]);
        if (data[at + color] < 40 || data[at + color] < 4 * others) continue;
        const [x, y] = [(at / 4) % width, Math.floor(at / 4 / width)];
        found.left = Math.min(found.left, x);
        found.right = Math.max(found.right, x);
        found.top = Math.min(found.top, y);
        found.bottom = Math.max(found.bottom, y);
      }
      return found;
    },
    [png, color],
  );
}

await inChromium(async (page) => {
  for (const [number, listener] of listeners.entries()) {
    const [image, surface] = layers(listener);
    for (const [axis, orientation] of Object.entries(kAlongAxes)) {
      await show(page, {
        layers: [image],
        layout: "xy",
        crossSectionScale: kScale,
        crossSectionOrientation: orientation,
      });
      await picture(page, `neuroglancer_${number}_section_${axis}`);
      const section = await box(page, 0);
      const height = await page.evaluate(() => document.querySelector(".neuroglancer-rendered-data-panel").clientHeight);
      await show(page, {
        layers: [surface],
        layout: { type: "3d", orthographicProjection: true },
        projectionScale: kScale * height,
        projectionOrientation: orientation,
      });
      await picture(page, `neuroglancer_${number}_surface_${axis}`);
      const body = await box(page, 1);
      console.log(`along ${axis}: section ${JSON.stringify(section)}, surface ${JSON.stringify(body)}`);
      assert(section.right - section.left > 100);
      for (const [side, place] of Object.entries(section)) {
        assert(Math.abs(place - body[side]) <= 2, `along ${axis}: ${side} is ${place} of the section, ${body[side]}`);
      }
    }
    await show(page, { layers: [image, surface], layout: "4panel", crossSectionScale: 0.3, projectionScale: 150 });
    await picture(page, `neuroglancer_${number}_all`);
  }
});
