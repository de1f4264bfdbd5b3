// What the interpolation workspace knows and does, apart from how it looks.

import { batch, computed, effect, signal } from "@preact/signals";
import { announce, message } from "../announce";
import { stem } from "../files";
import type { Design, DragAnswer, FaceQuery, Fineness, MeshFormat, Repair, Scheme, Triple } from "../kernel/api";
import { problemOf } from "../kernel/problem";
import {
  designFor,
  meshDocument,
  suitableLevels,
  withCreases,
  withMoves,
  type MeshDocument,
  type Source,
} from "../state/document";
import { all, combine, fromMask, maskOf, NONE, type Combine, type Indices } from "../state/indices";
import type { Camera } from "../state/project";
import { change, settings, show } from "../state/settings";
import type { Studio } from "../studio";
import { Pipeline, type Wish } from "./pipeline";
import type { MeshScene } from "./scene";

/** What a click selects. */
export type Target = "faces" | "vertices" | "edges";
/** How it is pointed at. */
export type Gesture = "click" | "box" | "lasso" | "brush";

interface Drag {
  vertices: Indices;
  ready: Promise<void>;
  pending: Triple | null;
  busy: Promise<void> | null;
  /** Where the vertices were, 3 numbers each. */
  start: Float32Array;
  offset: Triple;
  /** A coordinate that was typed, and is meant to the last digit. */
  exact: Typed | null;
}

interface Typed {
  vertex: number;
  axis: 0 | 1 | 2;
  value: number;
}

export class Session {
  readonly studio: Studio;
  readonly main: Pipeline;
  /** The kernel of the settings to compare with, while there are some. */
  readonly other = signal<Pipeline | null>(null);
  /** Which of the two settings the panels show and change. */
  readonly side = signal<"a" | "b">("a");
  /** Update that is looked at, or null for the result. */
  readonly iteration = signal<number | null>(null);
  readonly target = signal<Target>("faces");
  readonly gesture = signal<Gesture>("click");
  readonly through = signal(false);
  readonly brushRadius = signal(24);
  /** How far a tension fades from the selection, in mean lengths of an edge. */
  readonly falloff = signal(0);
  readonly scene = signal<MeshScene | null>(null);
  /** The directions of x, y and z on the screen, as they are drawn. */
  readonly turns = signal<readonly Triple[]>([]);
  /** Where the camera shall be once there is something to see. */
  pendingCamera: Camera | null = null;
  /** Where to look from at a mesh that was just opened. */
  firstLook: Triple | null = null;
  onDrag: (answer: DragAnswer, moved: Indices, at: Float32Array) => void = () => {};

  readonly mesh = computed<MeshDocument | null>(() => this.studio.document.mesh);
  /** The design that the panels show. */
  readonly design = computed<Design | null>(() => {
    const mesh = this.mesh.value;
    return (this.side.value === "b" ? mesh?.compare : mesh?.design) ?? null;
  });
  /** The pipeline of that design. */
  readonly pipeline = computed<Pipeline>(() =>
    this.side.value === "b" && this.other.value ? this.other.value : this.main,
  );

  #drag: Drag | null = null;
  #hidden: { points: boolean; patches: boolean } | null = null;
  /** The end of the last drag: the surface settles. */
  #ending: Promise<void> = Promise.resolve();
  /** The slide of the tension that goes on or was the last: spreading begins anew from its base, or it would add up. */
  #slide: { base: Design; faces: Indices; value: number; result: Design; open: boolean } | null = null;
  #tensionAsked = false;
  #tensionRuns = false;

