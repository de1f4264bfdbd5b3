// The kernel as the page sees it: every call of api.ts, answered by a worker.
//
// Calls are sent one after the other, so their arguments are copied: the page may change its own meanwhile.
// What runs is cancelled by ending its worker. Another one is told what the old one knew, from what was asked of
// it, as far as the calls that come need it.

import type { Design, DragAnswer, Fineness, Kernel, PatchGeometry, Problem, Progress } from "./api";
import { problem, type Message } from "./protocol";
import type { Calls } from "./worker";
import wasmUrl from "./wasm/fairform_wasm_bg.wasm?url";

interface Waiting {
  id: number;
  name: string;
  args: unknown[];
  progress?: (step: Progress) => void;
  resolve: (value: never) => void;
  reject: (problem: Problem) => void;
  /** Whether it only brings a new worker to where the old one was. */
  replay: boolean;
}

/** What a new worker is told to be where the old one was. */
interface State {
  open: unknown[] | null;
  fit: Design | null;
  surface: [Fineness, number | undefined] | null;
  model: unknown[] | null;
  set: unknown[] | null;
  /** Tangents set since, by patch, row and column. */
  tangents: Map<string, unknown[]>;
}

/** What a worker may have to be told again. */
type Part = "mesh" | "fit" | "surface" | "model";

/** What calls rely on that was there before. */
function needs(name: string): Part[] {
  switch (name) {
    case "fit":
      return ["mesh"];
    case "given":
    case "control":
    case "surface":
    case "query":
    case "spreadTension":
      return ["mesh", "fit"];
    case "values":
    case "save":
    case "grab":
    case "drag":
    case "release":
      return ["mesh", "fit", "surface"];
    case "setModel":
    case "patch":
    case "setTangent":
    case "arcs":
    case "patchValues":
    case "combs":
    case "saveModel":
    case "saveSurface":
      return ["model"];
    default:
      return [];
  }
}

export interface Options {
  /** Makes a worker; for tests. */
  worker?: () => Worker;
  /** The compiled kernel; for tests. */
  module?: () => Promise<WebAssembly.Module>;
}

const cancelled: Problem = { message: "cancelled", help: null, repairs: [], cancelled: true };

async function compile(): Promise<WebAssembly.Module> {
  const answer = await fetch(wasmUrl);
  if (!answer.ok) throw new Error(`${answer.status} ${answer.statusText}`);
  // Servers that do not know the type of the file are served too.
  const isKnown = answer.headers.get("Content-Type")?.startsWith("application/wasm") ?? false;
  return isKnown ? WebAssembly.compileStreaming(answer) : WebAssembly.compile(await answer.arrayBuffer());
}

