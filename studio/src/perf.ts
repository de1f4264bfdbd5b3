// How long things take, for the hidden panel.

import { signal } from "@preact/signals";

/** `kernel` is what a drag takes there, without the way to the worker and back. */
export type Measure = "open" | "fit" | "surface" | "drag" | "kernel" | "frame";
export const MEASURES: readonly Measure[] = ["open", "fit", "surface", "drag", "kernel", "frame"];

const KEPT = 60;
const times = new Map<Measure, number[]>();
/** Changes with every measurement while somebody looks. */
export const measured = signal(0);
export const panelOpen = signal(false);

export function record(what: Measure, milliseconds: number): void {
  const list = times.get(what) ?? [];
  list.push(milliseconds);
  if (list.length > KEPT) list.shift();
  times.set(what, list);
  if (panelOpen.peek()) measured.value = measured.peek() + 1;
}

/** Median of the last 60, the last, and how many there are; null if there is none. */
export function summary(what: Measure): { median: number; last: number; count: number } | null {
  const list = times.get(what);
  if (!list?.length) return null;
  const sorted = [...list].sort((a, b) => a - b);
  const half = sorted.length >> 1;
  const median = sorted.length % 2 ? sorted[half]! : (sorted[half - 1]! + sorted[half]!) / 2;
  return { median, last: list.at(-1)!, count: list.length };
}

export async function timed<T>(what: Measure, work: Promise<T>): Promise<T> {
  const start = performance.now();
  const result = await work;
  record(what, performance.now() - start);
  return result;
}
