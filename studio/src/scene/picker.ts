// What is under the pointer: faces by their images on the surface, vertices and edges of the given mesh.

import * as THREE from "three";
import { MeshBVH } from "three-mesh-bvh";
import { indicesOf, type Indices } from "../state/indices";
import type { MeshView, Skin } from "./meshView";
import type { Viewport } from "./viewport";

/** Pixels from a vertex or an edge that still count as on it. */
const REACH = 11;

export class Picker {
  readonly #viewport: Viewport;
  readonly #view: MeshView;
  #tree: { skin: Skin; version: number; bvh: MeshBVH } | null = null;
  #centres: { skin: Skin; version: number; places: Float32Array } | null = null;

  constructor(viewport: Viewport, view: MeshView) {
    this.#viewport = viewport;
    this.#view = view;
  }

  /** The face of the given mesh whose image is under a place of the page. */
  faceAt(x: number, y: number): number | null {
    return this.#hit(x, y)?.face ?? null;
  }

  /** The nearest vertex within reach that is not hidden by the surface. */
  vertexAt(x: number, y: number): number | null {
    const positions = this.#view.givenPositions;
    if (!positions) return null;
    const depth = this.#hit(x, y)?.distance ?? Infinity;
    const slack = this.#viewport.radius * 0.05;
    let best: number | null = null;
    let nearest = REACH;
    const p = new THREE.Vector3();
    const project = this.#viewport.projector();
    for (let v = 0; 3 * v < positions.length; v += 1) {
      p.fromArray(positions, 3 * v);
      const at = project(p);
      const away = Math.hypot(at.x - x, at.y - y);
      if (away >= nearest || at.depth > 1) continue;
      if (p.distanceTo(this.#viewport.camera.position) > depth + slack) continue;
      nearest = away;
      best = v;
    }
    return best;
  }

  /** The nearest edge within reach that is not hidden. `ends` are two vertices per edge. */
  edgeAt(x: number, y: number, ends: Uint32Array): number | null {
    const positions = this.#view.givenPositions;
    if (!positions) return null;
    const places = this.#screen(positions);
    const depth = this.#hit(x, y)?.distance ?? Infinity;
    const slack = this.#viewport.radius * 0.12;
    let best: number | null = null;
    let nearest = REACH;
    const line = new THREE.Line3();
    const on = new THREE.Vector3();
    const middle = new THREE.Vector3();
    const at = new THREE.Vector3(x, y, 0);
    for (let e = 0; 2 * e < ends.length; e += 1) {
      const [a, b] = [ends[2 * e]!, ends[2 * e + 1]!];
      line.start.set(places[2 * a]!, places[2 * a + 1]!, 0);
      line.end.set(places[2 * b]!, places[2 * b + 1]!, 0);
      const away = line.closestPointToPoint(at, true, on).distanceTo(at);
      if (away >= nearest) continue;
      middle.fromArray(positions, 3 * a).add(on.fromArray(positions, 3 * b)).multiplyScalar(0.5);
      if (middle.distanceTo(this.#viewport.camera.position) > depth + slack) continue;
      nearest = away;
      best = e;
    }
    return best;
  }

  /** Faces whose centres on the screen pass `inside`, and which are seen unless `through`. */
  facesIn(inside: (x: number, y: number) => boolean, through: boolean): Indices {
    const { skin } = this.#view;
    if (!skin) return new Uint32Array(0);
    const centres = this.#faceCentres(skin);
    const found: number[] = [];
    const p = new THREE.Vector3();
    const project = this.#viewport.projector();
    for (let f = 0; 3 * f < centres.length; f += 1) {
      p.fromArray(centres, 3 * f);
      const at = project(p);
      if (at.depth > 1 || !inside(at.x, at.y)) continue;
      if (through || this.#hit(at.x, at.y)?.face === f) found.push(f);
    }
    return Uint32Array.from(found);
  }

  /** Vertices on the screen that pass `inside`, and which are seen unless `through`. */
  verticesIn(inside: (x: number, y: number) => boolean, through: boolean): Indices {
    const positions = this.#view.givenPositions;
    if (!positions) return new Uint32Array(0);
    const found: number[] = [];
    const p = new THREE.Vector3();
    const project = this.#viewport.projector();
    const slack = this.#viewport.radius * 0.05;
    for (let v = 0; 3 * v < positions.length; v += 1) {
      p.fromArray(positions, 3 * v);
      const at = project(p);
      if (at.depth > 1 || !inside(at.x, at.y)) continue;
      const depth = through ? Infinity : (this.#hit(at.x, at.y)?.distance ?? Infinity);
      if (p.distanceTo(this.#viewport.camera.position) <= depth + slack) found.push(v);
    }
    return indicesOf(found);
  }

  /** A place of the page where a click finds the face, for tests; null if it is hidden. */
  screenOfFace(face: number): { x: number; y: number } | null {
    const { skin } = this.#view;
    if (!skin) return null;
    const at = this.#viewport.projector()(new THREE.Vector3().fromArray(this.#faceCentres(skin), 3 * face));
    return this.faceAt(at.x, at.y) === face ? { x: at.x, y: at.y } : null;
  }

  #screen(positions: Float32Array): Float32Array {
    const places = new Float32Array((positions.length / 3) * 2);
    const p = new THREE.Vector3();
    const project = this.#viewport.projector();
    for (let v = 0; 3 * v < positions.length; v += 1) {
      const at = project(p.fromArray(positions, 3 * v));
      places[2 * v] = at.depth > 1 ? 1e9 : at.x;
      places[2 * v + 1] = at.y;
    }
    return places;
  }

  #hit(x: number, y: number): { face: number; distance: number } | null {
    const { skin } = this.#view;
    if (!skin) return null;
    if (this.#tree?.skin !== skin) {
      this.#tree = { skin, version: skin.version, bvh: new MeshBVH(skin.geometry, { indirect: true }) };
    } else if (this.#tree.version !== skin.version) {
      this.#tree.bvh.refit();
      this.#tree.version = skin.version;
    }
    const hit = this.#tree.bvh.raycastFirst(this.#viewport.ray(x, y), THREE.DoubleSide);
    if (hit?.faceIndex === null || hit?.faceIndex === undefined) return null;
    return { face: skin.faceOfTriangle[hit.faceIndex]!, distance: hit.distance };
  }

  #faceCentres(skin: Skin): Float32Array {
    if (this.#centres?.skin === skin && this.#centres.version === skin.version) return this.#centres.places;
    const count = this.#view.faceCount;
    const places = new Float32Array(3 * count);
    const parts = new Uint32Array(count);
    const { positions, triangles } = skin;
    skin.faceOfTriangle.forEach((f, t) => {
      parts[f]! += 3;
      for (let i = 3 * t; i < 3 * t + 3; i += 1) {
        const v = 3 * triangles[i]!;
        for (let k = 0; k < 3; k += 1) places[3 * f + k]! += positions[v + k]!;
      }
    });
    for (let f = 0; f < count; f += 1) for (let k = 0; k < 3; k += 1) places[3 * f + k]! /= parts[f] || 1;
    this.#centres = { skin, version: skin.version, places };
    return places;
  }
}
