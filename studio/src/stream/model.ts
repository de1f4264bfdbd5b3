// A model file as plain data, and states of it that differ in one thing. Fields as in docs/streamline.schema.json.

import type { PatchInfo, Triple } from "../kernel/api";

export type PatchScheme = "doo-sabin" | "catmull-clark" | "kobbelt";

export interface Polyline {
  type: "polyline";
  points: Triple[];
  t: number[];
}

export interface Bspline {
  type: "bspline";
  points: Triple[];
  degree: number;
  knots?: number[];
  t0: number;
  t1: number;
}

export interface Nurbs extends Omit<Bspline, "type"> {
  type: "nurbs";
  weights: number[];
}

export interface Qi {
  type: "qi";
  tangents: Triple[];
  order: number;
  knots?: "clamped" | "uniform";
  length: number;
  start?: Triple;
  t0: number;
  t1: number;
}

export type Initial = Polyline | Bspline | Nurbs | Qi;
export type InitialType = Initial["type"];

export type Start = "min" | "max" | number | { fraction: number };

export type LengthFunction =
  | { type: "polyline"; lengths: number[]; t: number[] }
  | { type: "bspline"; lengths: number[]; degree: number; t0: number; t1: number };

export interface Detail {
  level: number;
  row: number;
  column: number;
  predicted: Triple;
  tangent: Triple;
}

export interface Patch {
  name?: string;
  tangents: Triple[][];
  s?: number[][];
  lengths?: number[];
  t: number[];
  scheme?: PatchScheme;
  order?: "st" | "ts";
  ends?: "natural" | "clamped";
  w?: number;
  depth?: number;
  initial: Initial;
  s0?: Start;
  length?: LengthFunction;
  integration?: "midpoint" | "arcs";
  blend?: "pairs" | "mean";
  details?: Detail[];
}

export type Stitch = false | true | "smooth";

interface Several {
  name?: string;
  patches: Patch[];
  stitch?: Stitch;
}

/** A place in the grid of control tangents of a patch. */
export interface Place {
  row: number;
  column: number;
}

function several(model: unknown): Several | null {
  return isObject(model) && Array.isArray((model as Partial<Several>).patches) ? (model as Several) : null;
}

function isObject(value: unknown): value is object {
  return typeof value === "object" && value !== null;
}

/** The patches of a model as the kernel completed it; none for what is no model. */
export function patchesOf(model: unknown): readonly Patch[] {
  const many = several(model);
  if (many) return many.patches;
  return isObject(model) && Array.isArray((model as Partial<Patch>).tangents) ? [model as Patch] : [];
}

export function nameOf(model: unknown): string {
  const name = isObject(model) ? (model as { name?: unknown }).name : undefined;
  return typeof name === "string" && name !== "" ? name : "model";
}

export function stitchOf(model: unknown): Stitch {
  return several(model)?.stitch ?? false;
}

export function withStitch(model: unknown, stitch: Stitch): unknown {
  return several(model) ? { ...(model as Several), stitch } : model;
}

/** The model with a patch changed. A field that is `undefined` is left out. */
export function withPatch(model: unknown, index: number, part: Partial<Record<keyof Patch, unknown>>): unknown {
  const change = (patch: Patch): Patch => {
    const next: Record<string, unknown> = { ...patch, ...part };
    for (const [key, value] of Object.entries(part)) if (value === undefined) delete next[key];
    return next as unknown as Patch;
  };
  const many = several(model);
  if (!many) return change(model as Patch);
  return { ...many, patches: many.patches.map((patch, i) => (i === index ? change(patch) : patch)) };
}

/** The model with the same fields in every patch, for those that stitched patches share. */
export function withAllPatches(model: unknown, part: Partial<Patch>): unknown {
  return patchesOf(model).reduce<unknown>((next, _, i) => withPatch(next, i, part), model);
}

export function tangentOf(model: unknown, index: number, { row, column }: Place): Triple | null {
  return patchesOf(model)[index]?.tangents[row]?.[column] ?? null;
}

/** The model with one control tangent changed; everything else is the same objects. */
export function withTangent(model: unknown, index: number, { row, column }: Place, tangent: Triple): unknown {
  const patch = patchesOf(model)[index];
  if (!patch) return model;
  const line = replaced(patch.tangents[row]!, column, tangent);
  return withPatch(model, index, { tangents: replaced(patch.tangents, row, line) });
}

/**
 * Where the tangent at a place of a patch is decided: stitched patches take their first streamline from the one
 * before. Null for the second streamline of patches that go on smoothly, which follows from those.
 */
export function ownerOf(model: unknown, patch: number, place: Place): { patch: number; place: Place } | null {
  const stitch = stitchOf(model);
  if (stitch === false || patch === 0) return { patch, place };
  if (place.row === 1 && stitch === "smooth") return null;
  if (place.row > 0) return { patch, place };
  const before = patchesOf(model)[patch - 1];
  if (!before) return { patch, place };
  return ownerOf(model, patch - 1, { row: before.tangents.length - 1, column: place.column });
}

