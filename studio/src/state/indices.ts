// Sets of faces and vertices as ascending numbers; never changed in place.

export type Indices = Uint32Array;

export const NONE: Indices = new Uint32Array(0);

export function indicesOf(numbers: Iterable<number>): Indices {
  const sorted = Uint32Array.from(numbers).sort();
  let count = 0;
  for (let i = 0; i < sorted.length; i += 1) {
    if (i === 0 || sorted[i] !== sorted[i - 1]) sorted[count++] = sorted[i]!;
  }
  return sorted.slice(0, count);
}

export function all(count: number): Indices {
  return Uint32Array.from({ length: count }, (_, i) => i);
}

/** One byte per element: 1 for those in the set. */
export function maskOf(indices: Indices, count: number): Uint8Array {
  const mask = new Uint8Array(count);
  for (const i of indices) if (i < count) mask[i] = 1;
  return mask;
}

export function fromMask(mask: Uint8Array): Indices {
  let count = 0;
  for (const m of mask) if (m) count += 1;
  const indices = new Uint32Array(count);
  let at = 0;
  mask.forEach((m, i) => {
    if (m) indices[at++] = i;
  });
  return indices;
}

export function has(indices: Indices, i: number): boolean {
  let low = 0;
  let high = indices.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (indices[middle]! < i) low = middle + 1;
    else high = middle;
  }
  return indices[low] === i;
}

/** How a click or a lasso changes what is selected. */
export type Combine = "replace" | "add" | "remove" | "toggle";

export function combine(old: Indices, picked: Indices, how: Combine): Indices {
  switch (how) {
    case "replace":
      return picked;
    case "add":
      return indicesOf([...old, ...picked]);
    case "remove": {
      const gone = new Set(picked);
      return old.filter((i) => !gone.has(i));
    }
    case "toggle": {
      const both = new Set(picked);
      return indicesOf([...old.filter((i) => !both.has(i)), ...picked.filter((i) => !has(old, i))]);
    }
  }
}

export function same(a: Indices, b: Indices): boolean {
  if (a === b) return true;
  if (a.length !== b.length) return false;
  for (let i = 0; i < a.length; i += 1) if (a[i] !== b[i]) return false;
  return true;
}
