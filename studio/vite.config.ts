import { defineConfig } from "vitest/config";

export default defineConfig({
  // Relative addresses, so that the page works in any folder of any static host.
  base: "./",
  // The folder stays, for the command that carries it; the script `build` empties it.
  build: { emptyOutDir: false, target: "es2023", sourcemap: false, chunkSizeWarningLimit: 1500 },
  worker: { format: "es" },
  test: { include: ["tests/**/*.test.ts"], environment: "node" },
});
