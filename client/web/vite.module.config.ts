import { defineConfig } from "vite";

import { withoutNode } from "./vite.without_node";

// The module `multitetra-viewer`, described in package.json. Its workers are separate files.
export default defineConfig({
  base: "./",
  publicDir: false,
  plugins: [withoutNode()],
  build: {
    outDir: "module",
    target: "es2022",
    lib: { entry: "src/viewer.ts", formats: ["es"], fileName: "multitetra-viewer", cssFileName: "style" },
  },
  worker: { format: "es", plugins: () => [withoutNode()] },
});
