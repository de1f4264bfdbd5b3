// What the page may ask of the kernel. The kernel runs in a worker: every call is a promise, arrays are
// fresh and move without a copy. Numbers are in the units of the file; indices count from 0.

export type Scheme = "loop" | "catmull-clark" | "doo-sabin" | "butterfly" | "kobbelt";
export type Method = "auto" | "plain" | "weighted" | "chebyshev" | "cg" | "one-pass";
export type MeshFormat = "obj" | "off" | "ply" | "stl" | "glb";

/** A message for people: what, where, and what to do. Every rejected call rejects with one. */
export interface Problem {
  /** One sentence: what is wrong, and where (line, byte, face, vertex). */
  message: string;
  /** What to do about it, if anything is known to help. */
  help: string | null;
  /** Repairs that would make the file usable, for `openMesh` only; in the order in which to run them. */
  repairs: Repair[];
  /** Whether the call was cancelled, which is no error. */
  cancelled: boolean;
}

/** One explicit repair step, as `fairform repair` has them. */
export interface Repair {
  /** Its name for `openMesh(…, repairs)`, like `orient`. */
  step: string;
  /** What it will do, in words: `turn 12 faces so that neighbours agree`. */
  says: string;
}

// ---------------------------------------------------------------- interpolation

/** What a person decides about a mesh; all of it goes into the project file. */
export interface Design {
  scheme: Scheme;
  method: Method;
  /** Largest distance of the surface from a vertex, relative to the diagonal of the box. */
  tolerance: number;
  /** Most updates per stage. */
  iterations: number;
  /** Push back at level 1, so that interpolation is exact up to rounding. */
  exact: boolean;
  /** Fairness from 0 to 1, or none. */
  fair: number | null;
  corners: "smooth" | "sharp";
  border: "bspline" | "drop" | "none";
  /** The shape parameter of faces that are not in `tensions`; null is the scheme's own. */
  tension: number | null;
  /** [face, parameter] of faces with their own. */
  tensions: [number, number][];
  /** [vertex, vertex, sharpness] of edges; `Infinity` is written as -1. */
  creases: [number, number, number][];
  /** [vertex, x, y, z] of vertices that have been moved from where the file has them. */
  moves: [number, number, number, number][];
}

/** How finely the surface is drawn. */
export interface Fineness {
  /** Subdivision steps from the given mesh, 0 to 6. */
  levels: number;
  /** Points and normals of the limit surface, instead of those of the refined polygon mesh. */
  limit: boolean;
}

export interface MeshInfo {
  name: string;
  format: MeshFormat;
  vertexCount: number;
  edgeCount: number;
  faceCount: number;
  /** Corners of the largest face; 3 for triangle meshes. */
  mostCorners: number;
  leastCorners: number;
  boundaryLoopCount: number;
  componentCount: number;
  /** Groups and materials of the file, as the selection language calls them. */
  groups: { kind: "group" | "material"; name: string; faceCount: number }[];
  min: [number, number, number];
  max: [number, number, number];
  /** What there is to say about the file: unknown statements, creases found, … */
  notes: string[];
  /** Creases of the file, as in `Design.creases`. */
  creases: [number, number, number][];
  /** The scheme that suits it: `loop` for triangles, `catmull-clark` otherwise. */
  scheme: Scheme;
}

/** A mesh to draw. */
export interface Geometry {
  /** 3 per vertex. */
  positions: Float32Array;
  /** 3 per vertex, unit length. */
  normals: Float32Array;
  /** 3 vertices per triangle; polygons are cut into fans or better. */
  triangles: Uint32Array;
  /** The face of the given mesh that each triangle belongs to. */
  faceOfTriangle: Uint32Array;
  /** 2 vertices per edge of the polygons: the wire frame. */
  edges: Uint32Array;
}

export interface GivenMesh extends Geometry {
  /** Vertices on the boundary. */
  boundary: Uint32Array;
  /** Number of the vertices of each edge's two ends, 2 per edge, in the order of the kernel's edge numbers. */
  ends: Uint32Array;
}

