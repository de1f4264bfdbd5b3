// What the streamline workspace knows and does, apart from how it looks.
//
// The model in the document is what is wished; `#held` is what the kernel has. One loop brings the kernel and
// the pictures after the wishes, the newest first: a tangent that is dragged, then another model, then what is
// drawn beside the surface.

import { batch, computed, effect, signal } from "@preact/signals";
import { announce } from "../announce";
import { stem } from "../files";
import type {
  Colouring,
  Kernel,
  MeshFormat,
  ModelChange,
  PatchGeometry,
  PatchInfo,
  Problem,
  StreamKernel,
  Triple,
  Values,
} from "../kernel/api";
import { problemOf } from "../kernel/problem";
import { record, timed } from "../perf";
import type { Document, Source } from "../state/document";
import type { Camera } from "../state/project";
import { change, settings } from "../state/settings";
import type { Studio } from "../studio";
import { Levels, tripleAt, type ControlGrid } from "./levels";
import {
  clampPlace,
  detailAt,
  fineLine,
  nameOf,
  ownerOf,
  patchesOf,
  stitchOf,
  tangentOf,
  withHandle,
  withoutDetails,
  withAllPatches,
  withDetail,
  withPatch,
  withTangent,
  type Patch,
  type Place,
} from "./model";
import type { StreamScene } from "./scene";

/** Points on the great arc between two neighbours. */
export const ARC_STEPS = 17;

/** A tangent that shall be set, and to what; `to` may have to ask the kernel. */
interface Move {
  patch: number;
  level: number;
  place: Place;
  to: (kernel: StreamKernel) => Triple | Promise<Triple>;
}

export interface Hovered extends Place {
  patch: number;
}

export class StreamSession {
  readonly studio: Studio;
  readonly scene = signal<StreamScene | null>(null);
  /** Where the camera shall be once there is something to see. */
  pendingCamera: Camera | null = null;
  /** Where to look from at a model that was just opened. */
  firstLook: Triple | null = null;

  /** The patch that is worked on, and its selected tangent. */
  readonly patch = signal(0);
  readonly place = signal<Place>({ row: 0, column: 0 });
  /** Steps of refinement after which the tangents are that are turned; 0 for those of the model. */
  readonly level = signal(0);
  readonly hovered = signal<Hovered | null>(null);
  /** Axis of rotations that are not about a coordinate axis. */
  readonly axis = signal<Triple>([0, 1, 0]);

  readonly infos = signal<readonly PatchInfo[]>([]);
  readonly geometries = signal<readonly PatchGeometry[]>([]);
  /** Great arcs of the patch that is worked on. */
  readonly arcs = signal<Float32Array | null>(null);
  readonly combs = signal<Float32Array | null>(null);
  /** One per patch, while the surface is coloured. */
  readonly values = signal<readonly Values[] | null>(null);
  /** The range of the colours, the same for all patches. */
  readonly range = computed<readonly [number, number]>(() => {
    const values = this.values.value ?? [];
    return [Math.min(...values.map((v) => v.low)), Math.max(...values.map((v) => v.high))];
  });
  readonly busy = signal(false);
  readonly trouble = signal<Problem | null>(null);

