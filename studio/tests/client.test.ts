// The client of the kernel, with a worker that answers when it is told to.

import { describe, expect, it } from "vitest";
import type { Design } from "../src/kernel/api";
import { createKernel } from "../src/kernel/client";
import type { Call, Message, Start } from "../src/kernel/protocol";

class Scripted {
  onmessage: ((event: { data: Message }) => void) | null = null;
  onerror = null;
  readonly calls: Call[] = [];
  terminated = false;

  postMessage(message: Start | Call) {
    if ("kind" in message) queueMicrotask(() => this.say({ kind: "ready" }));
    else this.calls.push(message);
  }

  terminate() {
    this.terminated = true;
  }

  say(data: Message) {
    if (!this.terminated) this.onmessage?.({ data });
  }

  /** Answers the last call. */
  answer(value: unknown) {
    this.say({ kind: "answer", id: this.calls.at(-1)!.id, value });
  }

  names() {
    return this.calls.map((call) => call.name);
  }
}

/** Lets all that waits go on. */
const soon = () => new Promise((resolve) => setTimeout(resolve));

const design: Design = {
  scheme: "loop", method: "auto", tolerance: 1e-6, iterations: 10, exact: false, fair: null, corners: "smooth",
  border: "bspline", tension: null, tensions: [], creases: [], moves: [],
};

function scripted() {
  const workers: Scripted[] = [];
  const kernel = createKernel({
    worker: () => {
      workers.push(new Scripted());
      return workers.at(-1) as unknown as Worker;
    },
    module: () => Promise.resolve({} as WebAssembly.Module),
  });
  return { kernel, workers, last: () => workers.at(-1)! };
}

/** A kernel with a mesh that was fitted and drawn. */
async function fitted() {
  const all = scripted();
  const { kernel, last } = all;
  for (const call of [
    () => kernel.openMesh(new Uint8Array([1]), "a.obj"),
    () => kernel.fit(design),
    () => kernel.surface({ levels: 2, limit: true }),
  ]) {
    const answer = call();
    await soon();
    last().answer({});
    await answer;
  }
  return all;
}

describe("calls", () => {
  it("go one after the other, with arguments as they were", async () => {
    const { kernel, last } = scripted();
    const bytes = new Uint8Array([1, 2]);
    const opened = kernel.openMesh(bytes, "a.obj", ["orient"]);
    bytes[0] = 9;
    const given = kernel.given();
    await soon();
    expect(last().calls.map((call) => call.args)).toEqual([[new Uint8Array([1, 2]), "a.obj", ["orient"]]]);
    last().answer("opened");
    expect(await opened).toBe("opened");
    await soon();
    expect(last().names()).toEqual(["openMesh", "given"]);
    last().say({
      kind: "problem", id: last().calls[1]!.id, fatal: false,
      problem: { message: "no", help: null, repairs: [], cancelled: false },
    });
    await expect(given).rejects.toMatchObject({ message: "no" });
  });

  it("of both workspaces are told apart", async () => {
    const { kernel, last } = scripted();
    for (const [call, name, args] of [
      [() => kernel.values("mean"), "values", ["mean"]],
      [() => kernel.values(1, "mean"), "patchValues", [1, "mean"]],
      [() => kernel.save("given", "ply"), "save", ["given", "ply"]],
      [() => kernel.save("ply"), "saveSurface", ["ply"]],
    ] as const) {
      const answer = call();
      await soon();
      expect(last().calls.at(-1)).toMatchObject({ name, args });
      last().answer(null);
      await answer;
    }
  });

  it("tell progress", async () => {
    const { kernel, last } = scripted();
    const seen: unknown[] = [];
    const fit = kernel.fit(design, (step) => seen.push(step));
    await soon();
    last().say({ kind: "progress", id: last().calls[0]!.id, steps: [1, 2] });
    last().answer({});
    await fit;
    expect(seen).toEqual([1, 2]);
  });
});

describe("drags", () => {
  it("send only the newest offset", async () => {
    const { kernel, last } = await fitted();
    const drags = [1, 2, 3, 4].map((x) => kernel.drag([x, 0, 0]));
    const release = kernel.release();
    const after = kernel.drag([5, 0, 0]);
    await soon();
    last().answer("first");
    await soon();
    expect(last().calls.at(-1)!.args).toEqual([[4, 0, 0]]);
    last().answer("newest");
    expect(await Promise.all(drags)).toEqual(["first", "newest", "newest", "newest"]);
    await soon();
    last().answer({ moves: [] });
    await release;
    await soon();
    expect(last().calls.at(-1)!.args).toEqual([[5, 0, 0]]);
    last().answer("last");
    expect(await after).toBe("last");
  });

  it("of tangents send the newest of each place", async () => {
    const { kernel, last } = scripted();
    const all = [
      kernel.given(),
      kernel.setTangent(0, 1, 1, [1, 0, 0]),
      kernel.setTangent(0, 1, 1, [0, 1, 0]),
      kernel.setTangent(0, 1, 2, [0, 0, 1]),
    ];
    const sent = [];
    for (let i = 0; i < 3; i++) {
      await soon();
      sent.push(last().calls.at(-1)!.args);
      last().answer(i);
    }
    expect(sent).toEqual([[], [0, 1, 1, [0, 1, 0]], [0, 1, 2, [0, 0, 1]]]);
    expect(await Promise.all(all)).toEqual([0, 1, 1, 2]);
  });
});

