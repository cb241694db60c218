import { fileURLToPath } from "node:url";
import { defineConfig } from "vitest/config";

// The tests are in tests/client/web.
export default defineConfig({
  server: { fs: { strict: false } },
  test: { testTimeout: 30_000, globals: true, root: fileURLToPath(new URL("../../tests/client/web", import.meta.url)) },
});
