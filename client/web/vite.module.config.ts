import { defineConfig, type Plugin } from "vite";

import { withoutNode } from "./vite.without_node";

// Nests all styles in the viewer's element, so that they change nothing else of a page.
export function scoped(): Plugin {
  return {
    name: "scoped",
    enforce: "pre",
    transform(code, id) {
      if (!/\.css(\?inline)?$/.test(id)) return null;
      const inside = code
        .replaceAll(":root", "&")
        .replaceAll(".multitetra", "&")
        .replace(/^\[data-theme/gm, "&[data-theme");
      return `.multitetra {\n${inside}\n}`;
    },
  };
}

// The module `multitetra-viewer`, described in package.json. Its workers are separate files.
export default defineConfig({
  base: "./",
  publicDir: false,
  plugins: [scoped(), withoutNode()],
  build: {
    outDir: "module",
    target: "es2022",
    cssTarget: "chrome111", // Without nesting.
    lib: { entry: "src/module.ts", formats: ["es"], fileName: "multitetra-viewer", cssFileName: "style" },
  },
  worker: { format: "es", plugins: () => [withoutNode()] },
});