  readonly model = computed<unknown>(() => this.studio.document.model);
  readonly patches = computed<readonly Patch[]>(() => patchesOf(this.model.value));
  readonly current = computed<Patch | null>(() => this.patches.value[this.patch.value] ?? null);
  readonly geometry = computed<PatchGeometry | null>(() => this.geometries.value[this.patch.value] ?? null);
  /** The tangents of the level that is worked on; null until they are known. */
  readonly control = computed<ControlGrid | null>(() => {
    const [geometry, info, level] = [this.geometry.value, this.infos.value[this.patch.value], this.level.value];
    if (!geometry || !info) return null;
    if (level === 0) {
      const { rowCount, columnCount } = info;
      return { rowCount, columnCount, feet: geometry.feet, tangents: geometry.tangents };
    }
    const fine = this.#fine.value;
    return fine?.patch === this.patch.value && fine.level === level ? fine.grid : null;
  });
  /** Where the selected tangent is decided; null if it follows from others. */
  readonly owner = computed(() =>
    this.level.value > 0
      ? { patch: this.patch.value, place: this.place.value }
      : ownerOf(this.model.value, this.patch.value, this.place.value),
  );
  readonly tangent = computed<Triple | null>(() => {
    const owner = this.owner.value;
    if (this.level.value === 0 && owner) return tangentOf(this.model.value, owner.patch, owner.place);
    const [control, { row, column }] = [this.control.value, this.place.value];
    if (!control || row >= control.rowCount || column >= control.columnCount) return null;
    return tripleAt(control.tangents, row * control.columnCount + column);
  });
  /** Whether the selected tangent was set at its level. */
  readonly isDetail = computed<boolean>(() => {
    const patch = this.current.value;
    return patch !== null && this.level.value > 0 && detailAt(patch, this.level.value, this.place.value) !== null;
  });
  readonly colouring = computed<Colouring | null>(() => {
    const { colouring } = settings.value;
    return colouring === "gaussian" || colouring === "mean" || colouring === "max-abs" ? colouring : null;
  });
  /** Increases whenever the surface was drawn anew, rather than moved by a tangent. */
  readonly drawn = signal(0);
  /** Radius of what is shown, the measure of arrows and combs; 0 until it is known. */
  readonly size = signal(0);

  /** One of its own, so that no fit of a mesh is waited for; made when it is first needed. */
  #kernel: Kernel | null = null;
  readonly #levels: Levels;
  readonly #fine = signal<{ patch: number; level: number; grid: ControlGrid } | null>(null);
  #fineOf: unknown[] = [];
  /** What refinement gives where a tangent of a finer level is being turned. */
  #predicted: { key: string; tangent: Triple } | null = null;
  #held: unknown = null;
  #isOpen = false;
  /** A model that the kernel refused; not tried again. */
  #failed: unknown = null;
  #move: Move | null = null;
  /** The tangent that a slide began with, so that its steps do not add up. */
  #base: Triple | null = null;
  /** The document when a drag began. */
  #dragged: Document | null = null;
  #running: Promise<void> | null = null;
  #opening: Promise<void> | null = null;
  /** What the things beside the surface were made from. */
  #arcsOf: unknown = null;
  #combsOf: unknown[] = [];
  #valuesOf: unknown[] = [];

  constructor(studio: Studio) {
    this.studio = studio;
    this.#levels = new Levels(() => studio.newKernel());
    effect(() => {
      void this.model.value;
      void this.patch.value;
      void this.level.value;
      void this.colouring.value;
      void this.size.value;
      const { combs, combSize, arcs, sphere } = settings.value.stream;
      void [combs, combSize, arcs, sphere];
      this.#start();
    });
    effect(() => {
      const infos = this.infos.value;
      if (infos.length === 0) return;
      const patch = Math.min(this.patch.value, infos.length - 1);
      const level = Math.min(this.level.value, infos[patch]!.depth);
      const place = clampPlace(this.place.value, this.control.value ?? { rowCount: Infinity, columnCount: Infinity });
      batch(() => {
        this.patch.value = patch;
        this.level.value = level;
        const old = this.place.peek();
        if (old.row !== place.row || old.column !== place.column) this.place.value = place;
      });
    });
  }

  /** Starts the kernel ahead of its first work. Whatever is wrong with it, that work tells. */
  warm(): void {
    this.kernel.version().catch(() => {});
  }

  get kernel(): Kernel {
    this.#kernel ??= this.studio.newKernel();
    return this.#kernel;
  }

  /** Resolves when the kernel has nothing left to do. */
  async idle(): Promise<void> {
    for (let work = this.#work(); work; work = this.#work()) await work.catch(() => {});
  }

  #work(): Promise<void> | null {
    return this.#running ?? this.#opening;
  }

  // -------------------------------------------------------------- files

