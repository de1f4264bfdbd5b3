// The kernel as the page sees it: every call of api.ts, answered by a worker.
//
// Calls are sent one after the other. What runs is cancelled by ending its worker; another one then opens
// again what was open, from what was asked of the first, and goes on with the calls that wait.

import type { Design, DragAnswer, Fineness, Kernel, Problem, Progress, Triple } from "./api";
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
  let worker: Worker | null = null;
  let isReady = false;
  let broken: Problem | null = null;
  let running: Waiting | null = null;
  let queue: Waiting[] = [];
  let nextId = 1;
  /** A fit overtook the one that a new worker was to repeat; if it fails, that is needed after all. */
  let overtaken = false;
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
        if (call.name === "fit" && overtaken) {
          overtaken = false;
          again("surface", state.surface, true);
          again("fit", state.fit && [state.fit], true);
        }
        call.reject(message.problem);
        break;
      }
    }
    next();
  }

  function next() {
    if (!isReady || running !== null) return;
    running = queue.shift() ?? null;
    if (running !== null) worker?.postMessage({ id: running.id, name: running.name, args: running.args });
  }

  /** Keeps what a new worker would have to be told. */
  function remember({ name, args, replay }: Waiting, value: unknown) {
    if (replay) return;
    switch (name) {
      case "openMesh":
        [state.open, state.fit, state.surface] = [args, null, null];
        break;
      case "fit":
        overtaken = false;
        [state.fit, state.surface] = [args[0] as Design, null];
        break;
      case "release":
        // The vertices are where they were released.
        if (state.fit !== null) state.fit = { ...state.fit, moves: (value as { moves: Design["moves"] }).moves };
        break;
      case "surface":
        state.surface = args as State["surface"];
        break;
      case "openModel":
        [state.model, state.set] = [args, null];
        state.tangents.clear();
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

  function enqueue(name: string, args: unknown[], more: Partial<Waiting> = {}): Promise<unknown> {
    if (broken !== null) return Promise.reject(broken);
    return new Promise((resolve, reject) => {
      if (more.replay !== true) overtake(name);
      queue.push({ id: nextId++, name, args, resolve, reject, replay: false, ...more });
      if (worker === null) start();
      next();
    });
  }

  /** Takes from the queue what was only to be repeated, and is replaced by this call. */
  function overtake(name: string) {
    const replaced = { fit: ["fit", "surface"], openMesh: ["openMesh", "fit", "surface"] }[name] ?? [];
    const before = queue.length;
    queue = queue.filter((call) => !(call.replay && replaced.includes(call.name)));
    if (name === "fit" && queue.length < before) overtaken = true;
  }

  /** Repeats a call that went well; `first`: before all that waits. */
  function again(name: string, args: unknown[] | null, first = false) {
    if (args === null) return;
    // What went well once goes well again; if not, the calls to come say so.
    const ignore = () => {};
    const call = { id: nextId++, name, args, resolve: ignore, reject: ignore, replay: true };
    if (first) queue.unshift(call);
    else queue.push(call);
  }

  function call<N extends keyof Calls>(name: N, ...args: unknown[]): Promise<ReturnType<Calls[N]>> {
    return enqueue(name, args) as Promise<ReturnType<Calls[N]>>;
  }

  /** Ends the worker and brings another to where it was. */
  function restart() {
    const waiting = queue;
    queue = [];
    worker?.terminate();
    running = null;
    start();
    overtaken = false;
    again("openMesh", state.open);
    again("fit", state.fit && [state.fit]);
    again("surface", state.surface);
    again("openModel", state.model);
    again("setModel", state.set);
    state.tangents.forEach((tangent) => again("setTangent", tangent));
    queue.push(...waiting);
  }

  return {
    version: () => call("version"),

    openMesh: (bytes, name, repairs) => call("openMesh", bytes.slice(), name, repairs ?? []),
    given: () => call("given"),
    fit: (design, progress) =>
      enqueue("fit", [structuredClone(design)], { progress }) as ReturnType<Kernel["fit"]>,
    async cancel() {
      if (running === null || running.replay) return;
      const { reject } = running;
      restart();
      reject(cancelled);
    },
    control: (iteration) => call("control", iteration),
    surface: (fineness, iteration) => call("surface", { ...fineness }, iteration),
    // Both workspaces have values and files; patches come first.
    values: ((...args: unknown[]) =>
      args.length > 1 ? call("patchValues", ...args) : call("values", ...args)) as Kernel["values"],
    query: (selected, query) => call("query", selected, query),
    spreadTension: (design, selected, value, distance) =>
      call("spreadTension", design, selected, value, distance),
    grab: (vertices) => call("grab", vertices),
    drag(offset) {
      // Only the newest offset is sent: who asked for one that was still waiting gets the answer to this.
      const last = queue.at(-1);
      if (last?.name !== "drag") return call("drag", [...offset] as Triple);
      last.args = [[...offset]];
      return new Promise<DragAnswer>((resolve, reject) => {
        const { resolve: before, reject: beforeReject } = last;
        last.resolve = ((answer: DragAnswer) => (before(answer as never), resolve(answer))) as Waiting["resolve"];
        last.reject = (why) => (beforeReject(why), reject(why));
      });
    },
    release: () => call("release"),
    save: ((...args: unknown[]) =>
      args.length > 1 ? call("save", ...args) : call("saveSurface", ...args)) as Kernel["save"],

    openModel: (bytes, name) => call("openModel", bytes.slice(), name),
    setModel: (model) => call("setModel", structuredClone(model)),
    patch: (index) => call("patch", index),
    setTangent: (patch, row, column, tangent) => call("setTangent", patch, row, column, tangent),
    setComponent: (tangent, axis, value) => call("setComponent", tangent, axis, value),
    rotate: (tangent, axis, degrees) => call("rotate", tangent, axis, degrees),
    arcs: (patch, rows, steps) => call("arcs", patch, rows, steps),
    edit: (model, change) => call("edit", structuredClone(model), change),
    combs: (patch, scale) => call("combs", patch, scale),
    saveModel: () => call("saveModel"),

    readProject: (bytes) => call("readProject", bytes),
    writeProject: (project) => call("writeProject", project),
  };
}
