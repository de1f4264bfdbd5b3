// Undo and redo without limit, over documents that are never changed in place.

import { signal, type ReadonlySignal } from "@preact/signals";

interface Entry<T> {
  state: T;
  /** What led away from this state, in words, for the menus. */
  label: string;
}

/** A document with its past and its future. */
export class History<T> {
  readonly #present;
  readonly #past = signal<readonly Entry<T>[]>([]);
  readonly #future = signal<readonly Entry<T>[]>([]);
  /** While set, further changes under the same key belong to the last step. */
  #open: string | null = null;

  constructor(initial: T) {
    this.#present = signal(initial);
  }

  get present(): ReadonlySignal<T> {
    return this.#present;
  }

  /**
   * Takes a new state. With a `key`, changes that follow under the same key join into one step until
   * `seal` is called: a drag of a slider is one thing to undo.
   */
  commit(next: T, label: string, key: string | null = null): void {
    if (next === this.#present.value) return;
    const joins = key !== null && key === this.#open && this.#past.value.length > 0;
    if (!joins) this.#past.value = [...this.#past.value, { state: this.#present.value, label }];
    this.#open = key;
    this.#future.value = [];
    this.#present.value = next;
  }

  /** Ends a step that was still open, so that the next change is one of its own. */
  seal(): void {
    this.#open = null;
  }

  undo(): string | null {
    const entry = this.#past.value.at(-1);
    if (!entry) return null;
    this.#past.value = this.#past.value.slice(0, -1);
    this.#future.value = [...this.#future.value, { state: this.#present.value, label: entry.label }];
    this.#open = null;
    this.#present.value = entry.state;
    return entry.label;
  }

  redo(): string | null {
    const entry = this.#future.value.at(-1);
    if (!entry) return null;
    this.#future.value = this.#future.value.slice(0, -1);
    this.#past.value = [...this.#past.value, { state: this.#present.value, label: entry.label }];
    this.#open = null;
    this.#present.value = entry.state;
    return entry.label;
  }

  /** What `undo` would take back, or null. */
  get undoLabel(): string | null {
    return this.#past.value.at(-1)?.label ?? null;
  }

  get redoLabel(): string | null {
    return this.#future.value.at(-1)?.label ?? null;
  }

  /** Starts anew, with nothing to undo. */
  reset(state: T): void {
    this.#past.value = [];
    this.#future.value = [];
    this.#open = null;
    this.#present.value = state;
  }
}
