import { expect, test, vi } from "vitest";
import { Pipeline, type Wish } from "../src/interpolation/pipeline";
import { designFor, FINENESS } from "../src/state/document";
import { FakeKernel, INFO } from "./fake";

const NO_REPAIRS: string[] = [];
const SOURCE = { name: "tetrahedron.obj", bytes: Uint8Array.of(1, 2, 3) };
const DESIGN = designFor(INFO);
const WISH: Wish = {
  source: SOURCE,
  repairs: NO_REPAIRS,
  design: DESIGN,
  fineness: FINENESS,
  iteration: null,
  control: false,
  colouring: null,
};

function start() {
  const kernel = new FakeKernel();
  return { kernel, pipeline: new Pipeline(kernel) };
}

/** Lets promises that are settled do what follows. */
const settle = () => new Promise((resolve) => setTimeout(resolve));

test("a wish is opened, fitted and drawn, once", async () => {
  const { kernel, pipeline } = start();
  pipeline.want(WISH);
  await pipeline.idle();
  pipeline.want({ ...WISH });
  await pipeline.idle();
  expect(kernel.calls).toEqual(["open tetrahedron.obj", "fit", "surface 3"]);
  expect(pipeline.surface.value).not.toBeNull();
  expect(pipeline.stage.value).toBeNull();
});

test("a change during a fit cancels it and only the newest is fitted to the end", async () => {
  const { kernel, pipeline } = start();
  kernel.slow = true;
  pipeline.want(WISH);
  await settle();
  const second = { ...DESIGN, tolerance: 1e-3 };
  const third = { ...DESIGN, tolerance: 1e-4 };
  pipeline.want({ ...WISH, design: second });
  pipeline.want({ ...WISH, design: third });
  expect(kernel.calls).not.toContain("cancel");
  await vi.waitFor(() => expect(kernel.fitted).toEqual([DESIGN, third]), 2000);
  expect(kernel.calls).toContain("cancel");
  kernel.finishFit();
  await pipeline.idle();
  expect(kernel.fitted).toEqual([DESIGN, third]);
  expect(kernel.calls.filter((c) => c.startsWith("surface"))).toHaveLength(1);
});

test("a quick fit ends although a newer one is wished, so that sliders show something", async () => {
  const { kernel, pipeline } = start();
  kernel.slow = true;
  pipeline.want(WISH);
  await settle();
  const next = { ...DESIGN, tolerance: 1e-3 };
  pipeline.want({ ...WISH, design: next });
  kernel.finishFit();
  await vi.waitFor(() => expect(kernel.fitted).toEqual([DESIGN, next]));
  kernel.finishFit();
  await pipeline.idle();
  expect(kernel.calls).toEqual(["open tetrahedron.obj", "fit", "surface 3", "fit", "surface 3"]);
});

test("while a slider moves, surfaces are coloured, and no fit is drawn twice", async () => {
  const { kernel, pipeline } = start();
  kernel.slow = true;
  pipeline.want({ ...WISH, colouring: "tension" });
  await settle();
  const next = { ...DESIGN, tension: 0.7 };
  pipeline.want({ ...WISH, colouring: "tension", design: next });
  kernel.finishFit();
  await vi.waitFor(() => expect(kernel.fitted).toEqual([DESIGN, next]));
  kernel.finishFit();
  await pipeline.idle();
  const round = ["fit", "surface 3", "values tension"];
  expect(kernel.calls).toEqual(["open tetrahedron.obj", ...round, ...round]);
});

test("a change that needs no fit does not disturb the one that runs", async () => {
  const { kernel, pipeline } = start();
  kernel.slow = true;
  pipeline.want(WISH);
  await settle();
  pipeline.want({ ...WISH, fineness: { levels: 4, limit: true } });
  kernel.finishFit();
  await pipeline.idle();
  expect(kernel.calls).toEqual(["open tetrahedron.obj", "fit", "surface 4"]);
});

