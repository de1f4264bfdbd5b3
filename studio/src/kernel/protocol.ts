// What client and worker say to each other: one call at a time, with its answer or what went wrong.

import type { Problem } from "./api";

/** Names of the calls; their arguments are those of `Kernel` in api.ts. */
export type Call = { id: number; name: string; args: unknown[] };

export type Message =
  /** The kernel is ready for calls. */
  | { kind: "ready" }
  /** The kernel cannot start. */
  | { kind: "broken"; problem: Problem }
  | { kind: "progress"; id: number; steps: unknown[] }
  | { kind: "answer"; id: number; value: unknown }
  /** `fatal` if the kernel cannot go on: a fault of ours. */
  | { kind: "problem"; id: number; problem: Problem; fatal: boolean };

/** Sent before all calls: the compiled module, so that another worker need not compile it again. */
export type Start = { kind: "start"; module: WebAssembly.Module };

export function problem(message: string, help: string | null = null): Problem {
  return { message, help, repairs: [], cancelled: false };
}