export function createKernel(options: Options = {}): Kernel {
  const newWorker =
    options.worker ?? (() => new Worker(new URL("./worker.ts", import.meta.url), { type: "module" }));
  const module = (options.module ?? compile)();
  // Who calls is told.
  module.catch(() => undefined);
  let worker: Worker | null = null;
  let isReady = false;
  let broken: Problem | null = null;
  let running: Waiting | null = null;
  let queue: Waiting[] = [];
  let nextId = 1;
  /** What the worker does not know yet, and the calls that are on their way to tell it. */
  const stale = new Set<Part>();
  let again: [string, unknown[]][] = [];
  const state: State = { open: null, fit: null, surface: null, model: null, set: null, tangents: new Map() };

  function fail(why: Problem) {
    broken = why;
    const all = running ? [running, ...queue] : queue;
    running = null;
    queue = [];
    for (const call of all) call.reject(why);
  }

  function start() {
    isReady = false;
    const mine = newWorker();
    worker = mine;
    mine.onmessage = ({ data }: MessageEvent<Message>) => {
      if (mine === worker) hear(data);
    };
    mine.onerror = (event) => {
      if (mine === worker) fail(problem(`the kernel failed: ${event.message}`, "reload the page"));
    };
    module.then(
      (module) => mine.postMessage({ kind: "start", module }),
      (error: Error) => fail(problem(`the kernel cannot be loaded: ${error.message}`, "reload the page")),
    );
  }

  function hear(message: Message) {
    switch (message.kind) {
      case "ready":
        isReady = true;
        break;
      case "broken":
        return fail(message.problem);
      case "progress":
        if (running?.id === message.id) (message.steps as Progress[]).forEach((s) => running?.progress?.(s));
        return;
      case "answer": {
        const call = running;
        if (call?.id !== message.id) return;
        running = null;
        remember(call, message.value);
        call.resolve(message.value as never);
        break;
      }
      case "problem": {
        const call = running;
        if (call?.id !== message.id) return;
        running = null;
        call.reject(message.problem);
        if (!message.fatal) break;
        // What cannot even be opened again is given up.
        if (call.replay) forget();
        return restart();
      }
    }
    next();
  }

  function next() {
    if (!isReady || running !== null || queue.length === 0) return;
    for (const part of needs(queue[0]!.name)) {
      if (stale.delete(part)) again.push(...replays(part));
    }
    const replay = again.shift();
    if (replay !== undefined) {
      const [name, args] = replay;
      // What went well once goes well again; if not, the calls to come say so.
      const nothing = () => undefined;
      running = { id: nextId++, name, args, resolve: nothing, reject: nothing, replay: true };
    } else {
      running = queue.shift()!;
    }
    worker?.postMessage({ id: running.id, name: running.name, args: running.args });
  }

  function replays(part: Part): [string, unknown[]][] {
    const call = (name: string, args: unknown[] | null): [string, unknown[]][] => (args ? [[name, args]] : []);
    switch (part) {
      case "mesh":
        return call("openMesh", state.open);
      case "fit":
        return call("fit", state.fit && [state.fit]);
      case "surface":
        return call("surface", state.surface);
      case "model": {
        const tangents = [...state.tangents.values()].flatMap((args) => call("setTangent", args));
        return [...call("openModel", state.model), ...call("setModel", state.set), ...tangents];
      }
    }
  }

  /** Keeps what a new worker would have to be told. */
  function remember({ name, args, replay }: Waiting, value: unknown) {
    if (replay) return;
    switch (name) {
      case "openMesh":
        [state.open, state.fit, state.surface] = [args, null, null];
        for (const part of ["mesh", "fit", "surface"] as const) stale.delete(part);
        break;
      case "fit":
        [state.fit, state.surface] = [args[0] as Design, null];
        for (const part of ["fit", "surface"] as const) stale.delete(part);
        break;
      case "release":
        // The vertices are where they were released.
        if (state.fit !== null) state.fit = { ...state.fit, moves: (value as { moves: Design["moves"] }).moves };
        break;
      case "surface":
        state.surface = args as State["surface"];
        stale.delete("surface");
        break;
      case "openModel":
        [state.model, state.set] = [args, null];
        state.tangents.clear();
        stale.delete("model");
        break;
      case "setModel":
        state.set = args;
        state.tangents.clear();
        break;
      case "setTangent":
        state.tangents.set(args.slice(0, 3).join(), args);
        break;
    }
  }

  function forget() {
    Object.assign(state, { open: null, fit: null, surface: null, model: null, set: null });
    state.tangents.clear();
  }

  function enqueue(name: string, args: unknown[], progress?: (step: Progress) => void): Promise<unknown> {
    if (broken !== null) return Promise.reject(broken);
    return new Promise((resolve, reject) => {
      queue.push({ id: nextId++, name, args, resolve, reject, replay: false, ...(progress && { progress }) });
      if (worker === null) start();
      next();
    });
  }

  function call<N extends keyof Calls>(name: N, ...args: unknown[]): Promise<ReturnType<Calls[N]>> {
    return enqueue(name, args) as Promise<ReturnType<Calls[N]>>;
  }

  /**
   * A call of which only the newest counts: one that still waits, at the end of the queue and with the same first
   * `count` arguments, is sent with these instead; who asked for it gets the answer to this.
   */
  function latest<T>(name: keyof Calls, args: unknown[], count: number): Promise<T> {
    const last = queue.at(-1);
    const isSame = last?.name === name && args.slice(0, count).every((a, i) => a === last.args[i]);
    if (last === undefined || !isSame) return enqueue(name, args) as Promise<T>;
    last.args = args;
    return new Promise<T>((resolve, reject) => {
      const { resolve: resolveFirst, reject: rejectFirst } = last;
      last.resolve = ((answer: T) => {
        resolveFirst(answer as never);
        resolve(answer);
      }) as Waiting["resolve"];
      last.reject = (why) => {
        rejectFirst(why);
        reject(why);
      };
    });
  }

  /** Ends the worker; another is told what the old one knew once that is needed. */
  function restart() {
    worker?.terminate();
    running = null;
    again = [];
    for (const part of ["mesh", "fit", "surface", "model"] as const) stale.add(part);
    start();
  }

  return {
    version: () => call("version"),

    openMesh: (bytes, name, repairs) => call("openMesh", bytes.slice(), name, repairs ?? []),
    given: () => call("given"),
    fit: (design, progress) =>
      enqueue("fit", [structuredClone(design)], progress) as ReturnType<Kernel["fit"]>,
    async cancel() {
      if (running !== null && !running.replay) {
        const { reject } = running;
        restart();
        return reject(cancelled);
      }
      // A new worker is on its way to where the old one was: what would run next does not begin.
      queue.shift()?.reject(cancelled);
    },
    control: (iteration) => call("control", iteration),
    surface: (fineness, iteration) => call("surface", { ...fineness }, iteration),
    // Both workspaces have values and files; patches come first.
    values: ((...args: unknown[]) =>
      args.length > 1 ? call("patchValues", ...args) : call("values", ...args)) as Kernel["values"],
    query: (selected, query) => call("query", selected.slice(), query),
    spreadTension: (design, selected, value, distance) =>
      call("spreadTension", structuredClone(design), selected.slice(), value, distance),
    grab: (vertices) => call("grab", vertices.slice()),
    drag: (offset) => latest<DragAnswer>("drag", [[...offset]], 0),
    release: () => call("release"),
    save: ((...args: unknown[]) =>
      args.length > 1 ? call("save", ...args) : call("saveSurface", ...args)) as Kernel["save"],

    openModel: (bytes, name) => call("openModel", bytes.slice(), name),
    setModel: (model) => call("setModel", structuredClone(model)),
    patch: (index) => call("patch", index),
    setTangent: (patch, row, column, tangent) =>
      latest<PatchGeometry>("setTangent", [patch, row, column, [...tangent]], 3),
    setComponent: (tangent, axis, value) => call("setComponent", tangent, axis, value),
    rotate: (tangent, axis, degrees) => call("rotate", tangent, axis, degrees),
    arcs: (patch, rows, steps) => call("arcs", patch, rows, steps),
    edit: (model, change) => call("edit", structuredClone(model), change),
    combs: (patch, scale) => call("combs", patch, scale),
    saveModel: () => call("saveModel"),

    readProject: (bytes) => call("readProject", bytes.slice()),
    writeProject: (project) => call("writeProject", structuredClone(project)),
  };
}
