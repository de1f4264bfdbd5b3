// A kernel that computes nothing, to test what the studio does with one.

import type { Design, FitResult, Geometry, GivenMesh, MeshInfo, MeshKernel, Problem } from "../src/kernel/api";

export const CANCELLED: Problem = { message: "cancelled", help: null, repairs: [], cancelled: true };

export const TETRAHEDRON: GivenMesh = {
  positions: Float32Array.of(0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1),
  normals: Float32Array.of(0, 0, -1, 1, 0, 0, 0, 1, 0, 0, 0, 1),
  triangles: Uint32Array.of(0, 2, 1, 0, 1, 3, 1, 2, 3, 0, 3, 2),
  faceOfTriangle: Uint32Array.of(0, 1, 2, 3),
  edges: Uint32Array.of(0, 2, 2, 1, 1, 0, 1, 3, 3, 0, 2, 3),
  ends: Uint32Array.of(0, 2, 2, 1, 1, 0, 1, 3, 3, 0, 2, 3),
  boundary: new Uint32Array(0),
};

export const INFO: MeshInfo = {
  name: "tetrahedron.obj",
  format: "obj",
  vertexCount: 4,
  edgeCount: 6,
  faceCount: 4,
  mostCorners: 3,
  leastCorners: 3,
  boundaryLoopCount: 0,
  componentCount: 1,
  groups: [],
  min: [0, 0, 0],
  max: [1, 1, 1],
  notes: [],
  creases: [],
  scheme: "loop",
};

const RESULT: FitResult = {
  history: [
    { stage: "closed", iteration: 1, max: 0.1, mean: 0.05 },
    { stage: "closed", iteration: 2, max: 0.001, mean: 0.0005 },
  ],
  converged: true,
  notes: [],
  max: 0.001,
  mean: 0.0005,
  controlLevel: 0,
  controlVertexCount: 4,
  controlFaceCount: 4,
  milliseconds: 1,
};

/** Calls are listed in `calls`; fits wait until `finishFit` or `cancel`. */
export class FakeKernel implements MeshKernel {
  readonly calls: string[] = [];
  /** Fits end by themselves unless this is set. */
  slow = false;
  failFit: Problem | null = null;
  failOpen: Problem | null = null;
  fitted: Design[] = [];
  #end: { resolve: (r: FitResult) => void; reject: (e: Problem) => void } | null = null;

  async openMesh(_: Uint8Array, name: string, repairs: string[] = []): Promise<MeshInfo> {
    this.calls.push(`open ${[name, ...repairs].join(" ")}`);
    if (this.failOpen && name === "bad.obj" && repairs.length === 0) throw this.failOpen;
    return { ...INFO, name };
  }

  async given(): Promise<GivenMesh> {
    return TETRAHEDRON;
  }

  fit(design: Design): Promise<FitResult> {
    this.calls.push("fit");
    this.fitted.push(design);
    if (this.failFit) return Promise.reject(this.failFit);
    if (!this.slow) return Promise.resolve(RESULT);
    return new Promise((resolve, reject) => {
      this.#end = { resolve, reject };
    });
  }

  finishFit(): void {
    this.#end?.resolve(RESULT);
    this.#end = null;
  }

  async cancel(): Promise<void> {
    this.calls.push("cancel");
    this.#end?.reject(CANCELLED);
    this.#end = null;
  }

  async control(): Promise<Geometry> {
    this.calls.push("control");
    return TETRAHEDRON;
  }

  async surface(fineness: { levels: number }, iteration?: number): Promise<Geometry> {
    this.calls.push(`surface ${fineness.levels}${iteration === undefined ? "" : ` at ${iteration}`}`);
    return { ...TETRAHEDRON };
  }

  async values(colouring: string) {
    this.calls.push(`values ${colouring}`);
    return { values: new Float32Array(4), low: 0, high: 1, label: colouring };
  }

  async query(selected: Uint8Array) {
    return selected.map((x) => 1 - x);
  }

  async spreadTension(design: Design, selected: Uint8Array, value: number): Promise<[number, number][]> {
    this.calls.push(`spread ${value}`);
    const faces = [...selected].flatMap((x, i): [number, number][] => (x ? [[i, value]] : []));
    return [...design.tensions, ...faces];
  }

  async grab() {
    this.calls.push("grab");
  }

  async drag(offset: readonly number[]) {
    this.calls.push(`drag ${offset.join(" ")}`);
    return ANSWER;
  }

  async release() {
    this.calls.push("release");
    return { moves: [[0, 0.5, 0, 0]] as Design["moves"], max: 1e-7, answer: ANSWER };
  }

  async save() {
    return new Uint8Array(0);
  }
}

const ANSWER = {
  vertices: null,
  positions: TETRAHEDRON.positions,
  normals: TETRAHEDRON.normals,
  controlVertices: new Uint32Array(0),
  controlPositions: new Float32Array(0),
  milliseconds: 1,
};
