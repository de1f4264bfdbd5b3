import { afterEach, beforeEach, expect, test, vi } from "vitest";
import { commands } from "../src/interpolation/commands";
import { Session } from "../src/interpolation/session";
import type { Kernel } from "../src/kernel/api";
import { Studio } from "../src/studio";
import { message } from "../src/announce";
import { FakeKernel } from "./fake";

let kernel: FakeKernel;
let studio: Studio;
let session: Session;
const others: FakeKernel[] = [];

const source = { name: "tetrahedron.obj", bytes: Uint8Array.of(1) };
const mesh = () => session.mesh.value!;

beforeEach(async () => {
  others.length = 0;
  kernel = new FakeKernel();
  const kernels = [kernel];
  studio = new Studio(() => {
    const next = kernels.shift() ?? new FakeKernel();
    if (next !== kernel) others.push(next);
    return next as unknown as Kernel;
  });
  session = new Session(studio);
  await session.open(source, [], true);
  await session.idle();
});

afterEach(() => {
  message.value = null;
});

test("opening is one step that undo takes back", async () => {
  await session.open({ name: "other.obj", bytes: Uint8Array.of(2) });
  expect(mesh().source.name).toBe("other.obj");
  studio.undo();
  await session.idle();
  expect(mesh().source.name).toBe("tetrahedron.obj");
  expect(kernel.calls.filter((c) => c.startsWith("open")).at(-1)).toBe("open tetrahedron.obj");
  expect(session.main.surface.value).not.toBeNull();
});

test("a broken file offers its repairs, and a chosen one is kept with the document", async () => {
  kernel.failOpen = {
    message: "bad.obj: faces 0 and 4 …",
    help: "repair it",
    repairs: [{ step: "orient", says: "turn 2 faces" }],
    cancelled: false,
  };
  await studio.open({ name: "bad.obj", bytes: Uint8Array.of(3) }).catch(() => {});
  await session.open({ name: "bad.obj", bytes: Uint8Array.of(3) });
  expect(message.value?.choices.map((c) => c.label)).toEqual(["Repair: turn 2 faces"]);
  expect(mesh().source.name).toBe("tetrahedron.obj");
  message.value!.choices[0]!.run();
  await vi.waitFor(() => expect(mesh().source.name).toBe("bad.obj"));
  expect(mesh().repairs).toEqual(["orient"]);
});

test("a slide of the tension of selected faces is one step", () => {
  session.pick("faces", Uint32Array.of(1, 3), "replace");
  for (const value of [0.6, 0.7, 0.8]) session.setTension(value);
  session.seal();
  expect(mesh().design.tensions).toEqual([[1, 0.8], [3, 0.8]]);
  studio.undo();
  expect(mesh().design.tensions).toEqual([]);
  expect([...mesh().faces]).toEqual([1, 3]);
});

test("without a selection the tension is that of all faces", () => {
  session.setTension(0.75);
  expect(mesh().design).toMatchObject({ tension: 0.75, tensions: [] });
  session.setTension(null);
  expect(mesh().design.tension).toBeNull();
});

test("a tension that fades begins anew from the same base, also when the falloff changes", async () => {
  session.pick("faces", Uint32Array.of(0), "replace");
  session.setFalloff(2);
  session.setTension(0.6);
  session.setTension(0.9);
  await vi.waitFor(() => expect(mesh().design.tensions).toEqual([[0, 0.9]]));
  session.seal();
  session.setFalloff(3);
  await vi.waitFor(() => expect(kernel.calls.filter((c) => c === "spread 0.9").length).toBeGreaterThan(1));
  // The fake adds to its base: were that not the first one, there would be two entries.
  await vi.waitFor(() => expect(mesh().design.tensions).toEqual([[0, 0.9]]));
});

test("creases are marked, sharpened and unmarked", () => {
  session.pick("edges", Uint32Array.of(0, 3), "replace");
  session.setSharpness(-1);
  expect(mesh().design.creases).toEqual([[0, 2, -1], [1, 3, -1]]);
  session.setSharpness(2.5, "s");
  session.setSharpness(0, "s");
  expect(mesh().design.creases).toEqual([]);
});

test("edges around faces are those with one selected side", () => {
  session.pick("faces", Uint32Array.of(0), "replace");
  session.edgesAroundFaces();
  // Face 0 is 0 2 1; edges 0, 1, 2 are its own.
  expect([...mesh().edges]).toEqual([0, 1, 2]);
});

test("a drag goes to the newest place and ends in moves that are fitted already", async () => {
  session.pick("vertices", Uint32Array.of(0), "replace");
  const fits = kernel.fitted.length;
  session.beginDrag();
  session.drag([0.1, 0, 0]);
  session.drag([0.2, 0, 0]);
  session.drag([0.5, 0, 0]);
  await session.endDrag();
  await session.idle();
  expect(kernel.calls.filter((c) => c.startsWith("drag")).at(-1)).toBe("drag 0.5 0 0");
  expect(mesh().design.moves).toEqual([[0, 0.5, 0, 0]]);
  expect(kernel.fitted.length).toBe(fits);
});

test("a typed coordinate is meant to the last digit, and fitted", async () => {
  session.pick("vertices", Uint32Array.of(0), "replace");
  const fits = kernel.fitted.length;
  session.typeCoordinate(0, 0.123456789012345);
  await session.idle();
  await session.idle();
  expect(mesh().design.moves[0]![1]).toBe(0.123456789012345);
  expect(kernel.fitted.length).toBe(fits + 1);
});

test("two settings have two kernels, and moves go to both", async () => {
  session.compareWith(mesh().design);
  session.setDesign({ scheme: "doo-sabin" }, "Scheme");
  await session.idle();
  expect(mesh().design.scheme).toBe("loop");
  expect(mesh().compare?.scheme).toBe("doo-sabin");
  expect(others).toHaveLength(1);
  expect(others[0]!.fitted.at(-1)?.scheme).toBe("doo-sabin");
  session.pick("vertices", Uint32Array.of(0), "replace");
  session.nudge([0.5, 0, 0]);
  await session.idle();
  expect(mesh().compare?.moves).toEqual([[0, 0.5, 0, 0]]);
});

test("the keyboard reaches every face", () => {
  session.target.value = "faces";
  session.selectNext(1);
  expect([...mesh().faces]).toEqual([0]);
  session.selectNext(-1);
  expect([...mesh().faces]).toEqual([3]);
});

test("no two commands have the same name or key", () => {
  const list = [...commands(session), ...studio.actions()];
  const names = list.map((a) => a.name);
  expect(names.filter((n, i) => names.indexOf(n) !== i)).toEqual([]);
  const keys = list.flatMap((a) => a.keys ?? []);
  expect(keys.filter((k, i) => keys.indexOf(k) !== i)).toEqual([]);
  for (const action of list) expect(action.label).not.toBe("");
});