  constructor(studio: Studio) {
    this.studio = studio;
    this.main = new Pipeline(studio.kernel);
    effect(() => {
      void this.mesh.value?.design;
      void this.mesh.value?.source;
      this.iteration.value = null;
    });
    effect(() => this.main.want(this.#wish("a")));
    effect(() => {
      const compares = this.mesh.value?.compare != null;
      if (compares && !this.other.peek()) this.other.value = new Pipeline(studio.newKernel());
      if (!compares) {
        this.side.value = "a";
        this.other.peek()?.clear();
      }
    });
    effect(() => this.other.value?.want(this.#wish("b")));
    effect(() => {
      const fit = this.main.fit.value;
      if (!fit) return;
      const said = fit.converged ? "passes through every vertex" : "has not converged";
      // Only once nothing follows, or a slider would talk without end.
      const timer = setTimeout(() => {
        announce(`The surface ${said}: largest distance ${fit.max.toExponential(1)} of the diagonal`);
      }, 350);
      return () => clearTimeout(timer);
    });
  }

  #wish(side: "a" | "b"): Wish | null {
    const mesh = this.mesh.value;
    const design = side === "a" ? mesh?.design : mesh?.compare;
    if (!mesh || !design) return null;
    const { shown, colouring } = settings.value;
    return {
      source: mesh.source,
      repairs: mesh.repairs,
      design,
      fineness: mesh.fineness,
      iteration: side === "a" ? this.iteration.value : null,
      control: shown.control,
      colouring,
    };
  }

  // -------------------------------------------------------------- files

  async open(source: Source, repairs: readonly string[] = [], replace = false): Promise<void> {
    this.firstLook = source.look ?? null;
    try {
      const info = await this.main.open(source, repairs);
      if (source.up) change({ up: source.up });
      this.#hidePointsOf(info.vertexCount);
      const levels = suitableLevels(info.faceCount, info.mostCorners);
      const mesh = meshDocument(source, repairs, designFor(info), levels);
      const document = { ...this.studio.history.present.peek(), mesh };
      batch(() => {
        if (replace) this.studio.history.reset(document);
        else this.studio.history.commit(document, `Open ${source.name}`);
      });
      const notes = info.notes.length > 0 ? ` ${info.notes.join("; ")}` : "";
      announce(`${source.name}: ${info.vertexCount} vertices, ${info.faceCount} faces.${notes}`);
    } catch (error) {
      this.main.retry();
      const problem = problemOf(error);
      if (problem.repairs.length === 0) throw problem;
      this.studio.explain(`${source.name} needs a repair`, problem, (steps: Repair[]) => {
        message.value = null;
        const wanted = [...repairs, ...steps.map((r) => r.step)];
        void this.open(source, wanted).then(
          () => void (this.studio.gallery.value = false),
          (e: unknown) => this.studio.explain(`${source.name} cannot be opened`, e),
        );
      });
    }
  }

  /** Of a fine mesh, points and lines would only hide the surface; with the next coarse one they are back. */
  #hidePointsOf(vertexCount: number): void {
    if (vertexCount > 4000) {
      const { points, patches } = settings.peek().shown;
      this.#hidden ??= { points, patches };
      show({ points: false, patches: false });
    } else if (this.#hidden) {
      show(this.#hidden);
      this.#hidden = null;
    }
  }

  async save(what: "surface" | "control" | "given", format: MeshFormat): Promise<void> {
    const mesh = this.mesh.peek();
    if (!mesh) return;
    await this.studio.give("The file cannot be saved", `${stem(mesh.source.name)}-${what}.${format}`, async () => {
      await this.main.idle();
      return this.studio.kernel.save(what, format);
    });
  }

  async savePicture(): Promise<void> {
    const scene = this.scene.peek();
    const mesh = this.mesh.peek();
    if (!scene || !mesh) return;
    await this.studio.give("The picture cannot be saved", `${stem(mesh.source.name)}.png`, () => scene.picture());
  }

  // -------------------------------------------------------------- changes

  edit(part: Partial<MeshDocument>, label: string, key: string | null = null): void {
    const document = this.studio.history.present.peek();
    if (!document.mesh) return;
    this.studio.history.commit({ ...document, mesh: { ...document.mesh, ...part } }, label, key);
  }

  /** Changes the design that the panels show. */
  setDesign(part: Partial<Design>, label: string, key: string | null = null): void {
    const design = this.design.peek();
    if (!design) return;
    const next = { ...design, ...part };
    this.edit(this.side.peek() === "b" ? { compare: next } : { design: next }, label, key);
  }

  setFineness(part: Partial<Fineness>, key: string | null = null): void {
    const mesh = this.mesh.peek();
    if (mesh) this.edit({ fineness: { ...mesh.fineness, ...part } }, "Fineness", key);
  }

  seal(): void {
    this.studio.history.seal();
    if (this.#slide) this.#slide.open = false;
  }

  compareWith(design: Design | null): void {
    this.edit({ compare: design }, design ? "Compare two settings" : "End the comparison");
    this.side.value = design ? "b" : "a";
  }

  swapSides(): void {
    const mesh = this.mesh.peek();
    if (mesh?.compare) this.edit({ design: mesh.compare, compare: mesh.design }, "Swap the settings");
  }

  // -------------------------------------------------------------- selection

  get faceCount(): number {
    return this.main.info.value?.faceCount ?? 0;
  }

  get vertexCount(): number {
    return this.main.info.value?.vertexCount ?? 0;
  }

  pick(target: Target, picked: Indices, how: Combine, key: string | null = null): void {
    const mesh = this.mesh.peek();
    if (!mesh) return;
    const next = combine(mesh[target], picked, how);
    if (next.length === 0 && mesh[target].length === 0) return;
    this.edit({ [target]: next }, "Selection", key);
    announce(`${counted(next.length, target)} selected`);
  }

  selectAll(): void {
    const target = this.target.peek();
    const edgeCount = (this.main.given.peek()?.ends.length ?? 0) / 2;
    const count = { faces: this.faceCount, vertices: this.vertexCount, edges: edgeCount }[target];
    this.pick(target, all(count), "replace");
  }

  /** Selects the one after the last that is selected, or before the first; so everything is in reach of keys. */
  selectNext(step: 1 | -1): void {
    const mesh = this.mesh.peek();
    if (!mesh) return;
    const target = this.target.peek();
    const edgeCount = (this.main.given.peek()?.ends.length ?? 0) / 2;
    const count = { faces: this.faceCount, vertices: this.vertexCount, edges: edgeCount }[target];
    if (count === 0) return;
    const from = step === 1 ? (mesh[target].at(-1) ?? -1) : (mesh[target][0] ?? count);
    const next = (from + step + count) % count;
    this.pick(target, Uint32Array.of(next), "replace", "next");
    announce(`${SINGULAR[target]} ${next}`);
  }

  selectNone(): void {
    const mesh = this.mesh.peek();
    if (!mesh || mesh.faces.length + mesh.vertices.length + mesh.edges.length === 0) return;
    this.edit({ faces: NONE, vertices: NONE, edges: NONE }, "Selection");
    announce("Nothing is selected");
  }

  /** Changes the selection of faces by a question to the kernel; rejects with its `Problem`. */
  async query(query: FaceQuery, how: Combine = "replace"): Promise<void> {
    const mesh = this.mesh.peek();
    if (!mesh) return;
    const answer = await this.studio.kernel.query(maskOf(mesh.faces, this.faceCount), query);
    this.target.value = "faces";
    this.pick("faces", fromMask(answer), how);
  }

  /** As `query`, telling what goes wrong in the status line. */
  ask(query: FaceQuery): void {
    this.query(query).catch((error: unknown) => announce(problemOf(error).message));
  }

  selectGroup(kind: "group" | "material", name: string): void {
    const quoted = name.replace(/[\\"*?]/g, "\\$&");
    this.ask({ kind: "expression", text: `${kind}="${quoted}"` });
  }

  /** Edges between a selected face and one that is not, or on the boundary. */
  edgesAroundFaces(): void {
    const mesh = this.mesh.peek();
    const given = this.main.given.peek();
    if (!mesh || !given) return;
    const selected = maskOf(mesh.faces, this.faceCount);
    // An edge of the rim is in the outline of its one selected face exactly once.
    const sides = new Map<string, number>();
    const { triangles, faceOfTriangle } = given;
    const key = (a: number, b: number) => (a < b ? `${a} ${b}` : `${b} ${a}`);
    faceOfTriangle.forEach((f, t) => {
      if (!selected[f]) return;
      for (let i = 0; i < 3; i += 1) {
        const k = key(triangles[3 * t + i]!, triangles[3 * t + ((i + 1) % 3)]!);
        sides.set(k, (sides.get(k) ?? 0) + 1);
      }
    });
    const rim: number[] = [];
    const { ends } = given;
    for (let e = 0; 2 * e < ends.length; e += 1) {
      if (sides.get(key(ends[2 * e]!, ends[2 * e + 1]!)) === 1) rim.push(e);
    }
    this.target.value = "edges";
    this.pick("edges", Uint32Array.from(rim), "replace");
  }

  // -------------------------------------------------------------- tension, creases

  /** Sets the tension of the selected faces, or of all if none is selected. */
  setTension(value: number | null, key: string | null = "tension"): void {
    const mesh = this.mesh.peek();
    const design = this.design.peek();
    if (!mesh || !design) return;
    if (mesh.faces.length === 0) {
      this.setDesign({ tension: value }, "Tension", key);
      return;
    }
    if (!this.#slide?.open || this.#slide.faces !== mesh.faces) {
      this.#slide = { base: design, faces: mesh.faces, value: 0, result: design, open: true };
    }
    const slide = this.#slide;
    if (value === null) {
      const chosen = new Set(mesh.faces);
      this.#slide = null;
      this.setDesign({ tensions: design.tensions.filter(([face]) => !chosen.has(face)) }, "Tension");
      return;
    }
    slide.value = value;
    if (this.falloff.peek() > 0) {
      this.#spread();
      return;
    }
    const chosen = new Set(mesh.faces);
    const tensions = slide.base.tensions.filter(([face]) => !chosen.has(face));
    for (const face of mesh.faces) tensions.push([face, value]);
    this.setDesign({ tensions: tensions.sort((a, b) => a[0] - b[0]) }, "Tension", key);
    slide.result = this.design.peek() ?? design;
  }

  /** Sets how far tensions fade; the last one that was set fades anew. */
  setFalloff(rings: number): void {
    this.falloff.value = rings;
    const slide = this.#slide;
    if (!slide || slide.result !== this.design.peek() || slide.faces !== this.mesh.peek()?.faces) return;
    slide.open = true;
    this.#spread();
  }

  /** The tension of the first selected face, or of all. */
  readonly tension = computed<number>(() => {
    const design = this.design.value;
    if (!design) return 0;
    const face = this.mesh.value?.faces[0];
    const own = face === undefined ? undefined : design.tensions.find(([f]) => f === face)?.[1];
    return own ?? design.tension ?? TENSIONS[design.scheme]?.plain ?? 0;
  });

  stepTension(by: number): void {
    const range = TENSIONS[this.design.peek()?.scheme ?? "loop"];
    if (!range) return;
    const next = Math.min(range.max, Math.max(range.min, this.tension.peek() + by));
    this.setTension(Math.round(next * 1000) / 1000);
    this.seal();
  }

  /** While the kernel answers, the slider moves on; only its last value counts. */
  #spread(): void {
    this.#tensionAsked = true;
    if (this.#tensionRuns) return;
    this.#tensionRuns = true;
    void this.#spreadAll().finally(() => {
      this.#tensionRuns = false;
    });
  }

  async #spreadAll(): Promise<void> {
    try {
      while (this.#tensionAsked) {
        this.#tensionAsked = false;
        const slide = this.#slide;
        if (!slide) return;
        const mask = maskOf(slide.faces, this.faceCount);
        const tensions = await this.studio.kernel.spreadTension(slide.base, mask, slide.value, this.falloff.peek());
        if (slide !== this.#slide) continue;
        this.setDesign({ tensions }, "Tension", "tension");
        slide.result = this.design.peek() ?? slide.base;
      }
    } catch (error) {
      announce(problemOf(error).message);
    }
  }

  setSharpness(sharpness: number, key: string | null = null): void {
    const mesh = this.mesh.peek();
    const ends = this.main.given.peek()?.ends;
    const design = this.design.peek();
    if (!mesh || !ends || !design) return;
    const edges = [...mesh.edges].map((e) => [ends[2 * e]!, ends[2 * e + 1]!] as const);
    this.setDesign({ creases: withCreases(design.creases, edges, sharpness) }, "Creases", key);
  }

  // -------------------------------------------------------------- moving vertices

  /** Where a vertex of the given mesh is now. */
  placeOf(vertex: number): Triple | null {
    const move = this.mesh.value?.design.moves.find((m) => m[0] === vertex);
    if (move) return [move[1], move[2], move[3]];
    const positions = this.main.given.value?.positions;
    if (!positions || 3 * vertex + 2 >= positions.length) return null;
    return [positions[3 * vertex]!, positions[3 * vertex + 1]!, positions[3 * vertex + 2]!];
  }

  beginDrag(): void {
    const vertices = this.mesh.peek()?.vertices ?? NONE;
    if (vertices.length === 0 || this.#drag) return;
    const start = new Float32Array(3 * vertices.length);
    vertices.forEach((v, i) => start.set(this.placeOf(v) ?? [0, 0, 0], 3 * i));
    this.#drag = { vertices, ready: this.main.grab(vertices), pending: null, busy: null, start, offset: [0, 0, 0], exact: null };
    // Reported when the drag ends; here only so that it is not reported twice.
    this.#drag.ready.catch(() => {});
  }

  /** Moves what is dragged; while the kernel works, only the last place counts. */
  drag(offset: Triple): void {
    const drag = this.#drag;
    if (!drag) return;
    drag.offset = offset;
    drag.pending = offset;
    drag.busy ??= this.#follow(drag).finally(() => {
      drag.busy = null;
    });
  }

  async #follow(drag: Drag): Promise<void> {
    try {
      await drag.ready;
    } catch {
      return;
    }
    for (let offset = drag.pending; offset; offset = drag.pending) {
      drag.pending = null;
      const answer = await this.main.drag(offset);
      this.onDrag(answer, drag.vertices, placesAt(drag, offset));
    }
  }

  endDrag(): Promise<void> {
    const drag = this.#drag;
    this.#drag = null;
    if (drag) this.#ending = this.#end(drag);
    return this.#ending;
  }

  /** Resolves when nothing is left to compute. */
  async idle(): Promise<void> {
    await this.#ending;
    await this.main.idle();
    await this.other.peek()?.idle();
  }

  async #end(drag: Drag): Promise<void> {
    try {
      await drag.ready;
      await drag.busy;
      const answer = await this.main.release((moves) => {
        const design = this.#commitMoves(withTyped(moves, drag.exact));
        return drag.exact ? null : design;
      });
      this.onDrag(answer, drag.vertices, placesAt(drag, drag.offset));
    } catch {
      // Without a fit to settle, the vertices still go where they were put.
      this.#commitMoves(withTyped(movesAt(drag), drag.exact));
    }
  }

  /** Puts the first selected vertex at a coordinate; the others move with it. */
  typeCoordinate(axis: 0 | 1 | 2, value: number): void {
    const vertex = this.mesh.peek()?.vertices[0];
    const place = vertex === undefined ? null : this.placeOf(vertex);
    if (vertex === undefined || !place) return;
    const offset: Triple = [0, 0, 0];
    offset[axis] = value - place[axis];
    this.nudge(offset, { vertex, axis, value });
  }

  /** Moves selected vertices by an offset, as one step. */
  nudge(offset: Triple, exact: Typed | null = null): void {
    if (this.#drag) return;
    this.beginDrag();
    const drag = this.#drag as Drag | null;
    if (drag) drag.exact = exact;
    this.drag(offset);
    void this.endDrag();
  }

  #commitMoves(moves: Design["moves"]): Design {
    const mesh = this.mesh.peek()!;
    const design = { ...mesh.design, moves: withMoves(mesh.design.moves, moves) };
    const compare = mesh.compare && { ...mesh.compare, moves: withMoves(mesh.compare.moves, moves) };
    this.edit({ design, compare }, moves.length === 1 ? "Move a vertex" : "Move vertices");
    return design;
  }

  resetMoves(): void {
    const mesh = this.mesh.peek();
    if (!mesh) return;
    const chosen = new Set(mesh.vertices);
    const keep = (moves: Design["moves"]) => moves.filter(([v]) => !chosen.has(v));
    const design = { ...mesh.design, moves: keep(mesh.design.moves) };
    const compare = mesh.compare && { ...mesh.compare, moves: keep(mesh.compare.moves) };
    this.edit({ design, compare }, "Put vertices back");
  }
}

/** Ranges of the shape parameter, and the value of the plain scheme; null where a scheme has none. */
export const TENSIONS: Record<Scheme, { min: number; max: number; plain: number } | null> = {
  loop: { min: 0.5, max: 1, plain: 0.5 },
  "catmull-clark": { min: 0.5, max: 1, plain: 0.5 },
  "doo-sabin": { min: 0.01, max: 1, plain: 0.5 },
  butterfly: null,
  kobbelt: null,
};

const SINGULAR: Record<Target, string> = { faces: "face", vertices: "vertex", edges: "edge" };

/** `1 vertex`, `12 vertices`. */
export function counted(count: number, kind: Target): string {
  return `${count.toLocaleString("en")} ${count === 1 ? SINGULAR[kind] : kind}`;
}

function placesAt(drag: Drag, offset: Triple): Float32Array {
  return drag.start.map((x, i) => x + offset[i % 3]!);
}

function withTyped(moves: Design["moves"], exact: Typed | null): Design["moves"] {
  if (!exact) return moves;
  return moves.map((move) => {
    if (move[0] !== exact.vertex) return move;
    const typed: typeof move = [...move];
    typed[exact.axis + 1] = exact.value;
    return typed;
  });
}

function movesAt(drag: Drag): Design["moves"] {
  const places = placesAt(drag, drag.offset);
  return [...drag.vertices].map((v, i) => [v, places[3 * i]!, places[3 * i + 1]!, places[3 * i + 2]!]);
}
