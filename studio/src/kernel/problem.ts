import type { Problem } from "./api";

/** A message as a sentence of its own. */
export function sentence(text: string): string {
  return text === "" ? "" : text[0]!.toUpperCase() + text.slice(1) + (/[.!?…)\]]$/.test(text) ? "" : ".");
}

/** Whatever a call was rejected with, as a message for people. */
export function problemOf(error: unknown): Problem {
  if (typeof error === "object" && error !== null && "message" in error) {
    const { message, help, repairs, cancelled } = error as Partial<Problem>;
    return {
      message: String(message),
      help: help ?? null,
      repairs: repairs ?? [],
      cancelled: cancelled === true,
    };
  }
  return { message: String(error), help: null, repairs: [], cancelled: false };
}
