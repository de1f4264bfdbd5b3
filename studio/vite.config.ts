import { defineConfig } from "vitest/config";

export default defineConfig({
  // Relative addresses, so that the page works in any folder of any static host.
  base: "./",
  build: { target: "es2023", sourcemap: false, chunkSizeWarningLimit: 1500 },
  worker: { format: "es" },
  test: { include: ["tests/**/*.test.ts"], environment: "node" },
});
