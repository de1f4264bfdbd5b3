// Light, dark or high contrast: as the system says, or as chosen.

import { signal } from "@preact/signals";
import type { Theme } from "./state/settings";

export type Look = Exclude<Theme, "auto">;

/** The look that is on. */
export const look = signal<Look>("light");

export function lookOf(theme: Theme, prefersDark: boolean, prefersContrast: boolean): Look {
  if (theme !== "auto") return theme;
  if (prefersContrast) return "contrast";
  return prefersDark ? "dark" : "light";
}

/** Keeps the page in step with the system; call again when the theme is chosen anew. */
export function applyTheme(theme: Theme): void {
  const next = lookOf(theme, query("(prefers-color-scheme: dark)"), query("(prefers-contrast: more)"));
  document.documentElement.dataset["theme"] = next;
  look.value = next;
}

export function watchSystem(theme: () => Theme): void {
  for (const media of ["(prefers-color-scheme: dark)", "(prefers-contrast: more)"]) {
    matchMedia(media).addEventListener("change", () => applyTheme(theme()));
  }
}

function query(media: string): boolean {
  return matchMedia(media).matches;
}
