// Tangents of finer levels of refinement, and where they stand. A kernel of its own refines the model just so far;
// the one that draws need not know.

import type { StreamKernel, Triple } from "../kernel/api";
import { atLevel, nameOf, withoutDetails, type Place } from "./model";

/** Tangents that can be turned, row by row, and their feet; 3 numbers each. */
export interface ControlGrid {
  rowCount: number;
  columnCount: number;
  feet: Float32Array;
  tangents: Float32Array;
}

export class Levels {
  readonly #newKernel: () => StreamKernel;
  #kernel: StreamKernel | null = null;

  constructor(newKernel: () => StreamKernel) {
    this.#newKernel = newKernel;
  }

  async grid(model: unknown, patch: number, level: number): Promise<ControlGrid> {
    const coarse = atLevel(model, level);
    if (this.#kernel) {
      await this.#kernel.setModel(coarse);
    } else {
      const kernel = this.#newKernel();
      await kernel.openModel(new TextEncoder().encode(JSON.stringify(coarse)), nameOf(model));
      this.#kernel = kernel;
    }
    const { rowCount, columnCount, positions, fineTangents } = await this.#kernel.patch(patch);
    return { rowCount, columnCount, feet: positions, tangents: fineTangents };
  }

  /** What refinement alone gives at a place of a level above 0. */
  async predicted(model: unknown, patch: number, level: number, place: Place): Promise<Triple> {
    const without = withoutDetails(
      model,
      patch,
      (d) => d.level === level && d.row === place.row && d.column === place.column,
    );
    const grid = await this.grid(without, patch, level);
    return tripleAt(grid.tangents, place.row * grid.columnCount + place.column);
  }
}

export function tripleAt(numbers: Float32Array, index: number): Triple {
  return [numbers[3 * index]!, numbers[3 * index + 1]!, numbers[3 * index + 2]!];
}
