import { beforeEach, expect, test } from "vitest";
import type { Kernel, PatchGeometry, PatchInfo, Triple } from "../src/kernel/api";
import { alongColumns, alongRows, combLines, segments } from "../src/stream/lines";
import {
  clampPlace,
  converted,
  evenPart,
  fineLine,
  lengthFunction,
  lengthPart,
  ownerOf,
  parametersOf,
  patchesOf,
  stepPart,
  withDetail,
  withPatch,
  withoutDetails,
  withRowDeleted,
  withRowInserted,
  withTangent,
  type Bspline,
  type Patch,
  type Polyline,
} from "../src/stream/model";
import { StreamSession } from "../src/stream/session";
import { DEFAULTS, settings, showStream } from "../src/state/settings";
import { Studio } from "../src/studio";

const X: Triple = [1, 0, 0];
const Y: Triple = [0, 1, 0];
const Z: Triple = [0, 0, 1];

const initial: Bspline = { type: "bspline", points: [[0, 0, 0], [1, 0, 0], [2, 0, 0]], degree: 2, t0: 0, t1: 1 };
const patch: Patch = {
  tangents: [[X, Y, Z], [X, X, X]],
  s: [[1, 2, 4], [0, 1, 2]],
  t: [0, 1],
  depth: 2,
  initial,
};

test("one patch or several", () => {
  expect(patchesOf(patch)).toEqual([patch]);
  expect(patchesOf({ patches: [patch, patch] })).toHaveLength(2);
  expect(patchesOf(null)).toEqual([]);
  expect(patchesOf({ tangents: 3 })).toEqual([]);
});

test("a changed tangent leaves everything else the same objects", () => {
  const model = { patches: [patch, patch], stitch: "smooth" };
  const next = withTangent(model, 1, { row: 0, column: 2 }, X) as typeof model;
  expect(next.patches[1]!.tangents[0]).toEqual([X, Y, X]);
  expect(next.patches[0]).toBe(patch);
  expect(next.patches[1]!.tangents[1]).toBe(patch.tangents[1]);
  expect(next.stitch).toBe("smooth");
  expect(model.patches[1]!.tangents[0]).toEqual([X, Y, Z]);
});

test("a field set to undefined is gone from the file", () => {
  expect(withPatch(patch, 0, { s: undefined, lengths: [1, 2] })).toEqual({
    tangents: patch.tangents,
    lengths: [1, 2],
    t: [0, 1],
    depth: 2,
    initial,
  });
});

test("lengths of rows and steps", () => {
  expect(lengthPart(patch, 0, 6)).toEqual({ s: [[1, 3, 7], [0, 1, 2]] });
  const short = { ...patch, s: undefined, lengths: [3, 2] } as unknown as Patch;
  expect(lengthPart(short, 1, 5)).toEqual({ lengths: [3, 5] });
  expect(stepPart(patch, 0, 1, 3)).toEqual({ s: [[1, 4, 6], [0, 1, 2]], lengths: undefined });
  expect(evenPart(patch, 0)).toEqual({ s: [[1, 2.5, 4], [0, 1, 2]] });
  expect(parametersOf({ ...patch, s: undefined, lengths: [4, 2] } as unknown as Patch)).toEqual([[0, 2, 4], [0, 1, 2]]);
});

test("a length function begins with the lengths of the rows", () => {
  expect(lengthFunction(patch, "polyline")).toEqual({ type: "polyline", lengths: [3, 2], t: [0, 1] });
  expect(lengthFunction(patch, "bspline")).toEqual({ type: "bspline", lengths: [3, 2], degree: 1, t0: 0, t1: 1 });
  expect(lengthFunction(patch, "none")).toBeUndefined();
});

test("an initial curve keeps its points and its range as another kind", () => {
  const line = converted(initial, "polyline", [], []) as Polyline;
  expect(line).toEqual({ type: "polyline", points: initial.points, t: [0, 0.5, 1] });
  expect(converted(line, "bspline", [], [])).toEqual({ ...initial, degree: 2 });
  expect(converted(initial, "nurbs", [], [])).toMatchObject({ weights: [1, 1, 1], degree: 2, t0: 0, t1: 1 });
  const qi = converted(initial, "qi", [], []);
  expect(qi).toMatchObject({ type: "qi", tangents: [X, X], order: 2, length: 2, start: [0, 0, 0] });
  expect(converted(qi, "polyline", [[0, 0, 0], [5, 0, 0]], [0, 1])).toEqual({
    type: "polyline",
    points: [[0, 0, 0], [5, 0, 0]],
    t: [0, 1],
  });
});

