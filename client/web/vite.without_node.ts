import type { Plugin } from "vite";

// Draco's loader imports node modules that it does not use in a browser.
export function withoutNode(): Plugin {
  return {
    name: "without-node",
    enforce: "pre",
    resolveId: (id) => (id === "fs" || id === "path" ? "\0none" : null),
    load: (id) => (id === "\0none" ? "export default {};" : null),
  };
}
