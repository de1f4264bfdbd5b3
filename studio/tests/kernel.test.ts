// The compiled kernel itself, asked through client and worker as the page asks, against values that were computed
// independently of this project.

import { readFileSync, readdirSync } from "node:fs";
import { fileURLToPath } from "node:url";
import { beforeAll, describe, expect, it } from "vitest";
import type { Design, Kernel, Problem } from "../src/kernel/api";
import { createKernel } from "../src/kernel/client";
import type { Call, Message, Start } from "../src/kernel/protocol";

type Point = [number, number, number];

interface Golden {
  scheme: Design["scheme"];
  mesh: { vertices: Point[]; faces: number[][] };
  lambda?: number | number[] | null;
  boundary?: string;
  corners?: string;
  interpolation: { stages: unknown[]; iterates: Record<string, Point[]>; exact: Point[] | null };
}

const file = (path: string) => fileURLToPath(new URL(`../${path}`, import.meta.url));
const golden = (path: string) => JSON.parse(readFileSync(file(`../data/golden/${path}`), "utf8")) as never;
const names = (folder: string) => readdirSync(file(`../data/golden/${folder}`)).map((name) => `${folder}/${name}`);

/** worker.ts in this thread: it speaks to whoever made it through `self`. */
class Here {
  onmessage: ((event: { data: Message }) => void) | null = null;
  onerror = null;
  private readonly started: Promise<unknown>;
  private readonly self = {
    onmessage: (_: { data: Start | Call }): unknown => undefined,
    postMessage: (data: Message) => this.onmessage?.({ data: structuredClone(data) }),
  };

  constructor() {
    Object.assign(globalThis, { self: this.self });
    this.started = import("../src/kernel/worker");
  }

  postMessage(message: Start | Call) {
    // A module cannot be copied here, and need not be.
    const data = "kind" in message ? message : structuredClone(message);
    void this.started.then(() => this.self.onmessage({ data }));
  }

  terminate() {}
}

let kernel: Kernel;

beforeAll(async () => {
  const wasm = readFileSync(file("src/kernel/wasm/fairform_wasm_bg.wasm"));
  const module = await WebAssembly.compile(new Uint8Array(wasm));
  kernel = createKernel({ worker: () => new Here() as unknown as Worker, module: () => Promise.resolve(module) });
});

const plain: Design = {
  scheme: "loop", method: "plain", tolerance: 1e-300, iterations: 20, exact: false, fair: null, corners: "smooth",
  border: "bspline", tension: null, tensions: [], creases: [], moves: [],
};

const text = (value: string) => new TextEncoder().encode(value);

function obj({ vertices, faces }: Golden["mesh"]): Uint8Array {
  const lines = vertices.map((v) => `v ${v.join(" ")}`);
  return text([...lines, ...faces.map((f) => `f ${f.map((v) => v + 1).join(" ")}`), ""].join("\n"));
}

/** The vertices of an OBJ file, to the last digit. */
const points = (bytes: Uint8Array): Point[] =>
  new TextDecoder().decode(bytes).split("\n").filter((line) => line.startsWith("v "))
    .map((line) => line.split(" ").slice(1, 4).map(Number) as Point);

/** The largest difference of coordinates. */
function difference(actual: Iterable<number>, expected: number[]): number {
  const list = [...actual];
  expect(list.length).toBe(expected.length);
  return Math.max(...list.map((x, i) => Math.abs(x - expected[i]!)));
}

const size = (mesh: Golden["mesh"]) => Math.max(...mesh.vertices.flat().map(Math.abs));

function designOf({ scheme, lambda, boundary, corners }: Golden): Design {
  return {
    ...plain,
    scheme,
    tension: typeof lambda === "number" ? lambda : null,
    tensions: Array.isArray(lambda) ? lambda.map((value, f) => [f, value]) : [],
    border: boundary === "drop" ? "drop" : "bspline",
    corners: corners === "sharp" ? "sharp" : "smooth",
  };
}

const meshes = ["loop", "catmull-clark", "doo-sabin"].flatMap(names);

describe.each(meshes.filter((name) => "interpolation" in (golden(name) as object)))("%s", (name) => {
  const value: Golden = golden(name);
  const { mesh, interpolation } = value;
  const { iterates, stages } = interpolation;

  it("the iterates are those of the reference", async () => {
    await kernel.openMesh(obj(mesh), "golden.obj");
    const result = await kernel.fit(designOf(value));
    // Where nothing interpolates at level 0, or rounding is all that is left, there are no twenty updates to compare.
    if (result.controlLevel > 0 || result.history.length !== 21 * stages.length) return;
    const control = points(await kernel.save("control", "obj"));
    expect(difference(control.flat(), iterates["20"]!.flat())).toBeLessThan(1e-12 * size(mesh));
    if (stages.length > 1) return;
    for (const k of [1, 5]) {
      // What is drawn has single precision.
      const { positions } = await kernel.control(k);
      expect(difference(positions, iterates[k]!.flat())).toBeLessThan(1e-6 * size(mesh));
    }
  });

  it("the surface passes through the vertices", async () => {
    await kernel.openMesh(obj(mesh), "golden.obj");
    const design = { ...designOf(value), method: "auto", tolerance: 1e-9, iterations: 10_000 } as const;
    const result = await kernel.fit(design);
    expect(result.max).toBeLessThan(1e-9);
    if (value.scheme === "doo-sabin" || value.boundary === "drop") return;
    // Vertex i stays vertex i.
    const { positions } = await kernel.surface({ levels: 2, limit: true });
    const first = positions.slice(0, 3 * mesh.vertices.length);
    expect(difference(first, mesh.vertices.flat())).toBeLessThan(1e-6 * size(mesh));
  });
});

describe.each(names("streamline"))("%s", (name) => {
  const { spec, result, kind }: { spec: unknown; kind: string; result: { points: Point[][] } } = golden(name);

  it.runIf(kind === "surface")("the points are those of the reference", async () => {
    const { model } = await kernel.openModel(text(JSON.stringify(spec)), "golden.streamline.json");
    await kernel.setModel(model);
    const patch = await kernel.patch(0);
    const expected = result.points.flat(2);
    const extent = Math.max(...expected.map(Math.abs));
    expect(difference(patch.positions, expected)).toBeLessThan(1e-6 * extent);
  });
});

it("a bad file is a problem with a place and a way out, and the next call is answered", async () => {
  const problem = await kernel.openMesh(text("v 0 0 0\nv 1 0 x\n"), "bad.obj").then(
    () => expect.fail("it was opened"),
    (problem: Problem) => problem,
  );
  expect(problem.message).toContain("line 2");
  expect(problem.cancelled).toBe(false);
  expect(await kernel.version()).toMatch(/^\d+\.\d+\.\d+/);
});

it("an unoriented mesh is opened by the repairs that are offered", async () => {
  const mesh = { vertices: [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]] as Point[], faces: [[0, 1, 2], [0, 3, 2]] };
  mesh.faces[1] = [0, 3, 2];
  const problem = await kernel.openMesh(obj(mesh), "turned.obj").then(
    () => null,
    (problem: Problem) => problem,
  );
  expect(problem?.repairs.length).toBeGreaterThan(0);
  const info = await kernel.openMesh(obj(mesh), "turned.obj", problem!.repairs.map((repair) => repair.step));
  expect(info.faceCount).toBe(2);
});