export function replaced<T>(list: readonly T[], index: number, value: T): T[] {
  return list.map((old, i) => (i === index ? value : old));
}

// ---------------------------------------------------------------- finer levels

function isAt(detail: Detail, level: number, { row, column }: Place): boolean {
  return detail.level === level && detail.row === row && detail.column === column;
}

export function detailAt(patch: Patch, level: number, place: Place): Detail | null {
  return patch.details?.find((detail) => isAt(detail, level, place)) ?? null;
}

/** The model with a tangent set at a finer level, in place of what was set there before. */
export function withDetail(model: unknown, index: number, detail: Detail): unknown {
  const old = patchesOf(model)[index]?.details ?? [];
  return withPatch(model, index, { details: [...old.filter((d) => !isAt(d, detail.level, detail)), detail] });
}

/** The model without the details that `gone` names. */
export function withoutDetails(model: unknown, index: number, gone: (detail: Detail) => boolean): unknown {
  const details = (patchesOf(model)[index]?.details ?? []).filter((detail) => !gone(detail));
  return withPatch(model, index, { details: details.length > 0 ? details : undefined });
}

/** The model refined just so far, such that each refined tangent stands at a point of its own. */
export function atLevel(model: unknown, level: number): unknown {
  return withAllPatches(model, { depth: level, integration: "arcs" });
}

// ---------------------------------------------------------------- arc-length parameters

/** The arc-length parameters of a patch, also if it only gives lengths. */
export function parametersOf(patch: Patch): number[][] {
  if (patch.s) return patch.s;
  const last = Math.max(1, (patch.tangents[0]?.length ?? 1) - 1);
  return patch.tangents.map((row, k) => row.map((_, i) => ((patch.lengths?.[k] ?? 1) * i) / last));
}

export function lengthOf(patch: Patch, row: number): number {
  if (patch.lengths) return patch.lengths[row] ?? 0;
  const s = patch.s?.[row] ?? [];
  return (s.at(-1) ?? 0) - (s[0] ?? 0);
}

/** The fields of a patch whose row is so long, its tangents spaced in the same proportions. */
export function lengthPart(patch: Patch, row: number, length: number): Partial<Patch> {
  if (patch.lengths) return { lengths: replaced(patch.lengths, row, length) };
  const old = lengthOf(patch, row);
  const s = parametersOf(patch);
  const first = s[row]![0]!;
  return { s: replaced(s, row, s[row]!.map((x) => first + ((x - first) * length) / old)) };
}

/** The fields of a patch in which the step that ends at `column` of a row is so long; what follows moves with it. */
export function stepPart(patch: Patch, row: number, column: number, step: number): Record<"s" | "lengths", unknown> {
  const s = parametersOf(patch);
  const line = s[row]!;
  const by = step - (line[column]! - line[column - 1]!);
  return { s: replaced(s, row, line.map((x, i) => (i >= column ? x + by : x))), lengths: undefined };
}

/** The fields of a patch with tangents evenly spaced on a row that stays as long. */
export function evenPart(patch: Patch, row: number): Partial<Patch> {
  if (!patch.s) return {};
  const line = patch.s[row]!;
  const last = Math.max(1, line.length - 1);
  const first = line[0]!;
  return { s: replaced(patch.s, row, line.map((_, i) => first + (lengthOf(patch, row) * i) / last)) };
}

// ---------------------------------------------------------------- the initial curve

export function rangeOf(initial: Initial): [number, number] {
  return initial.type === "polyline" ? [initial.t[0] ?? 0, initial.t.at(-1) ?? 1] : [initial.t0, initial.t1];
}

/** Points of the curve that can be moved: its vertices, control points, or the point where a QI curve starts. */
export function handlesOf(initial: Initial): readonly Triple[] {
  return initial.type === "qi" ? [initial.start ?? [0, 0, 0]] : initial.points;
}

export function withHandle(initial: Initial, index: number, place: Triple): Initial {
  if (initial.type === "qi") return { ...initial, start: place };
  return { ...initial, points: replaced(initial.points, index, place) };
}

/** The rows that its table shows: points, or the tangents of a QI curve. */
export function rowsOf(initial: Initial): readonly Triple[] {
  return initial.type === "qi" ? initial.tangents : initial.points;
}

export function withRow(initial: Initial, index: number, row: Triple): Initial {
  if (initial.type === "qi") return { ...initial, tangents: replaced(initial.tangents, index, row) };
  return { ...initial, points: replaced(initial.points, index, row) };
}

/** The curve with one row more, a copy of row `index` beside it; knots of its own would no longer fit. */
export function withRowInserted(initial: Initial, index: number): Initial {
  const twice = <T>(list: readonly T[]): T[] => list.flatMap((x, i) => (i === index ? [x, x] : [x]));
  switch (initial.type) {
    case "qi":
      return { ...initial, tangents: twice(initial.tangents) };
    case "polyline":
      return { ...initial, points: twice(initial.points), t: between(initial.t, index) };
    case "bspline":
      return withoutKnots({ ...initial, points: twice(initial.points) });
    case "nurbs":
      return withoutKnots({ ...initial, points: twice(initial.points), weights: twice(initial.weights) });
  }
}