describe("cancelling", () => {
  it("ends the worker, and another is brought to where it was", async () => {
    const { kernel, workers, last } = await fitted();
    const released = kernel.release();
    await soon();
    last().answer({ moves: [[0, 1, 2, 3]] });
    await released;
    const fit = kernel.fit({ ...design, fair: 1 });
    const given = kernel.given();
    await soon();
    await kernel.cancel();
    await expect(fit).rejects.toMatchObject({ cancelled: true });
    expect(workers.map((worker) => worker.terminated)).toEqual([true, false]);
    const values = kernel.values("mean");
    // The surface is drawn again only when somebody asks for what depends on it.
    for (const name of ["openMesh", "fit", "given", "surface", "values"]) {
      await soon();
      expect(last().calls.at(-1)!.name).toBe(name);
      if (name === "fit") expect(last().calls.at(-1)!.args).toEqual([{ ...design, moves: [[0, 1, 2, 3]] }]);
      last().answer(name);
    }
    expect(await given).toBe("given");
    expect(await values).toBe("values");
  });

  it("fits anew without what was fitted before", async () => {
    const { kernel, last } = await fitted();
    const first = kernel.fit(design);
    await soon();
    await kernel.cancel();
    await expect(first).rejects.toMatchObject({ cancelled: true });
    const second = kernel.fit(design);
    const control = kernel.control();
    for (const name of ["openMesh", "fit", "control"]) {
      await soon();
      expect(last().calls.at(-1)!.name).toBe(name);
      last().answer(name);
    }
    expect(await second).toBe("fit");
    expect(await control).toBe("control");
  });

  it("opens a model again as it was edited", async () => {
    const { kernel, last } = scripted();
    for (const call of [
      () => kernel.openModel(new Uint8Array([1]), "a"),
      () => kernel.setModel({ a: 1 }),
      () => kernel.setTangent(0, 1, 2, [1, 0, 0]),
      () => kernel.setTangent(0, 1, 2, [0, 1, 0]),
    ]) {
      const answer = call();
      await soon();
      last().answer({});
      await answer;
    }
    const arcs = kernel.arcs(0, true, 9);
    await soon();
    await kernel.cancel();
    await expect(arcs).rejects.toMatchObject({ cancelled: true });
    const patch = kernel.patch(0);
    for (let i = 0; i < 4; i++) {
      await soon();
      last().answer({});
    }
    await patch;
    expect(last().names()).toEqual(["openModel", "setModel", "setTangent", "patch"]);
    expect(last().calls[2]!.args).toEqual([0, 1, 2, [0, 1, 0]]);
  });

  it("is nothing where nothing runs", async () => {
    const { kernel, workers } = await fitted();
    await kernel.cancel();
    expect(workers.length).toBe(1);
  });

  it("takes back what would begin while a new worker is on its way", async () => {
    const { kernel, workers, last } = await fitted();
    const first = kernel.fit(design);
    await soon();
    await kernel.cancel();
    await expect(first).rejects.toMatchObject({ cancelled: true });
    const second = kernel.fit(design);
    await soon();
    await kernel.cancel();
    await expect(second).rejects.toMatchObject({ cancelled: true });
    expect(workers.length).toBe(2);
    expect(last().names()).toEqual(["openMesh"]);
  });
});

describe("a kernel that fails", () => {
  const fault = { message: "the kernel failed", help: null, repairs: [], cancelled: false };

  it("is replaced", async () => {
    const { kernel, workers, last } = await fitted();
    const control = kernel.control();
    const given = kernel.given();
    await soon();
    last().say({ kind: "problem", id: last().calls.at(-1)!.id, problem: fault, fatal: true });
    await expect(control).rejects.toMatchObject(fault);
    for (let i = 0; i < 3; i++) {
      await soon();
      last().answer({});
    }
    await given;
    expect(workers.length).toBe(2);
    expect(last().names()).toEqual(["openMesh", "fit", "given"]);
  });

  it("is not asked again for what it fails at", async () => {
    const { kernel, workers, last } = await fitted();
    const control = kernel.control();
    await soon();
    last().say({ kind: "problem", id: last().calls.at(-1)!.id, problem: fault, fatal: true });
    await expect(control).rejects.toMatchObject(fault);
    const version = kernel.given();
    await soon();
    last().say({ kind: "problem", id: last().calls.at(-1)!.id, problem: fault, fatal: true });
    await soon();
    expect(workers.length).toBe(3);
    expect(last().names()).toEqual(["given"]);
    last().answer("0.1.0");
    expect(await version).toBe("0.1.0");
  });

  it("says that it cannot start", async () => {
    const kernel = createKernel({
      worker: () => new Scripted() as unknown as Worker,
      module: () => Promise.reject(new Error("404 Not Found")),
    });
    await expect(kernel.version()).rejects.toMatchObject({ message: expect.stringContaining("404") });
    await expect(kernel.given()).rejects.toMatchObject({ help: "reload the page" });
  });
});
