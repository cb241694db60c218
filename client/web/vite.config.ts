import { existsSync, readdirSync, readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { brotliCompressSync, gzipSync } from "node:zlib";
import { defineConfig, type Plugin } from "vite";

import { withoutNode } from "./vite.without_node";

// What a package has compiled in, beside its own license.
const parts: Record<string, string> = {
  numcodecs: `It contains, compiled:
c-blosc, BSD-3-Clause, https://github.com/Blosc/c-blosc/blob/main/LICENSE.txt
LZ4, BSD-2-Clause, https://github.com/lz4/lz4/blob/dev/lib/LICENSE
Zstandard, BSD-3-Clause, https://github.com/facebook/zstd/blob/dev/LICENSE
Snappy, BSD-3-Clause, https://github.com/google/snappy/blob/main/COPYING
zlib, Zlib, https://zlib.net/zlib_license.html
`,
};

// Adds the licenses of bundled packages.
function thirdParty(packages: string[]): Plugin {
  const text = packages.map((name) => {
    const folder = new URL(`node_modules/${name}/`, import.meta.url);
    const { version, license } = JSON.parse(readFileSync(new URL("package.json", folder), "utf8")) as { version: string; license: string };
    const file = readdirSync(folder).find((entry) => /^licen[cs]e/i.test(entry));
    const ours = new URL("../../LICENSE", import.meta.url);
    const isApache = license.startsWith("Apache-2.0") && existsSync(ours);
    const words = file ? readFileSync(new URL(file, folder), "utf8") : isApache ? readFileSync(ours, "utf8") : license;
    return [`${name} ${version} (${license})\n\n${words.trim()}\n`, ...(parts[name] ? [parts[name]] : [])].join("\n");
  });
  return {
    name: "third-party",
    generateBundle() {
      const source = text.join(`\n${"=".repeat(80)}\n\n`);
      this.emitFile({ type: "asset", fileName: "THIRD_PARTY.txt", source });
    },
  };
}

// Adds compressed copies of the files, for browsers that accept them.
function compressed(): Plugin {
  return {
    name: "compressed",
    writeBundle({ dir }, bundle) {
      for (const name of Object.keys(bundle).filter((file) => /\.(html|js|css|wasm)$/.test(file))) {
        const bytes = readFileSync(join(dir!, name));
        if (bytes.length < 2000) continue;
        writeFileSync(join(dir!, `${name}.gz`), gzipSync(bytes, { level: 9 }));
        writeFileSync(join(dir!, `${name}.br`), brotliCompressSync(bytes));
      }
    },
  };
}

// Loads the page itself, an import of the entry, together with the entry, and before the document is complete.
function scriptOfPage(): Plugin {
  return {
    name: "script-of-page",
    transformIndexHtml: {
      order: "post",
      handler: (_, { bundle }) =>
        Object.values(bundle ?? {}).flatMap((one) =>
          one.type === "chunk" && one.facadeModuleId?.endsWith("/src/main.ts")
            ? [{ tag: "script", attrs: { type: "module", crossorigin: true, src: `./${one.fileName}` }, injectTo: "head" as const }]
            : [],
        ),
    },
  };
}

// MULTITETRA_VIEWER_OUT names the folder served by the server's HTTP port; build.sh sets it.
export default defineConfig({
  base: "./",
  plugins: [withoutNode(), scriptOfPage(), thirdParty(["three", "draco3d", "@bufbuild/protobuf", "hash-wasm", "mediabunny", "numcodecs"]), compressed()],
  build: {
    outDir: process.env.MULTITETRA_VIEWER_OUT ?? "dist",
    emptyOutDir: true,
    target: "es2022",
    assetsInlineLimit: 0,
    chunkSizeWarningLimit: 1200,
  },
  worker: { format: "es", plugins: () => [withoutNode()] },
});
