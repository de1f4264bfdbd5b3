// `window.fairform`, for tests only: what the page has, and where things are on the screen. Nothing in the
// studio uses it, and it changes without notice.

import type { Session } from "./interpolation/session";
import { list, run } from "./actions";
import { message, status } from "./announce";
import { fingerprint } from "./fingerprint";
import { MEASURES, summary, type Measure } from "./perf";
import { settings } from "./state/settings";
import { streamHooks, type StreamHooks } from "./stream/testing";
import type { StreamSession } from "./stream/session";
import type { Studio } from "./studio";
import { current } from "./workspace";

export interface TestHooks {
  /** Plain data: the document without the bytes of the file, and what was computed from it. */
  state: () => Snapshot;
  /** Resolves when the kernel has nothing left to do. */
  idle: () => Promise<void>;
  /** Where a vertex of the given mesh is on the page, in CSS pixels. */
  screenOf: (vertex: number) => { x: number; y: number } | null;
  /** Where a click selects a face; null if it is hidden. */
  screenOfFace: (face: number) => { x: number; y: number } | null;
  /** The vertex that a click finds. */
  vertexAt: (x: number, y: number) => number | null;
  /** Vertices of the given mesh, and the first as many of the surface, as they are drawn, 3 numbers each. */
  places: () => { given: number[]; surface: number[] };
  /** Names of all actions, and running one. */
  actions: () => string[];
  run: (name: string) => boolean;
  /** Saves at once what waits to be saved. */
  flush: () => Promise<void>;
  /** The streamline workspace. */
  stream: StreamHooks;
}

declare global {
  var fairform: TestHooks | undefined;
}

export function offerTestHooks(studio: Studio, session: Session, stream: StreamSession): void {
  globalThis.fairform = {
    state: () => snapshot(studio, session),
    idle: async () => {
      await session.idle();
      await stream.idle();
    },
    screenOf: (vertex) => session.scene.peek()?.screenOf(vertex) ?? null,
    screenOfFace: (face) => session.scene.peek()?.picker.screenOfFace(face) ?? null,
    vertexAt: (x, y) => session.scene.peek()?.picker.vertexAt(x, y) ?? null,
    places: () => {
      const view = session.scene.peek()?.view;
      const given = [...(view?.givenPositions ?? [])];
      return { given, surface: [...(view?.surface?.positions.subarray(0, given.length) ?? [])] };
    },
    actions: () => list().map((action) => action.name),
    run,
    flush: () => studio.autosave.flush(),
    stream: streamHooks(stream),
  };
}

type Times = Record<Measure, ReturnType<typeof summary>>;

export type Snapshot = ReturnType<typeof snapshot>;

function snapshot(studio: Studio, session: Session) {
  const { mesh, model } = studio.history.present.peek();
  const { main } = session;
  const surface = main.surface.peek();
  const control = main.control.peek();
  const drawn = session.scene.peek()?.view.surface?.positions;
  const hasTrouble = main.trouble.peek() !== null || message.peek() !== null;
  return {
    workspace: current.peek(),
    /** Whether there is something to see, or a reason why not. */
    settled: surface !== null || model !== null || hasTrouble,
    mesh: mesh && {
      name: mesh.source.name,
      repairs: mesh.repairs,
      design: mesh.design,
      compare: mesh.compare,
      fineness: mesh.fineness,
      faces: [...mesh.faces],
      vertices: [...mesh.vertices],
      edges: [...mesh.edges],
    },
    model,
    settings: settings.peek(),
    info: main.info.peek(),
    fit: main.fit.peek(),
    stage: main.stage.peek(),
    trouble: main.trouble.peek(),
    iteration: session.iteration.peek(),
    surface: surface && { points: surface.positions.length / 3, triangles: surface.triangles.length / 3 },
    /** Of the points of the surface as they are drawn. */
    fingerprint: drawn ? fingerprint(drawn) : null,
    control: control && { points: control.positions.length / 3 },
    values: main.values.peek() && { ...main.values.peek(), values: undefined },
    camera: session.scene.peek()?.viewport.view ?? null,
    undo: studio.history.undoLabel,
    redo: studio.history.redoLabel,
    status: status.peek(),
    milliseconds: Object.fromEntries(MEASURES.map((what) => [what, summary(what)])) as Times,
  };
}
