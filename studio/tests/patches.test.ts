import { expect, test } from "vitest";
import { facesOfEdges, OUTSIDE, patchLines, trianglesOfFaces } from "../src/scene/patches";
import { TETRAHEDRON } from "./fake";

/** Two squares side by side, each of two triangles, and a triangle more on the right one. */
const SQUARES = {
  positions: new Float32Array(3 * 7),
  normals: new Float32Array(3 * 7),
  triangles: Uint32Array.of(0, 1, 4, 0, 4, 3, 1, 2, 5, 1, 5, 4, 2, 6, 5),
  faceOfTriangle: Uint32Array.of(0, 0, 1, 1, 2),
  edges: new Uint32Array(0),
};

const edgeSet = (pairs: Uint32Array) =>
  new Set(Array.from({ length: pairs.length / 2 }, (_, i) => [pairs[2 * i]!, pairs[2 * i + 1]!].sort().join("-")));

test("patch lines are what separates faces, and the boundary, but no diagonal", () => {
  const { pairs, faces } = patchLines(SQUARES);
  expect(edgeSet(pairs)).toEqual(new Set(["1-4", "2-5", "0-1", "1-2", "2-6", "5-6", "4-5", "3-4", "0-3"]));
  const at = (a: number, b: number) => {
    for (let i = 0; 2 * i < pairs.length; i += 1) {
      if (Math.min(pairs[2 * i]!, pairs[2 * i + 1]!) === a && Math.max(pairs[2 * i]!, pairs[2 * i + 1]!) === b) {
        return [...faces.subarray(2 * i, 2 * i + 2)];
      }
    }
    return null;
  };
  expect(at(1, 4)).toEqual([0, 1]);
  expect(at(2, 5)).toEqual([1, 2]);
  expect(at(0, 3)).toEqual([0, OUTSIDE]);
});

test("on a closed mesh of triangles every edge is a patch line", () => {
  expect(edgeSet(patchLines(TETRAHEDRON).pairs)).toEqual(edgeSet(TETRAHEDRON.ends));
});

test("triangles by face, and faces by edge", () => {
  const { start, triangles } = trianglesOfFaces(SQUARES.faceOfTriangle, 3);
  expect([...triangles.subarray(start[1]!, start[2]!)]).toEqual([2, 3]);
  const faces = facesOfEdges(SQUARES, Uint32Array.of(4, 1, 0, 1));
  expect([...faces]).toEqual([0, 1, 0, OUTSIDE]);
});
