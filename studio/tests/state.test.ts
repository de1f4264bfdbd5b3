import "fake-indexeddb/auto";
import { expect, test } from "vitest";
import { Autosave, type Saved } from "../src/state/autosave";
import { designFor, meshDocument, suitableLevels, withCreases, withMoves, type Document } from "../src/state/document";
import { all, combine, fromMask, has, indicesOf, maskOf } from "../src/state/indices";
import { fromBase64, fromProject, toBase64, toProject } from "../src/state/project";
import { DEFAULTS } from "../src/state/settings";
import { INFO } from "./fake";

const source = { name: "cow.obj", bytes: Uint8Array.from({ length: 70_000 }, (_, i) => (i * 31) & 255) };
const design = { ...designFor(INFO), moves: [[2, 0.25, -1, 3]] as [number, number, number, number][] };
const document: Document = {
  mesh: {
    ...meshDocument(source, ["weld"], design),
    faces: indicesOf([3, 1]),
    vertices: indicesOf([2]),
    edges: indicesOf([5]),
    compare: { ...design, exact: true },
  },
  model: { schema: "anything" },
};
const camera = { position: [1, 2, 3], target: [0, 0, 0], up: [0, 1, 0], zoom: 1 } as const;
const saved: Saved = {
  document,
  workspace: "interpolation",
  camera: { ...camera, position: [1, 2, 3], target: [0, 0, 0], up: [0, 1, 0] },
  settings: { ...DEFAULTS, shading: "zebra" },
};

test("what is saved in the browser comes back as it was", async () => {
  const first = new Autosave("round", 0);
  first.save(saved);
  await first.flush();
  const back = await new Autosave("round").restore();
  expect(back).toEqual(saved);
});

test("of many changes the last is saved, and the bytes only once", async () => {
  const autosave = new Autosave("last", 10_000);
  const puts: string[] = [];
  const put = IDBObjectStore.prototype.put;
  IDBObjectStore.prototype.put = function (value: unknown, key?: IDBValidKey) {
    puts.push(String(key));
    return put.call(this, value, key);
  };
  try {
    for (let levels = 0; levels < 5; levels += 1) {
      autosave.save({
        ...saved,
        document: { ...document, mesh: { ...document.mesh!, fineness: { levels, limit: true } } },
      });
    }
    await autosave.flush();
    autosave.save({ ...saved, workspace: "streamline" });
    await autosave.flush();
  } finally {
    IDBObjectStore.prototype.put = put;
  }
  expect(puts).toEqual(["bytes", "document", "document"]);
  expect((await autosave.restore())?.workspace).toBe("streamline");
});

test("nothing is restored where nothing was saved, or after clearing", async () => {
  const autosave = new Autosave("empty", 0);
  expect(await autosave.restore()).toBeNull();
  autosave.save(saved);
  await autosave.flush();
  await autosave.clear();
  expect(await autosave.restore()).toBeNull();
});

test("a project holds all of the document", () => {
  const project = toProject(document, "interpolation", saved.camera, saved.settings);
  const text = JSON.stringify(project);
  const opened = fromProject(JSON.parse(text));
  expect(opened.document).toEqual(document);
  expect(opened.camera).toEqual(saved.camera);
  expect(opened.settings).toEqual(saved.settings);
  expect(opened.workspace).toBe("interpolation");
});

test("a project that the command wrote knows nothing of the studio", () => {
  const project = { ...toProject(document, "interpolation", null, DEFAULTS), studio: null };
  const opened = fromProject(project);
  expect(opened.document.mesh?.compare).toBeNull();
  expect(opened.settings).toEqual({});
});

test("base64 is that of everyone else", () => {
  expect(toBase64(new TextEncoder().encode("fairform"))).toBe("ZmFpcmZvcm0=");
  expect(fromBase64(toBase64(source.bytes))).toEqual(source.bytes);
});

test("sets of indices", () => {
  expect([...indicesOf([5, 1, 5, 3])]).toEqual([1, 3, 5]);
  expect([...fromMask(maskOf(indicesOf([0, 2]), 4))]).toEqual([0, 2]);
  expect(has(indicesOf([1, 4, 9]), 4)).toBe(true);
  expect(has(indicesOf([1, 4, 9]), 5)).toBe(false);
  const old = indicesOf([1, 2, 3]);
  const picked = indicesOf([3, 4]);
  expect([...combine(old, picked, "replace")]).toEqual([3, 4]);
  expect([...combine(old, picked, "add")]).toEqual([1, 2, 3, 4]);
  expect([...combine(old, picked, "remove")]).toEqual([1, 2]);
  expect([...combine(old, picked, "toggle")]).toEqual([1, 2, 4]);
  expect([...all(3)]).toEqual([0, 1, 2]);
});

test("moves and creases replace what was there for the same vertex or edge", () => {
  expect(withMoves([[1, 0, 0, 0], [5, 1, 1, 1]], [[1, 9, 9, 9], [0, 2, 2, 2]])).toEqual([
    [0, 2, 2, 2],
    [1, 9, 9, 9],
    [5, 1, 1, 1],
  ]);
  const creases = withCreases([[1, 2, 3]], [[2, 1], [7, 4]], -1);
  expect(creases).toEqual([[1, 2, -1], [4, 7, -1]]);
  expect(withCreases(creases, [[2, 1]], 0)).toEqual([[4, 7, -1]]);
});

test("a surface begins with as many levels as stay quick", () => {
  expect(suitableLevels(368, 3)).toBe(4);
  expect(suitableLevels(6, 4)).toBe(4);
  expect(suitableLevels(10_000, 4)).toBe(1);
  expect(suitableLevels(1_000_000, 3)).toBe(0);
});