  async open(source: Source): Promise<void> {
    while (this.#opening) await this.#opening.catch(() => {});
    // Nothing else goes to the kernel meanwhile, or it would be of the model before.
    this.#opening = this.#open(source).finally(() => {
      this.#opening = null;
      this.#start();
    });
    return this.#opening;
  }

  async #open({ bytes, name, look, up }: Source): Promise<void> {
    await this.#running;
    const { model, patches } = await timed("open", this.kernel.openModel(bytes.slice(), name));
    this.firstLook = look ?? null;
    if (up) change({ up });
    batch(() => {
      this.#take(model, patches);
      this.patch.value = 0;
      // In the middle, where it is seen best.
      const half = (count: number) => Math.floor(count / 2);
      this.place.value = { row: half(patches[0]?.rowCount ?? 0), column: half(patches[0]?.columnCount ?? 0) };
      const document = this.studio.history.present.peek();
      this.studio.history.commit({ ...document, model }, `Open ${name}`);
    });
    const tangents = patches.map((p) => `${p.rowCount} × ${p.columnCount}`).join(", ");
    announce(`${name}: ${tangents} tangents`);
  }

  #name(): string {
    return stem(nameOf(this.model.peek()).replaceAll(/[^\p{L}\p{N} ._-]/gu, "")).trim() || "model";
  }

  async saveModel(): Promise<void> {
    await this.#give("The model cannot be saved", `${this.#name()}.streamline.json`, () => this.kernel.saveModel());
  }

  async save(format: MeshFormat): Promise<void> {
    await this.#give("The surface cannot be saved", `${this.#name()}.${format}`, () => this.kernel.save(format));
  }

  async savePicture(): Promise<void> {
    const scene = this.scene.peek();
    if (scene) await this.#give("The picture cannot be saved", `${this.#name()}.png`, () => scene.picture());
  }

  async #give(title: string, name: string, make: () => Promise<Uint8Array | Blob>): Promise<void> {
    await this.studio.give(title, name, async () => {
      await this.idle();
      return make();
    });
  }

  /** Opens the joined surface as a mesh in the other workspace. */
  async toMesh(): Promise<void> {
    try {
      await this.idle();
      const bytes = await this.kernel.save("ply");
      await this.studio.open({ name: `${this.#name()}.ply`, bytes });
    } catch (error) {
      this.studio.explain("The surface cannot go there", error);
    }
  }

  // -------------------------------------------------------------- changes

  /** Takes another model, as one thing to undo. */
  commit(model: unknown, label: string, key: string | null = null): void {
    const document = this.studio.history.present.peek();
    this.studio.history.commit({ ...document, model }, label, key);
  }

  /** Changes fields of the patch that is worked on. */
  change(part: Partial<Record<keyof Patch, unknown>>, label: string, key: string | null = null): void {
    this.commit(withPatch(this.model.peek(), this.patch.peek(), part), label, key);
  }

  /**
   * A point of the surface for each row of tangents, where the streamlines start: on the initial curve if that is
   * at their beginnings or ends, near it otherwise.
   */
  startPlaces(): Triple[] {
    const [patch, geometry] = [this.current.peek(), this.geometry.peek()];
    if (!patch || !geometry) return [];
    const { rowCount, columnCount, positions } = geometry;
    const share = patch.s0 === "max" ? 1 : typeof patch.s0 === "object" ? patch.s0.fraction : 0;
    const column = Math.round(Math.min(1, Math.max(0, share)) * (columnCount - 1));
    return patch.tangents.map((_, k) => {
      const at = 3 * (fineLine(k, patch.tangents.length, rowCount) * columnCount + column);
      return [positions[at]!, positions[at + 1]!, positions[at + 2]!];
    });
  }

  /** Moves a point of the initial curve. */
  moveInitial(index: number, place: Triple): void {
    const patch = this.current.peek();
    if (!patch) return;
    this.change({ initial: withHandle(patch.initial, index, place) }, "Move the initial curve", `initial ${index}`);
  }

  /** Changes fields that all patches share. */
  changeAll(part: Partial<Patch>, label: string, key: string | null = null): void {
    this.commit(withAllPatches(this.model.peek(), part), label, key);
  }

  /** Ends a slide or a drag, so that the next is something else to undo. */
  seal(): void {
    this.#base = null;
    void this.idle().then(() => {
      this.#predicted = null;
      this.studio.history.seal();
    });
  }

  select(place: Place, patch = this.patch.peek()): void {
    const info = this.infos.peek()[patch];
    if (!info) return;
    this.#base = null;
    const grid = patch === this.patch.peek() ? this.control.peek() : null;
    const next = clampPlace(place, grid ?? (this.level.peek() === 0 ? info : place0(place)));
    batch(() => {
      this.patch.value = patch;
      this.place.value = next;
    });
    announce(`Tangent ${next.column + 1} of streamline ${next.row + 1}`);
  }

  step(rows: number, columns: number): void {
    const { row, column } = this.place.peek();
    this.select({ row: row + rows, column: column + columns });
  }

  /** Sets a tangent; while the kernel works, only the last wish counts. */
  setTangent(to: Triple, place = this.place.peek(), patch = this.patch.peek()): void {
    this.#want({ patch, level: this.level.peek(), place, to: () => to });
  }

  /** Begins a drag, which may be cancelled. */
  beginDrag(): void {
    this.#dragged = this.studio.history.present.peek();
  }

  /** Takes back what has been dragged since. */
  cancelDrag(): void {
    this.#move = null;
    const before = this.#dragged;
    void this.idle().then(() => {
      this.#base = null;
      this.#predicted = null;
      if (before !== this.studio.history.present.peek()) this.studio.undo();
    });
  }

  /** Works on tangents of another level, at the place of the same share of the grid. */
  setLevel(level: number): void {
    const info = this.infos.peek()[this.patch.peek()];
    if (!info || level === this.level.peek()) return;
    const next = Math.min(Math.max(0, level), info.depth);
    const old = this.control.peek();
    const { row, column } = this.place.peek();
    this.#base = null;
    void this.idle().then(async () => {
      const [held, patch] = [this.#held, this.patch.peek()];
      const fine = next === 0 ? null : await this.#levels.grid(held, patch, next);
      const grid = fine ?? info;
      batch(() => {
        if (fine) {
          this.#fine.value = { patch, level: next, grid: fine };
          this.#fineOf = [held, patch, next];
        }
        this.level.value = next;
        if (old) {
          this.place.value = {
            row: fineLine(row, old.rowCount, grid.rowCount),
            column: fineLine(column, old.columnCount, grid.columnCount),
          };
        }
      });
      announce(next === 0 ? "Tangents of the model" : `Tangents after ${next} ${next === 1 ? "step" : "steps"}`);
    });
  }

  /** Takes back what was set at finer levels: at the selected place, or everywhere. */
  removeDetails(all: boolean): void {
    const [patch, level, { row, column }] = [this.patch.peek(), this.level.peek(), this.place.peek()];
    const model = withoutDetails(
      this.model.peek(),
      patch,
      (d) => all || (d.level === level && d.row === row && d.column === column),
    );
    this.commit(model, all ? "Take back all finer changes" : "Take back a finer change");
  }

  /** Sets a component of the selected tangent; the others keep the proportion that they had before the slide. */
  setComponent(axis: 0 | 1 | 2, value: number): void {
    this.#fromBase((kernel, base) => kernel.setComponent(base, axis, value));
  }

  /** Turns the selected tangent by so much from where it was before the slide. */
  rotate(axis: Triple, degrees: number): void {
    this.#fromBase((kernel, base) => kernel.rotate(base, axis, degrees));
  }

  /** Turns the selected tangent as one thing to undo. */
  turn(axis: Triple, degrees: number): void {
    this.#base = null;
    this.rotate(axis, degrees);
    this.#base = null;
  }

  #fromBase(to: (kernel: StreamKernel, base: Triple) => Promise<Triple>): void {
    const base = this.#base ?? this.tangent.peek();
    if (!base) return;
    this.#base = base;
    this.#want({
      patch: this.patch.peek(),
      level: this.level.peek(),
      place: this.place.peek(),
      to: (kernel) => to(kernel, base),
    });
  }

  /** Inserts a row or column before the selected place, or deletes the one there. */
  async changeGrid(kind: Exclude<ModelChange["kind"], "mirror">, label: string): Promise<void> {
    const { row, column } = this.place.peek();
    const at = kind.endsWith("row") ? row : column;
    // Inserted between two; there is nothing before the first.
    const index = kind.startsWith("insert") ? Math.max(1, at) : at;
    const patch = this.patch.peek();
    // Stitched patches have as many tangents on every streamline.
    const isShared = kind.endsWith("column") && stitchOf(this.model.peek()) !== false;
    const patches = isShared ? [...this.patches.peek().keys()] : [patch];
    await this.#edit(patches.map((p) => ({ kind, patch: p, index })), label);
  }

  /** Changes the structure by the kernel. */
  edit(change: ModelChange, label: string): Promise<void> {
    return this.#edit([change], label);
  }

  async #edit(changes: readonly ModelChange[], label: string): Promise<void> {
    try {
      await this.idle();
      const before = this.model.peek();
      let model = before;
      for (const change of changes) model = await this.kernel.edit(model, change);
      if (this.model.peek() === before) this.commit(model, label);
      announce(label);
    } catch (error) {
      this.studio.explain(`${label}: not possible`, error);
    }
  }

  // -------------------------------------------------------------- the kernel

  #want(move: Move): void {
    const owner = move.level > 0 ? move : ownerOf(this.model.peek(), move.patch, move.place);
    if (!owner) {
      announce("This streamline goes on smoothly from the patch before: turn the tangents there");
      return;
    }
    this.#move = { ...move, patch: owner.patch, place: owner.place };
    this.#start();
  }

  /** Tries again what failed. */
  retry(): void {
    this.#failed = null;
    this.trouble.value = null;
    this.#start();
  }

  #start(): void {
    if (this.#opening) return;
    this.#running ??= this.#run();
  }

  async #run(): Promise<void> {
    // A turn later, so that all that changes at once is seen at once.
    await Promise.resolve();
    for (let step = this.#next(); step; step = this.#next()) {
      try {
        await step();
      } catch (error) {
        this.trouble.value = problemOf(error);
      }
    }
    // In the same turn in which nothing was left, or a wish might come between and be lost.
    this.#running = null;
    this.busy.value = false;
  }

  #next(): (() => Promise<void>) | null {
    const model = this.model.peek();
    const move = this.#move;
    if (move) {
      this.#move = null;
      return () => this.#setTangent(move);
    }
    if (model !== this.#held && model !== this.#failed) {
      return () => (patchesOf(model).length === 0 ? this.#forget(model) : this.#setModel(model));
    }
    if (model === this.#held && this.#failed !== null) {
      this.#failed = null;
      this.trouble.value = null;
    }
    const geometries = this.geometries.peek();
    const missing = this.infos.peek().findIndex((_, i) => geometries[i] === undefined);
    if (missing >= 0) return () => this.#refresh();
    return this.#beside();
  }

  /** What is drawn beside the surface, where it is not of the surface that is there. */
  #beside(): (() => Promise<void>) | null {
    const patch = this.patch.peek();
    const geometry = this.geometry.peek();
    const { stream } = settings.peek();
    if (!geometry) return null;
    const level = this.level.peek();
    if (level > 0 && !same(this.#fineOf, [this.#held, patch, level])) {
      const held = this.#held;
      this.#fineOf = [held, patch, level];
      return async () => {
        const grid = await this.#levels.grid(held, patch, level);
        this.#fine.value = { patch, level, grid };
      };
    }
    const rows = stream.sphere !== "column";
    const arcsOf = stream.arcs ? `${patch} ${rows}` : null;
    if (stream.arcs && !same(this.#arcsOf, [geometry, arcsOf])) {
      this.#arcsOf = [geometry, arcsOf];
      return async () => void (this.arcs.value = await this.kernel.arcs(patch, rows, ARC_STEPS));
    }
    const scale = combScale(this.size.peek(), stream.combSize);
    if (stream.combs && scale > 0 && !same(this.#combsOf, [geometry, scale])) {
      this.#combsOf = [geometry, scale];
      return async () => void (this.combs.value = await this.kernel.combs(patch, scale));
    }
    if (!stream.combs && this.combs.peek()) {
      this.combs.value = null;
      this.#combsOf = [];
    }
    const colouring = this.colouring.peek();
    const geometries = this.geometries.peek();
    if (colouring && !same(this.#valuesOf, [colouring, ...geometries])) {
      this.#valuesOf = [colouring, ...geometries];
      return async () => {
        const values = [];
        for (const i of geometries.keys()) values.push(await this.kernel.values(i, colouring));
        this.values.value = values;
      };
    }
    if (!colouring && this.values.peek()) {
      this.values.value = null;
      this.#valuesOf = [];
    }
    return null;
  }

  #take(model: unknown, infos: readonly PatchInfo[]): void {
    this.#held = model;
    this.#isOpen = true;
    this.#failed = null;
    batch(() => {
      this.trouble.value = null;
      this.infos.value = infos;
      this.geometries.value = [];
    });
  }

  async #forget(model: unknown): Promise<void> {
    this.#held = model;
    batch(() => {
      this.trouble.value = null;
      this.infos.value = [];
      this.geometries.value = [];
      this.arcs.value = null;
      this.combs.value = null;
      this.values.value = null;
    });
  }

  async #setModel(model: unknown): Promise<void> {
    this.busy.value = true;
    try {
      const infos = await timed("surface", this.#send(model));
      this.#held = model;
      this.#failed = null;
      const drawn = await this.#draw(infos.length);
      batch(() => {
        this.trouble.value = null;
        this.infos.value = infos;
        this.geometries.value = drawn;
        this.drawn.value += 1;
      });
    } catch (error) {
      this.#failed = model;
      throw error;
    }
  }

  async #send(model: unknown): Promise<readonly PatchInfo[]> {
    if (this.#isOpen) return this.kernel.setModel(model);
    const bytes = new TextEncoder().encode(JSON.stringify(model));
    const { patches } = await this.kernel.openModel(bytes, nameOf(model));
    this.#isOpen = true;
    return patches;
  }

  async #draw(count: number): Promise<PatchGeometry[]> {
    const drawn: PatchGeometry[] = [];
    for (let i = 0; i < count; i += 1) drawn.push(await this.kernel.patch(i));
    return drawn;
  }

  async #refresh(): Promise<void> {
    const drawn = await this.#draw(this.infos.peek().length);
    batch(() => {
      this.geometries.value = drawn;
      this.drawn.value += 1;
    });
  }

  async #setTangent({ patch, level, place, to }: Move): Promise<void> {
    const tangent = await to(this.kernel);
    if (level > 0) return this.#setDetail(patch, level, place, tangent);
    const before = this.model.peek();
    const model = withTangent(before, patch, place, tangent);
    const key = `tangent ${patch} ${place.row} ${place.column}`;
    // What the kernel has is not what is in the document: the model as a whole has to go there.
    if (before !== this.#held) {
      this.commit(model, "Turn a tangent", key);
      return;
    }
    const geometry = await timed("drag", this.kernel.setTangent(patch, place.row, place.column, tangent));
    record("kernel", geometry.milliseconds);
    const geometries = this.geometries.peek().map((old, i) => (i === patch ? geometry : old));
    // Patches that are stitched to it move with it.
    for (const i of geometry.others ?? []) geometries[i] = await this.kernel.patch(i);
    // Something else may have changed the document meanwhile; then the loop sends that.
    const isStill = this.model.peek() === before;
    this.#held = isStill ? model : null;
    batch(() => {
      this.geometries.value = geometries;
      if (isStill) this.commit(model, "Turn a tangent", key);
    });
  }

  /** A tangent of a finer level is a detail of the model, which the loop then sends as a whole. */
  async #setDetail(patch: number, level: number, place: Place, tangent: Triple): Promise<void> {
    const key = `detail ${patch} ${level} ${place.row} ${place.column}`;
    if (this.#predicted?.key !== key) {
      this.#predicted = { key, tangent: await this.#levels.predicted(this.model.peek(), patch, level, place) };
    }
    const detail = { level, ...place, predicted: this.#predicted.tangent, tangent };
    this.commit(withDetail(this.model.peek(), patch, detail), "Turn a finer tangent", key);
  }
}

function place0({ row, column }: Place): { rowCount: number; columnCount: number } {
  return { rowCount: row + 1, columnCount: column + 1 };
}

function same(a: unknown, b: readonly unknown[]): boolean {
  return Array.isArray(a) && a.length === b.length && a.every((x, i) => x === b[i]);
}

/** Length of a comb tooth per curvature, such that one of a circle as large as the model is a small part of it. */
export function combScale(size: number, relative: number): number {
  return 0.04 * size * size * relative;
}
