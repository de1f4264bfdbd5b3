// From a document to what is on screen, step by step in the worker. The newest wish wins: what is in hand
// for an older one is cancelled or thrown away.

import { batch, signal, untracked } from "@preact/signals";
import type {
  Colouring,
  Design,
  DragAnswer,
  Fineness,
  FitResult,
  Geometry,
  GivenMesh,
  MeshInfo,
  MeshKernel,
  Problem,
  Progress,
  Triple,
  Values,
} from "../kernel/api";
import { problemOf } from "../kernel/problem";
import { record, timed } from "../perf";
import type { Source } from "../state/document";

export interface Wish {
  source: Source;
  repairs: readonly string[];
  design: Design;
  fineness: Fineness;
  /** The state after so many updates, or null for the last. */
  iteration: number | null;
  control: boolean;
  colouring: Colouring | null;
}

export type Stage = "open" | "fit" | "surface" | "control" | "values";

export interface Trouble extends Problem {
  stage: Stage;
}

/** Whether a stage has the same to do for two wishes. */
function asksTheSame(stage: Stage, a: Wish, b: Wish): boolean {
  if (a.source !== b.source || a.repairs !== b.repairs) return false;
  if (stage === "open") return true;
  if (a.design !== b.design) return false;
  if (stage === "fit") return true;
  return a.fineness === b.fineness && a.iteration === b.iteration && (stage !== "values" || a.colouring === b.colouring);
}

interface Step {
  stage: Stage;
  /** Whether the wish still asks for what this step computes. */
  wanted: () => boolean;
  run: () => Promise<void>;
}

/**
 * Milliseconds that a fit nobody wants any more may still take. Most end within them, and so show something
 * while a slider moves; to cancel costs the kernel a new start.
 */
const GRACE = 300;

export class Pipeline {
  readonly info = signal<MeshInfo | null>(null);
  readonly given = signal<GivenMesh | null>(null);
  readonly fit = signal<FitResult | null>(null);
  readonly surface = signal<Geometry | null>(null);
  readonly control = signal<Geometry | null>(null);
  readonly values = signal<Values | null>(null);
  /** Updates of the fit that runs, or that ran last. */
  readonly progress = signal<readonly Progress[]>([]);
  readonly stage = signal<Stage | null>(null);
  readonly trouble = signal<Trouble | null>(null);
  /** A person stopped the fit: it rests until the design changes, and what is seen belongs to an earlier one. */
  readonly stopped = signal(false);

  readonly #kernel: MeshKernel;
  #wish: Wish | null = null;
  #running: Promise<void> | null = null;
  #step: Step | null = null;
  #stepSince = 0;
  /** The timer that will cancel the fit in hand. */
  #doomed: ReturnType<typeof setTimeout> | null = null;
  /** Others that use the kernel and must not be disturbed: opening, dragging. */
  #held = 0;

  // What the kernel and the signals hold now.
  #source: Source | null = null;
  #repairs: readonly string[] = [];
  #design: Design | null = null;
  /** Counts the fits, so that what was made from an older one is known to be stale. */
  #fitNumber = 0;
  #surfaceOf: { fit: number; fineness: Fineness; iteration: number | null } | null = null;
  #controlOf: { fit: number; iteration: number | null } | null = null;
  #surfaceNumber = 0;
  #valuesOf: { surface: number; fit: number; colouring: Colouring } | null = null;
  /** Stages that failed, with the wish they failed for; not tried again until that part of it changes. */
  #failed = new Map<Stage, Wish>();

  constructor(kernel: MeshKernel) {
    this.#kernel = kernel;
  }

  /** Says what should be on screen; null for nothing. */
  want(wish: Wish | null): void {
    // Effects wish, and must not come to depend on what answers them.
    untracked(() => this.#want(wish));
  }

  #want(wish: Wish | null): void {
    const before = this.#wish;
    this.#wish = wish;
    if (before?.design !== wish?.design || before?.source !== wish?.source) this.stopped.value = false;
    const trouble = this.trouble.value;
    const failed = trouble && this.#failed.get(trouble.stage);
    if (trouble && !(failed && wish && asksTheSame(trouble.stage, failed, wish))) this.trouble.value = null;
    const step = this.#step;
    if (step?.stage === "fit" && !step.wanted() && !this.#doomed) {
      const left = Math.max(0, this.#stepSince + GRACE - performance.now());
      this.#doomed = setTimeout(() => {
        this.#doomed = null;
        if (this.#step === step && !step.wanted()) void this.#kernel.cancel();
      }, left);
    }
    this.#start();
  }

