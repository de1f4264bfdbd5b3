import type { Kernel } from "./api";

/** The kernel in a worker of its own. */
export function createKernel(): Kernel {
  throw new Error("this page was built without the kernel: run `cargo xtask wasm` first");
}