test("a person's stop rests until the design changes", async () => {
  const { kernel, pipeline } = start();
  kernel.slow = true;
  pipeline.want(WISH);
  await settle();
  await pipeline.cancel();
  await pipeline.idle();
  pipeline.want({ ...WISH, control: true });
  await pipeline.idle();
  expect(kernel.fitted).toHaveLength(1);
  expect(pipeline.stopped.value).toBe(true);
  kernel.slow = false;
  pipeline.want({ ...WISH, design: { ...DESIGN, exact: true } });
  await pipeline.idle();
  expect(kernel.fitted).toHaveLength(2);
  expect(pipeline.surface.value).not.toBeNull();
});

test("a fit that fails is told and not tried again until something changes", async () => {
  const { kernel, pipeline } = start();
  kernel.failFit = { message: "face 7 has 4 corners", help: "choose Catmull–Clark", repairs: [], cancelled: false };
  pipeline.want(WISH);
  await pipeline.idle();
  pipeline.want({ ...WISH, control: true });
  await pipeline.idle();
  expect(kernel.fitted).toHaveLength(1);
  expect(pipeline.trouble.value).toMatchObject({ stage: "fit", message: "face 7 has 4 corners" });
  kernel.failFit = null;
  pipeline.want({ ...WISH, design: { ...DESIGN, scheme: "catmull-clark" } });
  expect(pipeline.trouble.value).toBeNull();
  await pipeline.idle();
  expect(pipeline.trouble.value).toBeNull();
});

test("going back to what was fitted ends the trouble", async () => {
  const { kernel, pipeline } = start();
  pipeline.want(WISH);
  await pipeline.idle();
  kernel.failFit = { message: "no", help: null, repairs: [], cancelled: false };
  pipeline.want({ ...WISH, design: { ...DESIGN, scheme: "kobbelt" } });
  await pipeline.idle();
  expect(pipeline.trouble.value?.message).toBe("no");
  pipeline.want(WISH);
  await pipeline.idle();
  expect(pipeline.trouble.value).toBeNull();
  expect(kernel.fitted).toHaveLength(2);
});

test("the replay draws earlier states without fitting again", async () => {
  const { kernel, pipeline } = start();
  pipeline.want(WISH);
  await pipeline.idle();
  pipeline.want({ ...WISH, iteration: 0 });
  await pipeline.idle();
  pipeline.want({ ...WISH, iteration: 1 });
  await pipeline.idle();
  expect(kernel.calls.slice(2)).toEqual(["surface 3", "surface 3 at 0", "surface 3 at 1"]);
});

test("colours follow the surface", async () => {
  const { kernel, pipeline } = start();
  pipeline.want({ ...WISH, colouring: "mean" });
  await pipeline.idle();
  pipeline.want({ ...WISH, colouring: "mean", fineness: { levels: 2, limit: true } });
  await pipeline.idle();
  expect(kernel.calls.slice(2)).toEqual(["surface 3", "values mean", "surface 2", "values mean"]);
  pipeline.want(WISH);
  await pipeline.idle();
  expect(pipeline.values.value).toBeNull();
});

test("a drag ends in a design that is fitted already", async () => {
  const { kernel, pipeline } = start();
  pipeline.want(WISH);
  await pipeline.idle();
  await pipeline.grab(Uint32Array.of(0));
  await pipeline.drag([0.5, 0, 0]);
  const moved: unknown[] = [];
  await pipeline.release((moves) => {
    const next = { ...DESIGN, moves };
    moved.push(...moves);
    pipeline.want({ ...WISH, design: next });
    return next;
  });
  await pipeline.idle();
  expect(moved).toEqual([[0, 0.5, 0, 0]]);
  expect(kernel.fitted).toHaveLength(1);
  pipeline.want(WISH);
  await pipeline.idle();
  expect(kernel.fitted).toHaveLength(2);
});

test("a file that does not open leaves all as it was", async () => {
  const { kernel, pipeline } = start();
  pipeline.want(WISH);
  await pipeline.idle();
  kernel.failOpen = { message: "line 3: …", help: null, repairs: [{ step: "orient", says: "" }], cancelled: false };
  await expect(pipeline.open({ name: "bad.obj", bytes: new Uint8Array(0) }, [])).rejects.toMatchObject({
    message: "line 3: …",
  });
  await pipeline.idle();
  expect(kernel.calls).toEqual(["open tetrahedron.obj", "fit", "surface 3", "open bad.obj"]);
  expect(pipeline.surface.value).not.toBeNull();
});