test("points are inserted and deleted as far as the kind allows", () => {
  const line: Polyline = { type: "polyline", points: [[0, 0, 0], [1, 0, 0], [2, 0, 0]], t: [0, 1, 4] };
  expect((withRowInserted(line, 1) as Polyline).t).toEqual([0, 1, 2.5, 4]);
  expect((withRowInserted(line, 2) as Polyline).t).toEqual([0, 1, 2.5, 4]);
  // The ends of the range stay, or rows would have no beginning.
  expect((withRowDeleted(line, 0) as Polyline).t).toEqual([0, 4]);
  const knotted: Bspline = { ...initial, knots: [0, 0, 0, 1, 1, 1] };
  expect(withRowInserted(knotted, 0)).not.toHaveProperty("knots");
  expect(withRowDeleted(knotted, 0)).toBe(knotted);
});

test("stitched patches take their first streamline from the patch before", () => {
  const at = (row: number) => ({ row, column: 2 });
  const plain = { patches: [patch, patch, patch], stitch: false };
  expect(ownerOf(plain, 1, at(0))).toEqual({ patch: 1, place: at(0) });
  const joined = { ...plain, stitch: true };
  expect(ownerOf(joined, 1, at(0))).toEqual({ patch: 0, place: at(1) });
  expect(ownerOf(joined, 1, at(1))).toEqual({ patch: 1, place: at(1) });
  expect(ownerOf({ ...plain, stitch: "smooth" }, 1, at(1))).toBeNull();
  // The last of two rows is the second one, which follows as well.
  expect(ownerOf({ ...plain, stitch: "smooth" }, 2, at(0))).toBeNull();
});

test("a finer tangent replaces what was set at its place, and no other", () => {
  const detail = (level: number, tangent: Triple) => ({ level, row: 1, column: 2, predicted: X, tangent });
  let model: unknown = withDetail(withDetail(patch, 0, detail(1, Y)), 0, detail(2, Y));
  model = withDetail(model, 0, detail(1, Z));
  expect(patchesOf(model)[0]!.details).toEqual([detail(2, Y), detail(1, Z)]);
  expect(withoutDetails(model, 0, (d) => d.level === 1)).toEqual({ ...patch, details: [detail(2, Y)] });
  expect(withoutDetails(model, 0, () => true)).toEqual(patch);
});

test("places and lines of grids", () => {
  expect(clampPlace({ row: -1, column: 9 }, { rowCount: 2, columnCount: 3 })).toEqual({ row: 0, column: 2 });
  expect([0, 1, 2].map((row) => fineLine(row, 3, 9))).toEqual([0, 4, 8]);
  expect(fineLine(0, 1, 9)).toBe(0);
  expect([...alongRows([1], 3)]).toEqual([3, 4, 4, 5]);
  expect([...alongColumns([2], 3, 3)]).toEqual([2, 5, 5, 8]);
  expect([...combLines([0], 2)]).toEqual([0, 1, 2, 3, 1, 3]);
  expect([...segments(Float32Array.of(0, 0, 0, 9, 9, 9, 1, 1, 1), 0, 2, 2)]).toEqual([0, 0, 0, 1, 1, 1]);
});

// ---------------------------------------------------------------- the session

/** A kernel for models that computes nothing; `hold` makes its next tangents wait for `letGo`. */
class FakeStream {
  readonly calls: string[] = [];
  /** Patches that move when a tangent is set. */
  others = new Uint32Array(0);
  refuse: (model: unknown) => boolean = () => false;
  #waiting: (() => void)[] | null = null;
  #infos: PatchInfo[] = [];

  hold(): void {
    this.#waiting = [];
  }

  letGo(): void {
    const waiting = this.#waiting ?? [];
    this.#waiting = null;
    for (const go of waiting) go();
  }

