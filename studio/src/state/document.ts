// What a person made: everything that is undone, saved and restored. Plain data, never changed in place.

import type { Design, Fineness, MeshInfo, Triple } from "../kernel/api";
import { NONE, type Indices } from "./indices";

/** A file as it was opened. */
export interface Source {
  name: string;
  bytes: Uint8Array;
  /** Where to look from at first, if that is known. */
  look?: Triple;
  /** Which axis points up in it, if that is known. */
  up?: "y" | "z";
}

export interface MeshDocument {
  source: Source;
  /** Repairs to run on it, by the names of the kernel. */
  repairs: readonly string[];
  design: Design;
  /** Other settings for the same mesh, to look at side by side. */
  compare: Design | null;
  fineness: Fineness;
  /** What is selected of the given mesh. */
  faces: Indices;
  vertices: Indices;
  /** Selected edges, by the kernel's numbers. */
  edges: Indices;
}

export interface Document {
  mesh: MeshDocument | null;
  /** A whole `*.streamline.json`; the streamline workspace says what is in it. */
  model: unknown;
}

export const EMPTY: Document = { mesh: null, model: null };

export function designFor(info: Pick<MeshInfo, "scheme" | "creases">): Design {
  return {
    scheme: info.scheme,
    method: "auto",
    tolerance: 1e-6,
    iterations: 500,
    exact: false,
    fair: null,
    corners: "smooth",
    border: "bspline",
    tension: null,
    tensions: [],
    creases: info.creases,
    moves: [],
  };
}

export const FINENESS: Fineness = { levels: 3, limit: true };

export function meshDocument(
  source: Source,
  repairs: readonly string[],
  design: Design,
  levels = FINENESS.levels,
): MeshDocument {
  const fineness = { ...FINENESS, levels };
  return { source, repairs, design, compare: null, fineness, faces: NONE, vertices: NONE, edges: NONE };
}

/** Steps that keep the surface below about 200 000 triangles, so that everything stays quick; 0 for fine meshes. */
export function suitableLevels(faceCount: number, mostCorners: number): number {
  const triangles = Math.max(1, faceCount) * (mostCorners > 3 ? 2 : 1);
  const levels = Math.floor(Math.log(200_000 / triangles) / Math.log(4));
  return Math.min(4, Math.max(0, levels));
}

/** `moves` with `news` in place of what was there for the same vertices. */
export function withMoves(moves: Design["moves"], news: Design["moves"]): Design["moves"] {
  const of = new Map(moves.map((move) => [move[0], move]));
  for (const move of news) of.set(move[0], move);
  return [...of.values()].sort((a, b) => a[0] - b[0]);
}

/** `creases` with edges set to `sharpness`, 0 taking the mark away and -1 meaning sharp for ever. */
export function withCreases(
  creases: Design["creases"],
  edges: Iterable<readonly [number, number]>,
  sharpness: number,
): Design["creases"] {
  const key = (a: number, b: number) => (a < b ? `${a} ${b}` : `${b} ${a}`);
  const of = new Map(creases.map((crease) => [key(crease[0], crease[1]), crease]));
  for (const [a, b] of edges) {
    if (sharpness === 0) of.delete(key(a, b));
    else of.set(key(a, b), [Math.min(a, b), Math.max(a, b), sharpness]);
  }
  return [...of.values()].sort((a, b) => a[0] - b[0] || a[1] - b[1]);
}
