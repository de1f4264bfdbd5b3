import { defineConfig } from "vitest/config";

// One browser, one test at a time: pictures are drawn in software here.
export default defineConfig(({ mode }) => ({
  test: {
    include: [mode === "bench" ? "e2e/bench.ts" : "e2e/**/*.e2e.ts"],
    root: new URL("..", import.meta.url).pathname,
    environment: "node",
    testTimeout: 240_000,
    hookTimeout: 120_000,
    fileParallelism: false,
    reporters: ["verbose"],
  },
}));
