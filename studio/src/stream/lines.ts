// Which vertices of a grid of points are joined by lines. Vertex (row, column) is row · columnCount + column.

/** Pairs of vertices along some rows of a grid, each `columnCount` long. */
export function alongRows(rows: Iterable<number>, columnCount: number): Uint32Array {
  const pairs: number[] = [];
  for (const row of rows) {
    for (let i = 1; i < columnCount; i += 1) pairs.push(row * columnCount + i - 1, row * columnCount + i);
  }
  return Uint32Array.from(pairs);
}

/** Pairs of vertices along some columns. */
export function alongColumns(columns: Iterable<number>, rowCount: number, columnCount: number): Uint32Array {
  const pairs: number[] = [];
  for (const column of columns) {
    for (let k = 1; k < rowCount; k += 1) pairs.push((k - 1) * columnCount + column, k * columnCount + column);
  }
  return Uint32Array.from(pairs);
}

/** Combs are two points per point of the grid: teeth of some rows, and lines from tip to tip. */
export function combLines(rows: Iterable<number>, columnCount: number): Uint32Array {
  const pairs: number[] = [];
  for (const row of rows) {
    for (let i = 0; i < columnCount; i += 1) {
      const foot = 2 * (row * columnCount + i);
      pairs.push(foot, foot + 1);
      if (i > 0) pairs.push(foot - 1, foot + 1);
    }
  }
  return Uint32Array.from(pairs);
}

/** Numbers 0 … count − 1. */
export function numbers(count: number): number[] {
  return Array.from({ length: count }, (_, i) => i);
}

/** A run of points, 3 numbers each, as the pairs that a thick line is drawn from. */
export function segments(points: Float32Array, first: number, count: number, step = 1): Float32Array {
  const pairs = new Float32Array(6 * Math.max(0, count - 1));
  for (let i = 0; i + 1 < count; i += 1) {
    const a = 3 * (first + i * step);
    const b = a + 3 * step;
    pairs.set(points.subarray(a, a + 3), 6 * i);
    pairs.set(points.subarray(b, b + 3), 6 * i + 3);
  }
  return pairs;
}
