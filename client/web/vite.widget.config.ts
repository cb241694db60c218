import { defineConfig, type Plugin } from "vite";

import { scoped } from "./vite.module.config";
import { withoutNode } from "./vite.without_node";

// Puts workers into the file itself: a notebook has no other files.
function inlineWorkers(): Plugin {
  return {
    name: "inline-workers",
    enforce: "pre",
    transform(code, id) {
      if (!id.endsWith(".ts")) return null;
      const names: string[] = [];
      const inside = code.replace(
        /new Worker\(new URL\("(\.\/\w+)\.ts", import\.meta\.url\), \{ type: "module"(.*?) \}\)/g,
        (_, file: string, name: string) => {
          names.push(file);
          return `new InlineWorker${names.length}({${name.slice(1)}})`;
        },
      );
      const imports = names.map((file, i) => `import InlineWorker${i + 1} from "${file}.ts?worker&inline";\n`);
      return names.length > 0 ? imports.join("") + inside : null;
    },
  };
}

// The viewer as one file, for the Python package's widget.
export default defineConfig({
  publicDir: false,
  plugins: [inlineWorkers(), scoped(), withoutNode()],
  build: {
    outDir: process.env.MULTITETRA_WIDGET_OUT ?? "widget",
    emptyOutDir: true,
    target: "es2022",
    cssTarget: "chrome111", // Without nesting.
    assetsInlineLimit: 1 << 24,
    lib: { entry: "src/notebook/widget.ts", formats: ["es"], fileName: "widget" },
    rollupOptions: { output: { inlineDynamicImports: true } },
  },
  worker: { format: "es", plugins: () => [withoutNode()], rollupOptions: { output: { inlineDynamicImports: true } } },
});