  async openModel(bytes: Uint8Array, name: string) {
    const model: unknown = JSON.parse(new TextDecoder().decode(bytes));
    this.calls.push(`open ${name}`);
    return { model, patches: this.#take(model) };
  }

  async setModel(model: unknown): Promise<PatchInfo[]> {
    this.calls.push("set");
    if (this.refuse(model)) throw { message: "no such model", help: "undo", repairs: [], cancelled: false };
    return this.#take(model);
  }

  async patch(index: number): Promise<PatchGeometry> {
    this.calls.push(`patch ${index}`);
    return geometry();
  }

  async setTangent(index: number, row: number, column: number, tangent: Triple): Promise<PatchGeometry> {
    this.calls.push(`tangent ${index} ${row} ${column} ${tangent.join(" ")}`);
    if (this.#waiting) await new Promise<void>((go) => this.#waiting!.push(go));
    return { ...geometry(), others: this.others };
  }

  async setComponent(tangent: Triple, axis: number, value: number): Promise<Triple> {
    this.calls.push(`component of ${tangent.join(" ")}`);
    return tangent.map((x, i) => (i === axis ? value : x)) as Triple;
  }

  async edit(model: unknown, change: { kind: string; index: number }): Promise<unknown> {
    this.calls.push(`edit ${change.kind} ${change.index}`);
    return { ...(model as object), name: "edited" };
  }

  async arcs() {
    return new Float32Array(3);
  }

  #take(model: unknown): PatchInfo[] {
    this.#infos = patchesOf(model).map((p, i) => ({
      name: `patch ${i}`,
      rowCount: p.tangents.length,
      columnCount: p.tangents[0]!.length,
      depth: 2,
      scheme: "kobbelt",
      warnings: [],
    }));
    return this.#infos;
  }
}

function geometry(): PatchGeometry {
  const none = new Float32Array(0);
  const numbers = new Uint32Array(0);
  return {
    positions: none,
    normals: none,
    triangles: numbers,
    faceOfTriangle: numbers,
    edges: numbers,
    rowCount: 2,
    columnCount: 4,
    feet: none,
    tangents: none,
    fineTangents: Float32Array.from({ length: 24 }, (_, i) => (i % 3 === 2 ? 1 : 0)),
    milliseconds: 1,
  };
}

let kernel: FakeStream;
let studio: Studio;
let session: StreamSession;

const file = (model: unknown) => ({
  name: "a.streamline.json",
  bytes: new TextEncoder().encode(JSON.stringify(model)),
});
const shown = () => patchesOf(studio.history.present.value.model)[0]!.tangents;

beforeEach(async () => {
  settings.value = DEFAULTS;
  showStream({ arcs: false });
  kernel = new FakeStream();
  studio = new Studio(() => kernel as unknown as Kernel);
  session = new StreamSession(studio);
  await session.open(file(patch));
  await session.idle();
  session.select({ row: 0, column: 0 });
  kernel.calls.length = 0;
});

test("opening draws every patch and is one thing to undo", async () => {
  await session.open(file({ patches: [patch, patch] }));
  await session.idle();
  expect(session.geometries.value).toHaveLength(2);
  expect(kernel.calls).toEqual(["open a.streamline.json", "patch 0", "patch 1"]);
  expect(studio.history.undoLabel).toBe("Open a.streamline.json");
});

test("patches that move with a tangent are drawn again, and no others", async () => {
  await session.open(file({ patches: [patch, patch, patch], stitch: true }));
  await session.idle();
  session.select({ row: 1, column: 0 }, 0);
  kernel.others = Uint32Array.of(1);
  kernel.calls.length = 0;
  session.setTangent(Y);
  await session.idle();
  expect(kernel.calls).toEqual(["tangent 0 1 0 0 1 0", "patch 1"]);
});

test("an undo while a file is opened does not take the kernel elsewhere", async () => {
  session.setTangent(Y);
  await session.idle();
  kernel.calls.length = 0;
  const opening = session.open(file({ ...patch, name: "other" }));
  studio.undo();
  await opening;
  await session.idle();
  expect(kernel.calls.at(-2)).toBe("open a.streamline.json");
  expect((studio.history.present.value.model as { name: string }).name).toBe("other");
});

test("of many tangents while the kernel works only the last is sent, and all are one thing to undo", async () => {
  kernel.hold();
  session.setTangent(Y);
  await new Promise((go) => setTimeout(go));
  for (let i = 0; i < 5; i += 1) session.setTangent(X);
  session.setTangent(Z);
  kernel.letGo();
  await session.idle();
  session.seal();
  expect(kernel.calls).toEqual(["tangent 0 0 0 0 1 0", "tangent 0 0 0 0 0 1"]);
  expect(shown()[0]![0]).toEqual(Z);
  studio.undo();
  expect(shown()[0]![0]).toEqual(X);
  expect(studio.history.undoLabel).toBe("Open a.streamline.json");
});

