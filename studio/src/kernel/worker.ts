// The worker around the kernel. It answers one call after the other; what may be asked is in api.ts.

import type {
  Colouring, Design, DragAnswer, FaceQuery, FitResult, Fineness, Geometry, GivenMesh, MeshFormat, MeshInfo,
  ModelChange, PatchGeometry, PatchInfo, Problem, Progress, Project, Triple, Values,
} from "./api";
import { problem, type Call, type Message, type Start } from "./protocol";
import init, {
  MeshKernel, StreamKernel, editModel, readProject, rotate, setComponent, version, writeProject,
} from "./wasm/fairform_wasm.js";

/** Milliseconds between two reports of progress: what a person can see. */
const REPORT_EVERY = 40;

const post = (message: Message, transfer: Transferable[] = []) =>
  (self as unknown as { postMessage(m: Message, t: Transferable[]): void }).postMessage(message, transfer);

let mesh: MeshKernel | null = null;
let stream: StreamKernel | null = null;

function opened<T>(kernel: T | null, what: string): T {
  if (kernel === null) throw problem(`no ${what} is open`, `open a ${what} first`);
  return kernel;
}

const theMesh = () => opened(mesh, "mesh");
const theModel = () => opened(stream, "model");
const text = new TextDecoder();

/** What `make` gives, and how long it took. */
function timed<T extends object>(make: () => T): T & { milliseconds: number } {
  const start = performance.now();
  const value = make();
  return Object.assign(value, { milliseconds: performance.now() - start });
}

/** Tells progress, not more often than can be seen, but all of it. */
function reporter(id: number) {
  let steps: Progress[] = [];
  let last = performance.now();
  const flush = () => {
    if (steps.length > 0) post({ kind: "progress", id, steps });
    steps = [];
    last = performance.now();
  };
  const tell = (stage: string, iteration: number, max: number, mean: number) => {
    steps.push({ stage, iteration, max, mean });
    if (performance.now() - last > REPORT_EVERY) flush();
  };
  return { tell, flush };
}

const calls = {
  version: (): string => version(),

  openMesh(bytes: Uint8Array, name: string, repairs: string[] = []): MeshInfo {
    const opened = MeshKernel.open(bytes, name, JSON.stringify(repairs));
    mesh?.free();
    mesh = opened;
    return JSON.parse(mesh.info()) as MeshInfo;
  },
  given: () => theMesh().given() as GivenMesh,
  fit(design: Design, id: number): FitResult {
    const { tell, flush } = reporter(id);
    const result = timed(() => JSON.parse(theMesh().fit(JSON.stringify(design), tell)) as FitResult);
    flush();
    return result;
  },
  control: (iteration?: number) => theMesh().control(iteration) as Geometry,
  surface: ({ levels, limit }: Fineness, iteration?: number) =>
    theMesh().surface(levels, limit, iteration) as Geometry,
  values: (colouring: Colouring) => theMesh().values(colouring) as Values,
  query: (selected: Uint8Array, query: FaceQuery) => theMesh().query(selected, JSON.stringify(query)),
  spreadTension(design: Design, selected: Uint8Array, value: number, distance: number) {
    const tensions = theMesh().spread_tension(JSON.stringify(design), selected, value, distance);
    return JSON.parse(tensions) as [number, number][];
  },
  grab: (vertices: Uint32Array) => theMesh().grab(vertices),
  drag: ([x, y, z]: Triple): DragAnswer => timed(() => theMesh().drag(x, y, z)) as unknown as DragAnswer,
  release() {
    const start = performance.now();
    const { moves, max, answer } = theMesh().release() as
      { moves: string; max: number; answer: Omit<DragAnswer, "milliseconds"> };
    const milliseconds = performance.now() - start;
    return { moves: JSON.parse(moves) as Design["moves"], max, answer: { ...answer, milliseconds } };
  },
  save: (what: "surface" | "control" | "given", format: MeshFormat) => theMesh().save(what, format),

  openModel(bytes: Uint8Array, name: string): { model: unknown; patches: PatchInfo[] } {
    const opened = StreamKernel.open(bytes, name);
    stream?.free();
    stream = opened;
    const model: unknown = JSON.parse(text.decode(stream.text()));
    return { model, patches: JSON.parse(stream.info()) as PatchInfo[] };
  },
  setModel(model: unknown): PatchInfo[] {
    theModel().set(JSON.stringify(model));
    return JSON.parse(theModel().info()) as PatchInfo[];
  },
  patch: (index: number) => timed(() => theModel().patch(index)) as unknown as PatchGeometry,
  setTangent: (patch: number, row: number, column: number, tangent: Triple) =>
    timed(() => theModel().set_tangent(patch, row, column, new Float64Array(tangent))) as unknown as
      PatchGeometry,
  setComponent: (tangent: Triple, axis: number, value: number) =>
    Array.from(setComponent(new Float64Array(tangent), axis, value)) as Triple,
  rotate: (tangent: Triple, axis: Triple, degrees: number) =>
    Array.from(rotate(new Float64Array(tangent), new Float64Array(axis), degrees)) as Triple,
  arcs: (patch: number, rows: boolean, steps: number) => theModel().arcs(patch, rows, steps) as Float32Array,
  edit: (model: unknown, change: ModelChange): unknown =>
    JSON.parse(editModel(JSON.stringify(model), JSON.stringify(change))),
  patchValues: (patch: number, colouring: Colouring) => theModel().values(patch, colouring) as Values,
  combs: (patch: number, scale: number) => theModel().combs(patch, scale) as Float32Array,
  saveModel: () => theModel().text(),
  saveSurface: (format: MeshFormat) => theModel().save(format),

  readProject: (bytes: Uint8Array) => JSON.parse(readProject(bytes)) as Project,
  writeProject: (project: Project) => writeProject(JSON.stringify(project)),
};

/** Every call that the worker knows, by name. */
export type Calls = typeof calls;

/** The memory of all arrays in an answer, to move instead of copy. */
function buffers(value: unknown): Transferable[] {
  if (ArrayBuffer.isView(value)) return [value.buffer as ArrayBuffer];
  if (value === null || typeof value !== "object" || Array.isArray(value)) return [];
  const all = Object.values(value);
  if ("answer" in value) all.push(...Object.values(value.answer as object));
  const found = all.filter((field) => ArrayBuffer.isView(field));
  return [...new Set(found.map((field) => field.buffer as ArrayBuffer))];
}

/** What was thrown, as a problem: the kernel throws the JSON of one. */
function toProblem(thrown: unknown): Problem {
  if (typeof thrown === "string") {
    try {
      return JSON.parse(thrown) as Problem;
    } catch {
      return problem(thrown);
    }
  }
  if (thrown instanceof Error) {
    const help = "this is a fault of the program; what was there before is there again";
    return problem(`the kernel failed: ${thrown.message}`, help);
  }
  return thrown as Problem;
}

function answer({ id, name, args }: Call) {
  try {
    const all = name === "fit" ? [...args, id] : args;
    const call = calls[name as keyof Calls] as (...args: unknown[]) => unknown;
    const value = call(...all);
    post({ kind: "answer", id, value }, buffers(value));
  } catch (thrown) {
    const fatal = thrown instanceof WebAssembly.RuntimeError;
    post({ kind: "problem", id, problem: toProblem(thrown), fatal });
  }
}

self.onmessage = async ({ data }: MessageEvent<Start | Call>) => {
  if (!("kind" in data)) return answer(data);
  try {
    await init({ module_or_path: data.module });
    post({ kind: "ready" });
  } catch (thrown) {
    post({ kind: "broken", problem: toProblem(thrown) });
  }
};
