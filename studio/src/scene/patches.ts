// Where a surface comes from: which of its triangles belong to a face of the given mesh, and which of its edges
// are the images of the given edges.

import type { Geometry } from "../kernel/api";

/** In place of a face, where there is none. */
export const OUTSIDE = 0xffff_ffff;

export interface PatchLines {
  /** 2 vertices per edge. */
  pairs: Uint32Array;
  /** The faces of the given mesh on both sides, 2 per edge, the smaller first; `OUTSIDE` on the boundary. */
  faces: Uint32Array;
}

/** Edges that separate the images of two faces, or lie on the boundary: the given mesh, drawn on its surface. */
export function patchLines({ triangles, faceOfTriangle, positions }: Geometry): PatchLines {
  const vertexCount = positions.length / 3;
  const isRim = rim(triangles, vertexCount);
  // A vertex inside the image of one face is on no such edge, which leaves few edges to look at.
  const MIXED = 0xffff_ffff;
  const UNSEEN = 0xffff_fffe;
  const faceOf = new Uint32Array(vertexCount).fill(UNSEEN);
  triangles.forEach((v, i) => {
    const face = faceOfTriangle[(i / 3) | 0]!;
    if (isRim[v]) faceOf[v] = MIXED;
    else if (faceOf[v] === UNSEEN) faceOf[v] = face;
    else if (faceOf[v] !== face) faceOf[v] = MIXED;
  });
  const seen = new Map<number, number>();
  const pairs: number[] = [];
  const faces: number[] = [];
  for (let i = 0; i < triangles.length; i += 1) {
    const a = triangles[i]!;
    const b = triangles[i % 3 === 2 ? i - 2 : i + 1]!;
    if (faceOf[a] !== MIXED || faceOf[b] !== MIXED) continue;
    const face = faceOfTriangle[(i / 3) | 0]!;
    const key = a < b ? a * vertexCount + b : b * vertexCount + a;
    const other = seen.get(key);
    if (other === undefined) {
      seen.set(key, face);
      continue;
    }
    seen.delete(key);
    if (other === face) continue;
    pairs.push(a, b);
    faces.push(Math.min(face, other), Math.max(face, other));
  }
  for (const [key, face] of seen) {
    pairs.push(Math.floor(key / vertexCount), key % vertexCount);
    faces.push(face, OUTSIDE);
  }
  return { pairs: Uint32Array.from(pairs), faces: Uint32Array.from(faces) };
}

/** Vertices on the boundary. */
function rim(triangles: Uint32Array, vertexCount: number): Uint8Array {
  // Around an inner vertex the edges that leave go where others come from, and cancel. On the boundary one
  // neighbour is only left for and another only come from, and they are two.
  const sums = new Float64Array(vertexCount);
  for (let i = 0; i < triangles.length; i += 1) {
    const a = triangles[i]!;
    const b = triangles[i % 3 === 2 ? i - 2 : i + 1]!;
    sums[a]! += b + 1;
    sums[b]! -= a + 1;
  }
  return Uint8Array.from(sums, (x) => (x === 0 ? 0 : 1));
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

/** For each given edge the faces on its sides, as in `PatchLines.faces`. `ends` are two vertices per edge. */
export function facesOfEdges({ triangles, faceOfTriangle }: Geometry, ends: Uint32Array): Uint32Array {
  const faces = new Uint32Array(ends.length).fill(OUTSIDE);
  const edgeOf = new Map<string, number>();
  const key = (a: number, b: number) => (a < b ? `${a} ${b}` : `${b} ${a}`);
  for (let e = 0; 2 * e < ends.length; e += 1) edgeOf.set(key(ends[2 * e]!, ends[2 * e + 1]!), e);
  for (let i = 0; i < triangles.length; i += 1) {
    const e = edgeOf.get(key(triangles[i]!, triangles[i % 3 === 2 ? i - 2 : i + 1]!));
    if (e === undefined) continue;
    const face = faceOfTriangle[(i / 3) | 0]!;
    const first = faces[2 * e]!;
    if (first === OUTSIDE) faces[2 * e] = face;
    else if (first !== face) {
      faces[2 * e] = Math.min(first, face);
      faces[2 * e + 1] = Math.max(first, face);
    }
  }
  return faces;
}