test("undo sends the model that was before, and nothing is sent for what the kernel has", async () => {
  session.setTangent(Y);
  await session.idle();
  expect(kernel.calls).toEqual(["tangent 0 0 0 0 1 0"]);
  studio.undo();
  await session.idle();
  expect(kernel.calls.slice(1)).toEqual(["set", "patch 0"]);
});

test("an undo while the kernel works wins over its answer", async () => {
  session.setTangent(Y);
  await session.idle();
  session.seal();
  await session.idle();
  kernel.hold();
  session.setTangent(Z);
  await new Promise((go) => setTimeout(go));
  studio.undo();
  kernel.letGo();
  await session.idle();
  expect(shown()[0]![0]).toEqual(X);
  expect(kernel.calls.at(-2)).toBe("set");
});

test("the steps of a slide start from where it began", async () => {
  session.setComponent(1, 0.5);
  await session.idle();
  session.setComponent(1, 0.75);
  await session.idle();
  session.seal();
  expect(kernel.calls.filter((c) => c.startsWith("component"))).toEqual(["component of 1 0 0", "component of 1 0 0"]);
  session.setComponent(1, 0.25);
  await session.idle();
  expect(kernel.calls.filter((c) => c.startsWith("component")).at(-1)).toBe("component of 1 0.75 0");
});

test("a finer tangent is a detail beside what refinement gave, and one thing to undo", async () => {
  session.setLevel(1);
  await session.idle();
  await new Promise((go) => setTimeout(go));
  expect(session.level.value).toBe(1);
  session.setTangent(Y, { row: 1, column: 1 });
  await session.idle();
  session.setTangent(Z, { row: 1, column: 1 });
  await session.idle();
  session.seal();
  await session.idle();
  const set = patchesOf(studio.history.present.value.model)[0]!;
  expect(set.details).toEqual([{ level: 1, row: 1, column: 1, predicted: [0, 0, 1], tangent: Z }]);
  expect(set.tangents).toEqual(patch.tangents);
  studio.undo();
  expect(patchesOf(studio.history.present.value.model)[0]!.details).toBeUndefined();
});

test("a drag that is cancelled leaves the model as it was", async () => {
  session.beginDrag();
  session.cancelDrag();
  await session.idle();
  expect(studio.history.undoLabel).toBe("Open a.streamline.json");
  session.setTangent(Y);
  await session.idle();
  session.setTangent(Z);
  session.cancelDrag();
  await session.idle();
  expect(shown()[0]![0]).toEqual(X);
  expect(studio.history.undoLabel).toBe("Open a.streamline.json");
});

test("a model that the kernel refuses is told, stays to be undone, and is not tried again and again", async () => {
  kernel.refuse = (model) => patchesOf(model)[0]!.depth === 9;
  session.change({ depth: 9 }, "Depth");
  await session.idle();
  expect(session.trouble.value?.message).toBe("no such model");
  session.select({ row: 1, column: 1 });
  await session.idle();
  expect(kernel.calls).toEqual(["set"]);
  studio.undo();
  await session.idle();
  expect(session.trouble.value).toBeNull();
  expect(kernel.calls).toEqual(["set"]);
});

test("rows are inserted between two, and deleted where they are", async () => {
  await session.changeGrid("insert-row", "Insert");
  expect(kernel.calls).toContain("edit insert-row 1");
  expect(studio.history.undoLabel).toBe("Insert");
  session.select({ row: 1, column: 2 });
  await session.changeGrid("delete-column", "Delete");
  expect(kernel.calls).toContain("edit delete-column 2");
});

test("the selection stays inside a model that became smaller", async () => {
  session.select({ row: 1, column: 2 });
  session.commit({ ...patch, tangents: [[X, Y]], s: [[0, 1]], t: [0] }, "Smaller");
  await session.idle();
  expect(session.place.value).toEqual({ row: 0, column: 1 });
  session.step(0, 5);
  expect(session.place.value).toEqual({ row: 0, column: 1 });
});

test("a restored document is opened by a kernel that has nothing open", async () => {
  const other = new FakeStream();
  const restored = new Studio(() => other as unknown as Kernel);
  const again = new StreamSession(restored);
  restored.history.reset({ mesh: null, model: patch });
  await again.idle();
  expect(other.calls).toEqual(["open model", "patch 0"]);
  expect(again.geometries.value).toHaveLength(1);
});