/** The curve with a row less, or as it was if no fewer will do. */
export function withRowDeleted(initial: Initial, index: number): Initial {
  const less = <T>(list: readonly T[]): T[] => list.filter((_, i) => i !== index);
  const count = rowsOf(initial).length;
  switch (initial.type) {
    case "qi":
      return count <= initial.order ? initial : { ...initial, tangents: less(initial.tangents) };
    case "polyline": {
      if (count <= 2) return initial;
      // The range stays, or rows of the surface would have no beginning.
      const [first, last] = rangeOf(initial);
      const t = less(initial.t);
      return { ...initial, points: less(initial.points), t: replaced(replaced(t, 0, first), t.length - 1, last) };
    }
    case "bspline":
      return count <= initial.degree + 1 ? initial : withoutKnots({ ...initial, points: less(initial.points) });
    case "nurbs":
      return count <= initial.degree + 1
        ? initial
        : withoutKnots({ ...initial, points: less(initial.points), weights: less(initial.weights) });
  }
}

function between(t: readonly number[], index: number): number[] {
  const isLast = index === t.length - 1;
  const [a, b] = isLast ? [t[index - 1] ?? 0, t[index]!] : [t[index]!, t[index + 1]!];
  const at = isLast ? index : index + 1;
  return [...t.slice(0, at), (a + b) / 2, ...t.slice(at)];
}

function withoutKnots<T extends Bspline | Nurbs>(curve: T): T {
  const next = { ...curve };
  delete next.knots;
  return next;
}

/**
 * The curve as another kind, from the same points as far as there are any. `places` are points on it at
 * `parameters`, for a QI curve, which has none.
 */
export function converted(
  initial: Initial,
  type: InitialType,
  places: readonly Triple[],
  parameters: readonly number[],
): Initial {
  if (initial.type === type) return initial;
  const [t0, t1] = rangeOf(initial);
  const points = initial.type === "qi" ? [...places] : initial.points;
  const degree = Math.max(1, Math.min(3, points.length - 1));
  const own = initial.type === "bspline" || initial.type === "nurbs" ? initial.degree : degree;
  switch (type) {
    case "polyline": {
      const isGiven = initial.type === "qi" && parameters.length === points.length;
      const last = Math.max(1, points.length - 1);
      const t = isGiven ? [...parameters] : points.map((_, i) => t0 + ((t1 - t0) * i) / last);
      return { type, points, t };
    }
    case "bspline":
      return { type, points, degree: own, t0, t1, ...knotsOf(initial) };
    case "nurbs":
      return { type, points, weights: points.map(() => 1), degree: own, t0, t1, ...knotsOf(initial) };
    case "qi": {
      // The legs of the polygon; a QI curve takes no more from its tangents than their directions.
      const legs = points.slice(1).map((p, i) => p.map((x, axis) => x - points[i]![axis]!) as Triple);
      const tangents = legs.filter((leg) => leg.some((x) => x !== 0));
      const length = tangents.reduce((sum, leg) => sum + Math.hypot(...leg), 0);
      if (tangents.length === 0) tangents.push([1, 0, 0]);
      const order = Math.min(4, tangents.length);
      return { type, tangents, order, length: length || 1, start: points[0] ?? [0, 0, 0], t0, t1 };
    }
  }
}

function knotsOf(initial: Initial): { knots?: number[] } {
  return (initial.type === "bspline" || initial.type === "nurbs") && initial.knots ? { knots: initial.knots } : {};
}

// ---------------------------------------------------------------- lengths as a function of t

/** A length function of another kind, or none, which begins with the lengths that the rows have. */
export function lengthFunction(patch: Patch, type: LengthFunction["type"] | "none"): LengthFunction | undefined {
  if (type === "none") return undefined;
  const lengths = patch.length?.lengths ?? patch.tangents.map((_, row) => lengthOf(patch, row));
  const [t0, t1] = [patch.t[0] ?? 0, patch.t.at(-1) ?? 1];
  const last = Math.max(1, lengths.length - 1);
  return type === "polyline"
    ? { type, lengths, t: lengths.map((_, i) => t0 + ((t1 - t0) * i) / last) }
    : { type, lengths, degree: Math.max(1, Math.min(3, lengths.length - 1)), t0, t1 };
}

// ---------------------------------------------------------------- places

/** The nearest place that the patch has. */
export function clampPlace({ row, column }: Place, info: Pick<PatchInfo, "rowCount" | "columnCount">): Place {
  const within = (x: number, count: number) => Math.min(Math.max(0, x), Math.max(0, count - 1));
  return { row: within(row, info.rowCount), column: within(column, info.columnCount) };
}

/** The row of a finer grid that stands at the same share of all rows: the streamline of a row of tangents. */
export function fineLine(index: number, count: number, fineCount: number): number {
  return count < 2 ? 0 : Math.round((index * (fineCount - 1)) / (count - 1));
}
