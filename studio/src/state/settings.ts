// How things are shown: kept with the document and over reloads, but nothing to undo.

import { signal } from "@preact/signals";
import type { Colouring } from "../kernel/api";
import { STREAM_SHOWN, type StreamShown } from "../stream/shown";

/** `wire` is the surface as its edges alone. */
export type Shading = "shaded" | "wire" | "zebra" | "reflection";
/** The axis that points up on the screen. */
export type Up = "y" | "z";
export type Theme = "auto" | "light" | "dark" | "contrast";

export interface Shown {
  surface: boolean;
  /** Edges of the polygons of the surface. */
  surfaceEdges: boolean;
  /** Edges of the given mesh, drawn on the surface. */
  patches: boolean;
  /** The given mesh as edges, and its vertices. */
  edges: boolean;
  points: boolean;
  /** The given mesh as flat faces. */
  faces: boolean;
  control: boolean;
  boundary: boolean;
  creases: boolean;
}

export interface Settings {
  shading: Shading;
  colouring: Colouring | null;
  shown: Shown;
  /** What the streamline workspace shows. */
  stream: StreamShown;
  up: Up;
  theme: Theme;
}

export const DEFAULTS: Settings = {
  shading: "shaded",
  colouring: null,
  shown: {
    surface: true,
    surfaceEdges: false,
    patches: true,
    edges: false,
    points: true,
    faces: false,
    control: false,
    boundary: true,
    creases: true,
  },
  stream: STREAM_SHOWN,
  up: "y",
  theme: "auto",
};

export const settings = signal<Settings>(DEFAULTS);

export function change(part: Partial<Settings>): void {
  settings.value = { ...settings.value, ...part };
}

export function show(part: Partial<Shown>): void {
  change({ shown: { ...settings.value.shown, ...part } });
}

export function showStream(part: Partial<StreamShown>): void {
  change({ stream: { ...settings.value.stream, ...part } });
}

/** Settings from a file, of which anything may be missing or new. */
export function adopt(part: Partial<Settings>): void {
  const shown = { ...DEFAULTS.shown, ...part.shown };
  const stream = { ...DEFAULTS.stream, ...part.stream };
  settings.value = { ...DEFAULTS, ...part, shown, stream, theme: settings.value.theme };
}
