/** The bits of numbers as one, by FNV-1a: most likely another if any of them changes. For tests. */
export function fingerprint(numbers: Float32Array): number {
  let hash = 0x811c9dc5;
  for (const word of new Uint32Array(numbers.buffer, numbers.byteOffset, numbers.length)) {
    hash = Math.imul(hash ^ word, 0x01000193);
  }
  return hash >>> 0;
}