  /** Stops the fit that runs; what was on screen stays. */
  async cancel(): Promise<void> {
    if (this.#step?.stage !== "fit") return;
    this.stopped.value = true;
    await this.#kernel.cancel();
  }

  /** Fits again after a cancel or a failure. */
  retry(): void {
    this.stopped.value = false;
    this.#failed.clear();
    this.trouble.value = null;
    this.#start();
  }

  /** Resolves when nothing is left to do. */
  async idle(): Promise<void> {
    while (this.#running) await this.#running;
  }

  /** Opens a file ahead of any wish for it, because only then is known what to wish. */
  async open(source: Source, repairs: readonly string[]): Promise<MeshInfo> {
    return this.#alone(async () => {
      this.stage.value = "open";
      try {
        return await this.#open(source, repairs);
      } finally {
        this.stage.value = null;
      }
    });
  }

  async grab(vertices: Uint32Array): Promise<void> {
    this.#held += 1;
    await this.idle();
    try {
      await this.#kernel.grab(vertices);
    } catch (error) {
      this.#letGo();
      throw error;
    }
  }

  async drag(offset: Triple): Promise<DragAnswer> {
    const answer = await timed("drag", this.#kernel.drag(offset));
    record("kernel", answer.milliseconds);
    return answer;
  }

  /**
   * Ends the drag. `design` makes the moved design out of the moves; the kernel has it fitted already, so a
   * wish for exactly this object is no reason to fit again. It answers null if it changed what the kernel has.
   */
  async release(design: (moves: Design["moves"]) => Design | null): Promise<DragAnswer> {
    try {
      const { moves, max, answer } = await this.#kernel.release();
      const next = design(moves);
      batch(() => {
        if (next) this.#design = next;
        if (this.fit.value) this.fit.value = { ...this.fit.value, max };
        this.#valuesOf = null;
        this.#controlOf = null;
      });
      return answer;
    } finally {
      this.#letGo();
    }
  }

  /** Forgets everything, for example when the comparison is closed. */
  clear(): void {
    this.want(null);
    if (this.#source === null) return;
    batch(() => {
      this.#source = null;
      this.#forget();
      this.info.value = null;
      this.given.value = null;
    });
  }

  #letGo(): void {
    this.#held -= 1;
    this.#start();
  }

  async #alone<T>(work: () => Promise<T>): Promise<T> {
    this.#held += 1;
    if (this.#step?.stage === "fit") await this.#kernel.cancel();
    await this.idle();
    try {
      return await work();
    } finally {
      this.#letGo();
    }
  }

  #start(): void {
    if (this.#running || this.#held > 0) return;
    this.#running = this.#run().finally(() => {
      this.#running = null;
    });
  }

  async #run(): Promise<void> {
    for (;;) {
      const step = this.#held > 0 ? null : this.#next();
      this.#step = step;
      this.#stepSince = performance.now();
      if (this.#doomed) clearTimeout(this.#doomed);
      this.#doomed = null;
      this.stage.value = step?.stage ?? null;
      if (!step) return;
      const wish = this.#wish!;
      try {
        await step.run();
        if (this.trouble.value?.stage === step.stage) this.trouble.value = null;
      } catch (error) {
        const problem = problemOf(error);
        if (problem.cancelled) {
          if (step.stage === "fit") this.progress.value = this.fit.value?.history ?? [];
          continue;
        }
        this.#failed.set(step.stage, wish);
        if (step.wanted()) this.trouble.value = { ...problem, stage: step.stage };
      }
    }
  }

  /** The first step that what is wished lacks. */
  #next(): Step | null {
    const wish = this.#wish;
    if (!wish) return null;
    const { source, repairs, design, fineness, iteration, colouring } = wish;

    if (this.#source !== source || this.#repairs !== repairs) {
      if (this.#hasFailed("open", wish)) return null;
      const wanted = () => this.#wish?.source === source && this.#wish.repairs === repairs;
      return { stage: "open", wanted, run: async () => void (await this.#open(source, repairs)) };
    }

    const fit = this.#fitNumber;
    const s = this.#surfaceOf;
    const isFine = s?.fineness.levels === fineness.levels && s.fineness.limit === fineness.limit;
    const lacksSurface =
      (s?.fit !== fit || !isFine || s.iteration !== iteration) &&
      !this.#hasFailed("surface", wish);

    const number = this.#surfaceNumber;
    const v = this.#valuesOf;
    const lacksValues =
      colouring !== null &&
      this.surface.value !== null &&
      (v?.surface !== number || v.colouring !== colouring) &&
      !this.#hasFailed("values", wish);

    // While a slider moves, every fit that ends is drawn and coloured before the next begins.
    const isUndrawn = s?.fit !== fit ? lacksSurface : lacksValues && v?.fit !== fit;
    if (this.#design !== design && !(this.#design !== null && isUndrawn)) {
      if (this.stopped.value) return null;
      if (this.#hasFailed("fit", wish)) return null;
      const wanted = () => this.#wish?.design === design && this.#wish.source === source;
      return { stage: "fit", wanted, run: () => this.#fit(design, wanted) };
    }

    if (lacksSurface) {
      const wanted = () => this.#wish?.fineness === fineness && this.#wish.iteration === iteration;
      return {
        stage: "surface",
        wanted,
        run: async () => {
          const surface = await timed("surface", this.#kernel.surface(fineness, iteration ?? undefined));
          this.#surfaceOf = { fit, fineness, iteration };
          this.#surfaceNumber += 1;
          this.surface.value = surface;
        },
      };
    }

    if (
      wish.control &&
      (this.#controlOf?.fit !== fit || this.#controlOf.iteration !== iteration) &&
      !this.#hasFailed("control", wish)
    ) {
      return {
        stage: "control",
        wanted: () => this.#wish?.control === true,
        run: async () => {
          this.control.value = await this.#kernel.control(iteration ?? undefined);
          this.#controlOf = { fit, iteration };
        },
      };
    }

    if (lacksValues) {
      return {
        stage: "values",
        wanted: () => this.#wish?.colouring === colouring,
        run: async () => {
          this.values.value = await this.#kernel.values(colouring);
          this.#valuesOf = { surface: number, fit, colouring };
        },
      };
    }
    if (!colouring && this.values.value) {
      this.values.value = null;
      this.#valuesOf = null;
    }
    return null;
  }

  #hasFailed(stage: Stage, wish: Wish): boolean {
    const failed = this.#failed.get(stage);
    return failed !== undefined && asksTheSame(stage, failed, wish);
  }

  async #open(source: Source, repairs: readonly string[]): Promise<MeshInfo> {
    // If it fails, the worker keeps what it had.
    const work = this.#kernel.openMesh(source.bytes.slice(), source.name, [...repairs]);
    const info = await timed("open", work);
    const given = await this.#kernel.given();
    batch(() => {
      this.#source = source;
      this.#repairs = repairs;
      this.#failed.clear();
      this.trouble.value = null;
      this.#forget();
      this.info.value = info;
      this.given.value = given;
    });
    return info;
  }

  #forget(): void {
    this.#design = null;
    this.#surfaceOf = null;
    this.#controlOf = null;
    this.#valuesOf = null;
    this.fit.value = null;
    this.surface.value = null;
    this.control.value = null;
    this.values.value = null;
    this.progress.value = [];
  }

  async #fit(design: Design, wanted: () => boolean): Promise<void> {
    this.progress.value = [];
    const steps: Progress[] = [];
    let shown = performance.now();
    const fit = await timed(
      "fit",
      this.#kernel.fit(design, (step) => {
        steps.push(step);
        // A plot that is drawn more often than the screen refreshes only takes time.
        if (wanted() && performance.now() - shown > 30) {
          shown = performance.now();
          this.progress.value = [...steps];
        }
      }),
    );
    this.#design = design;
    this.#fitNumber += 1;
    batch(() => {
      this.fit.value = fit;
      this.progress.value = fit.history;
    });
  }
}