export interface Progress {
  /** `closed`, `boundary`, `interior`, `whole`, `fairing`. */
  stage: string;
  /** Updates so far, counted through all stages; each stage begins with the number that the one before ended with. */
  iteration: number;
  /** Largest and mean distance of limit points from their vertices, relative to the diagonal. */
  max: number;
  mean: number;
}

export interface FitResult {
  /** Every update of every stage. */
  history: Progress[];
  converged: boolean;
  /** In words, if not converged or something else is to be said. */
  notes: string[];
  /** Largest and mean distance of the result, relative to the diagonal. */
  max: number;
  mean: number;
  /** 0, or 1 where the control mesh is one level finer (exact, fair, or nothing else interpolates). */
  controlLevel: number;
  controlVertexCount: number;
  controlFaceCount: number;
  /** Milliseconds in the kernel. */
  milliseconds: number;
}

/** What a surface can be coloured by. */
export type Colouring = "gaussian" | "mean" | "max-abs" | "error" | "tension" | "deviation";

export interface Values {
  /** One per vertex of the surface (or, for `tension` and `error`, of the same surface, spread from the given mesh). */
  values: Float32Array;
  /** A range that shows most of it: percentiles, symmetric about zero where the sign matters. */
  low: number;
  high: number;
  /** What it is, for the legend: `Gaussian curvature, 1/length²`. */
  label: string;
}

export interface DragAnswer {
  /** Vertices of the surface (as last drawn by `surface`) that moved; null means all. */
  vertices: Uint32Array | null;
  /** Their positions and normals, 3 each. */
  positions: Float32Array;
  normals: Float32Array;
  /** Control points that moved, numbered as in `control`, and where to. */
  controlVertices: Uint32Array;
  controlPositions: Float32Array;
  milliseconds: number;
}

export type FaceQuery =
  | { kind: "expression"; text: string } // the selection language of `--tension-where`
  | { kind: "grow" }
  | { kind: "shrink" }
  | { kind: "invert" }
  | { kind: "connected" }; // all faces of the parts that hold a selected face

export interface MeshKernel {
  /** Replaces the mesh of this worker. `repairs` are steps to run on it first. */
  openMesh(bytes: Uint8Array, name: string, repairs?: string[]): Promise<MeshInfo>;
  /** The mesh as it was opened; after a fit, a drag or a release with its vertices where they are now. */
  given(): Promise<GivenMesh>;
  /** Fits, reporting progress; the worker stays answerable to `cancel`. Keeps the result for what follows. */
  fit(design: Design, progress?: (step: Progress) => void): Promise<FitResult>;
  /** Stops what runs; it rejects with `cancelled`. */
  cancel(): Promise<void>;
  /** The control mesh after `iteration` updates (of the whole fit, counted through all stages), or the last. */
  control(iteration?: number): Promise<Geometry>;
  /** The surface of the last fit, or of the control mesh after `iteration` updates. */
  surface(fineness: Fineness, iteration?: number): Promise<Geometry>;
  values(colouring: Colouring): Promise<Values>;
  /** One byte per face of the given mesh. */
  query(selected: Uint8Array, query: FaceQuery): Promise<Uint8Array>;
  /** The parameters of faces after setting `value` on the selected, fading over `distance` (0: none) mean edge lengths. */
  spreadTension(design: Design, selected: Uint8Array, value: number, distance: number): Promise<[number, number][]>;

  /** Begins to drag vertices of the given mesh. Ends with `release`, `fit` or `surface`; `surface` must have been asked for. */
  grab(vertices: Uint32Array): Promise<void>;
  /**
   * Where the surface is with the grabbed vertices at `offset` from where they were grabbed. Of offsets that wait
   * only the newest counts; all who asked get its answer.
   */
  drag(offset: [number, number, number]): Promise<DragAnswer>;
  /**
   * Ends the drag and settles: the surface passes through every vertex again. Says where all vertices are that are
   * not where the file has them. The kernel then is as after a `fit` with these moves; the answer tells all points.
   */
  release(): Promise<{ moves: [number, number, number, number][]; max: number; answer: DragAnswer }>;

  /** The surface (or the control mesh) as a file. */
  save(what: "surface" | "control" | "given", format: MeshFormat): Promise<Uint8Array>;
}

