import { expect, test, vi } from "vitest";
import type { Design } from "../src/kernel/api";
import { createKernel } from "../src/kernel/client";
import { designFor } from "../src/state/document";
import { INFO } from "./fake";

// Tests run without a built kernel.
vi.mock("../src/kernel/wasm/fairform_wasm_bg.wasm?url", () => ({ default: "" }));

/** A worker that answers when told to, and lists what it was asked. */
class FakeWorker {
  static all: FakeWorker[] = [];
  onmessage: ((event: { data: unknown }) => void) | null = null;
  onerror = null;
  readonly asked: { id: number; name: string; args: unknown[] }[] = [];

  constructor() {
    FakeWorker.all.push(this);
  }

  postMessage(message: { kind?: string; id: number; name: string; args: unknown[] }): void {
    if (message.kind === "start") queueMicrotask(() => this.onmessage?.({ data: { kind: "ready" } }));
    else this.asked.push(message);
  }

  answer(value: unknown = {}): void {
    this.onmessage?.({ data: { kind: "answer", id: this.asked.at(-1)!.id, value } });
  }

  refuse(message: string): void {
    const problem = { message, help: null, repairs: [], cancelled: false };
    this.onmessage?.({ data: { kind: "problem", id: this.asked.at(-1)!.id, problem } });
  }

  terminate(): void {}

  get names(): string[] {
    return this.asked.map((call) => call.name);
  }
}

const settle = () => new Promise((resolve) => setTimeout(resolve));
const design: Design = designFor(INFO);

async function fitted() {
  FakeWorker.all = [];
  const kernel = createKernel({
    worker: () => new FakeWorker() as unknown as Worker,
    module: () => Promise.resolve({} as WebAssembly.Module),
  });
  const first = () => FakeWorker.all[0]!;
  const open = kernel.openMesh(new Uint8Array(1), "a.obj");
  await settle();
  first().answer();
  await open;
  for (const work of [() => kernel.fit(design), () => kernel.surface({ levels: 2, limit: true })]) {
    const done = work();
    await settle();
    first().answer();
    await done;
  }
  return kernel;
}

test("after a cancel a new worker does not repeat the fit that the next one replaces", async () => {
  const kernel = await fitted();
  const slow = kernel.fit({ ...design, exact: true });
  await settle();
  void kernel.cancel();
  await expect(slow).rejects.toMatchObject({ cancelled: true });
  const next = kernel.fit({ ...design, tolerance: 1e-3 });
  await settle();
  const second = FakeWorker.all[1]!;
  second.answer();
  await settle();
  second.answer({ max: 1 });
  await expect(next).resolves.toEqual({ max: 1 });
  expect(second.names).toEqual(["openMesh", "fit"]);
});

test("after a cancel everything is where it was, for calls that need it", async () => {
  const kernel = await fitted();
  const slow = kernel.fit({ ...design, exact: true });
  await settle();
  void kernel.cancel();
  await expect(slow).rejects.toMatchObject({ cancelled: true });
  void kernel.values("mean");
  await settle();
  const second = FakeWorker.all[1]!;
  for (let i = 0; i < 3; i += 1) {
    second.answer();
    await settle();
  }
  expect(second.names).toEqual(["openMesh", "fit", "surface", "values"]);
  expect(second.asked[1]!.args).toEqual([design]);
});

test("if the fit that replaced a repetition fails, the repetition comes after all", async () => {
  const kernel = await fitted();
  const slow = kernel.fit({ ...design, exact: true });
  await settle();
  void kernel.cancel();
  await expect(slow).rejects.toMatchObject({ cancelled: true });
  const next = kernel.fit({ ...design, scheme: "kobbelt" });
  await settle();
  const second = FakeWorker.all[1]!;
  second.answer();
  await settle();
  second.refuse("no quadrilaterals");
  await expect(next).rejects.toMatchObject({ message: "no quadrilaterals" });
  second.answer();
  await settle();
  expect(second.names).toEqual(["openMesh", "fit", "fit", "surface"]);
  expect(second.asked[2]!.args).toEqual([design]);
});
