// Which edges of a surface separate the images of two faces of the given mesh: the mesh, drawn on its surface.

import type { Geometry } from "../kernel/api";

/** Pairs of vertices, found by comparing the face numbers on both sides of every edge. */
export function patchEdges({ triangles, faceOfTriangle, positions }: Geometry): Uint32Array {
  const vertexCount = positions.length / 3;
  // A vertex inside the image of one face is on no such edge, which leaves few edges to look at.
  const MIXED = 0xffff_ffff;
  const UNSEEN = 0xffff_fffe;
  const faceOf = new Uint32Array(vertexCount).fill(UNSEEN);
  triangles.forEach((v, i) => {
    const face = faceOfTriangle[(i / 3) | 0]!;
    if (faceOf[v] === UNSEEN) faceOf[v] = face;
    else if (faceOf[v] !== face) faceOf[v] = MIXED;
  });
  const seen = new Map<number, number>();
  const pairs: number[] = [];
  for (let i = 0; i < triangles.length; i += 1) {
    const a = triangles[i]!;
    const b = triangles[i % 3 === 2 ? i - 2 : i + 1]!;
    if (faceOf[a] !== MIXED || faceOf[b] !== MIXED) continue;
    const face = faceOfTriangle[(i / 3) | 0]!;
    const key = a < b ? a * vertexCount + b : b * vertexCount + a;
    const other = seen.get(key);
    if (other === undefined) seen.set(key, face);
    else if (other !== face) pairs.push(a, b);
  }
  return Uint32Array.from(pairs);
}

/** For each face the triangles it owns: those of face `f` are `triangles[start[f] .. start[f + 1]]`. */
export function trianglesOfFaces(
  faceOfTriangle: Uint32Array,
  faceCount: number,
): { start: Uint32Array; triangles: Uint32Array } {
  const start = new Uint32Array(faceCount + 1);
  for (const f of faceOfTriangle) start[f + 1]! += 1;
  for (let f = 0; f < faceCount; f += 1) start[f + 1]! += start[f]!;
  const next = start.slice();
  const triangles = new Uint32Array(faceOfTriangle.length);
  faceOfTriangle.forEach((f, t) => {
    triangles[next[f]!++] = t;
  });
  return { start, triangles };
}
