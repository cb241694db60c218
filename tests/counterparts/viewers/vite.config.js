import { defineConfig } from "vite";

// Neuroglancer's icons come from a commit on GitHub; the npm package lacks some. They are replaced by empty ones.
function withoutIcons() {
  return {
    name: "without-icons",
    enforce: "pre",
    resolveId: (name) => (name.startsWith("ikonate/") ? `\0${name}` : null),
    load: (id) => (id.startsWith("\0ikonate/") ? 'export default "<svg></svg>"' : null),
  };
}

export default defineConfig({
  root: "pages",
  base: "./",
  plugins: [withoutIcons()],
  worker: { format: "es" },
  build: {
    outDir: "../built",
    emptyOutDir: true,
    target: "esnext",
    minify: false,
    chunkSizeWarningLimit: 1e6,
    rollupOptions: { input: ["pages/tiles.html", "pages/cesium.html", "pages/neuroglancer.html"] },
  },
});