// ---------------------------------------------------------------- streamlines

export type Triple = [number, number, number];

/** One patch of a model, in the fields of docs/streamline.schema.json. Whatever a field means there it means here. */
export type PatchJson = Record<string, unknown>;

export interface PatchInfo {
  name: string;
  rowCount: number;
  columnCount: number;
  depth: number;
  scheme: string;
  warnings: string[];
}

export interface PatchGeometry extends Geometry {
  /** Rows and columns of the grid of points: vertex (r, c) is r · columnCount + c. */
  rowCount: number;
  columnCount: number;
  /** Where the control tangents stand on the surface, 3 per control tangent (row by row). */
  feet: Float32Array;
  /** Control tangents, unit, 3 each. */
  tangents: Float32Array;
  /** Tangents refined to the finest level, unit, 3 per point of the surface. */
  fineTangents: Float32Array;
  /** Other patches that moved with it, for the model stitches them. */
  others?: Uint32Array;
  milliseconds: number;
}

export interface StreamKernel {
  /** Opens a model file (*.streamline.json). The model's JSON comes back complete, defaults filled in. */
  openModel(bytes: Uint8Array, name: string): Promise<{ model: unknown; patches: PatchInfo[] }>;
  /** Takes another state of the model, whole: undo, structure, schemes. Keeps what did not change. */
  setModel(model: unknown): Promise<PatchInfo[]>;
  patch(index: number): Promise<PatchGeometry>;
  /** Real time: one tangent of one patch. Normalises; answers with the new geometry of that patch. */
  setTangent(patch: number, row: number, column: number, tangent: Triple): Promise<PatchGeometry>;
  /** A unit tangent with component `axis` set to `value` and the others scaled in proportion. */
  setComponent(tangent: Triple, axis: 0 | 1 | 2, value: number): Promise<Triple>;
  /** `tangent` turned about `axis` by `degrees`. */
  rotate(tangent: Triple, axis: Triple, degrees: number): Promise<Triple>;
  /** Great arcs between consecutive tangents of rows or columns: `steps` points per arc with both its ends, 3 each. */
  arcs(patch: number, rows: boolean, steps: number): Promise<Float32Array>;
  /**
   * The model with a row or column of tangents inserted (blended on the sphere, between two others: from 1) or
   * deleted, without its details at finer levels; or one patch replaced by its mirror image in a plane through the
   * origin.
   */
  edit(model: unknown, change: ModelChange): Promise<unknown>;
  values(patch: number, colouring: Colouring): Promise<Values>;
  /** Curvature combs of the streamlines: 2 points (foot, tip away from the centre) per point of the surface, 3 each. */
  combs(patch: number, scale: number): Promise<Float32Array>;
  saveModel(): Promise<Uint8Array>;
  /** The joined surface as a file, also for the other workspace. */
  save(format: MeshFormat): Promise<Uint8Array>;
}

export type ModelChange =
  | { kind: "insert-row" | "insert-column" | "delete-row" | "delete-column"; patch: number; index: number }
  | { kind: "mirror"; patch: number; normal: Triple };

// ---------------------------------------------------------------- project files

/** What a `*.fairform.json` holds; crates/fairform-io reads and writes it, for the command as well. */
export interface Project {
  fairform: 1;
  workspace: "interpolation" | "streamline";
  mesh: null | {
    name: string;
    /** The bytes of the file as it was opened, base64. */
    bytes: string;
    repairs: string[];
    design: Design;
    fineness: Fineness;
    /** Selected faces and vertices of the given mesh. */
    faces: number[];
    vertices: number[];
  };
  /** A whole *.streamline.json. */
  model: null | unknown;
  camera: null | { position: Triple; target: Triple; up: Triple; zoom: number };
  /** What only the studio knows: what is shown, themes. Kept as it is by the command. */
  studio: unknown;
}

export interface ProjectKernel {
  /** Checks a project file as the command would. */
  readProject(bytes: Uint8Array): Promise<Project>;
  writeProject(project: Project): Promise<Uint8Array>;
}

export type Kernel = MeshKernel & StreamKernel & ProjectKernel & {
  version(): Promise<string>;
};
