// A mesh, its control mesh and its surface as objects of a viewport.

import * as THREE from "three";
import { LineMaterial } from "three/addons/lines/LineMaterial.js";
import { LineSegments2 } from "three/addons/lines/LineSegments2.js";
import { LineSegmentsGeometry } from "three/addons/lines/LineSegmentsGeometry.js";
import type { Colouring, Design, DragAnswer, Geometry, GivenMesh, Values } from "../kernel/api";
import type { Indices } from "../state/indices";
import type { Settings } from "../state/settings";
import { FINISH, lineMaterial, overlayMaterial, pointMaterial, RAMP_TEXTURES, surfaceMaterial } from "./materials";
import { patchEdges, trianglesOfFaces } from "./patches";
import { isDiverging } from "./ramps";
import type { Viewport } from "./viewport";

/** Colours of everything in the scene, from the style sheet. */
export interface Palette {
  surface: string;
  back: string;
  given: string;
  ink: string;
  point: string;
  ring: string;
  boundary: string;
  control: string;
  selected: string;
  hover: string;
  crease: string;
}

export function paletteOf(element: Element): Palette {
  const style = getComputedStyle(element);
  const of = (name: string) => style.getPropertyValue(`--scene-${name}`).trim() || "#888888";
  return {
    surface: of("surface"),
    back: of("back"),
    given: of("given"),
    ink: of("ink"),
    point: of("point"),
    ring: of("ring"),
    boundary: of("boundary"),
    control: of("control"),
    selected: of("selected"),
    hover: of("hover"),
    crease: of("crease"),
  };
}

/** A geometry of the kernel on the card, with what faces it came from. */
export class Skin {
  readonly geometry = new THREE.BufferGeometry();
  readonly faceOfTriangle: Uint32Array;
  readonly #source: Geometry;
  #byFace: { start: Uint32Array; triangles: Uint32Array } | null = null;
  /** Increases when points move. */
  version = 0;

  constructor(source: Geometry, positions: Float32Array = source.positions) {
    this.#source = source;
    this.faceOfTriangle = source.faceOfTriangle;
    const { geometry } = this;
    geometry.setAttribute("position", new THREE.BufferAttribute(positions, 3));
    geometry.setAttribute("normal", new THREE.BufferAttribute(source.normals, 3));
    geometry.setAttribute("value", new THREE.BufferAttribute(new Float32Array(positions.length / 3), 1));
    geometry.setIndex(new THREE.BufferAttribute(source.triangles, 1));
  }

  get positions(): Float32Array {
    return this.geometry.getAttribute("position").array as Float32Array;
  }

  get triangles(): Uint32Array {
    return this.#source.triangles;
  }

  get edges(): Uint32Array {
    return this.#source.edges;
  }

  patchEdges(): Uint32Array {
    return patchEdges(this.#source);
  }

  /** Moves all points, or some. */
  move(vertices: Uint32Array | null, positions: Float32Array, normals: Float32Array | null): void {
    for (const [name, from] of [
      ["position", positions],
      ["normal", normals],
    ] as const) {
      if (!from) continue;
      const attribute = this.geometry.getAttribute(name) as THREE.BufferAttribute;
      const to = attribute.array as Float32Array;
      if (!vertices) to.set(from.subarray(0, to.length));
      else vertices.forEach((v, i) => to.set(from.subarray(3 * i, 3 * i + 3), 3 * v));
      attribute.needsUpdate = true;
    }
    this.geometry.boundingSphere = this.geometry.boundingBox = null;
    this.version += 1;
  }

  setValues(values: Float32Array): void {
    const attribute = this.geometry.getAttribute("value") as THREE.BufferAttribute;
    (attribute.array as Float32Array).set(values.subarray(0, attribute.array.length));
    attribute.needsUpdate = true;
  }

  /** Corners of the triangles of some faces. */
  cornersOf(faces: Indices, faceCount: number): Uint32Array {
    this.#byFace ??= trianglesOfFaces(this.faceOfTriangle, faceCount);
    const { start, triangles } = this.#byFace;
    let count = 0;
    for (const f of faces) if (f < faceCount) count += start[f + 1]! - start[f]!;
    const corners = new Uint32Array(3 * count);
    let at = 0;
    for (const f of faces) {
      if (f >= faceCount) continue;
      for (let i = start[f]!; i < start[f + 1]!; i += 1) {
        const t = 3 * triangles[i]!;
        corners.set(this.triangles.subarray(t, t + 3), at);
        at += 3;
      }
    }
    return corners;
  }

  /** A geometry over the same points with other connectivity. */
  sharing(index: Uint32Array): THREE.BufferGeometry {
    const geometry = new THREE.BufferGeometry();
    for (const name of ["position", "normal"]) geometry.setAttribute(name, this.geometry.getAttribute(name));
    geometry.setIndex(new THREE.BufferAttribute(index, 1));
    return geometry;
  }
}

type ObjectName =
  | "surface"
  | "given"
  | "selection"
  | "hover"
  | "surfaceEdges"
  | "patches"
  | "edges"
  | "hiddenEdges"
  | "control"
  | "hiddenControl"
  | "points"
  | "boundary"
  | "selectedPoints"
  | "creases"
  | "selectedEdges";

export class MeshView {
  readonly #viewport: Viewport;
  readonly #root = new THREE.Group();

  #given: GivenMesh | null = null;
  #givenSkin: Skin | null = null;
  #surface: Skin | null = null;
  #control: Skin | null = null;
  #shown: Settings["shown"] | null = null;
  #selected: Indices = new Uint32Array(0);
  #hovered: number | null = null;
  #faceCount = 0;

  readonly #materials = {
    surface: surfaceMaterial(),
    given: surfaceMaterial(),
    selection: overlayMaterial(0.62),
    hover: overlayMaterial(0.35),
    surfaceEdges: lineMaterial(0.16, 5e-5),
    patches: lineMaterial(0.55),
    edges: lineMaterial(0.9),
    hiddenEdges: lineMaterial(0.22),
    control: lineMaterial(0.9, 2e-4),
    hiddenControl: lineMaterial(0.3),
    points: pointMaterial(7),
    boundary: pointMaterial(8, 5e-4),
    selectedPoints: pointMaterial(12, 8e-4),
    creases: new LineMaterial({ linewidth: 3.5, polygonOffset: true, polygonOffsetFactor: -2, polygonOffsetUnits: -4 }),
    selectedEdges: new LineMaterial({ linewidth: 4, depthTest: false, transparent: true, opacity: 0.9 }),
  };

  readonly #objects: Record<ObjectName, THREE.Mesh | THREE.LineSegments | THREE.Points | LineSegments2>;

  constructor(viewport: Viewport) {
    this.#viewport = viewport;
    const m = this.#materials;
    this.#materials.hiddenEdges.depthTest = false;
    this.#materials.hiddenControl.depthTest = false;
    this.#materials.given.uniforms["flatly"]!.value = true;
    const none = () => new THREE.BufferGeometry();
    this.#objects = {
      given: new THREE.Mesh(none(), m.given),
      surface: new THREE.Mesh(none(), m.surface),
      selection: new THREE.Mesh(none(), m.selection),
      hover: new THREE.Mesh(none(), m.hover),
      surfaceEdges: new THREE.LineSegments(none(), m.surfaceEdges),
      patches: new THREE.LineSegments(none(), m.patches),
      hiddenEdges: new THREE.LineSegments(none(), m.hiddenEdges),
      edges: new THREE.LineSegments(none(), m.edges),
      hiddenControl: new THREE.LineSegments(none(), m.hiddenControl),
      control: new THREE.LineSegments(none(), m.control),
      creases: new LineSegments2(new LineSegmentsGeometry(), m.creases),
      selectedEdges: new LineSegments2(new LineSegmentsGeometry(), m.selectedEdges),
      points: new THREE.Points(none(), m.points),
      boundary: new THREE.Points(none(), m.boundary),
      selectedPoints: new THREE.Points(none(), m.selectedPoints),
    };
    let order = 0;
    for (const object of Object.values(this.#objects)) {
      // Everything belongs to one thing in the middle of the view; culling would only cost.
      object.frustumCulled = false;
      object.renderOrder = order;
      object.visible = false;
      order += 1;
      this.#root.add(object);
    }
    viewport.scene.add(this.#root);
  }

  dispose(): void {
    this.#viewport.scene.remove(this.#root);
    for (const object of Object.values(this.#objects)) object.geometry.dispose();
    for (const material of Object.values(this.#materials)) material.dispose();
  }

  /** What can be picked: the surface, or the given mesh while there is none or it is hidden. */
  get skin(): Skin | null {
    return this.#surface && this.#shown?.surface !== false ? this.#surface : this.#givenSkin;
  }

  get surface(): Skin | null {
    return this.#surface;
  }

  get givenPositions(): Float32Array | null {
    return this.#givenSkin?.positions ?? null;
  }

  get faceCount(): number {
    return this.#faceCount;
  }

  setPalette(palette: Palette): void {
    const m = this.#materials;
    const paint = (material: THREE.ShaderMaterial, name: string, colour: string) =>
      (material.uniforms[name]!.value as THREE.Color).set(colour);
    paint(m.surface, "front", palette.surface);
    paint(m.surface, "back", palette.back);
    paint(m.given, "front", palette.given);
    paint(m.given, "back", palette.back);
    paint(m.selection, "colour", palette.selected);
    paint(m.hover, "colour", palette.hover);
    for (const lines of [m.surfaceEdges, m.patches, m.edges, m.hiddenEdges]) paint(lines, "colour", palette.ink);
    paint(m.control, "colour", palette.control);
    paint(m.hiddenControl, "colour", palette.control);
    paint(m.points, "colour", palette.point);
    paint(m.boundary, "colour", palette.boundary);
    paint(m.selectedPoints, "colour", palette.selected);
    for (const points of [m.points, m.boundary, m.selectedPoints]) paint(points, "ring", palette.ring);
    m.creases.color.set(palette.crease);
    m.selectedEdges.color.set(palette.selected);
    this.#viewport.invalidate();
  }

  setGiven(given: GivenMesh | null, moves: Design["moves"]): void {
    if (given !== this.#given) {
      this.#given = given;
      this.#faceCount = (given?.faceOfTriangle.reduce((last, f) => Math.max(last, f), -1) ?? -1) + 1;
      this.#givenSkin = given && new Skin(given, given.positions.slice());
      if (given && this.#givenSkin) {
        const skin = this.#givenSkin;
        this.#replace("given", skin.geometry);
        const lines = skin.sharing(given.ends.length > 0 ? given.ends : given.edges);
        this.#replace("edges", lines);
        this.#objects.hiddenEdges.geometry = lines;
        this.#replace("points", skin.sharing(new Uint32Array(0)).setIndex(null));
        this.#replace("boundary", skin.sharing(given.boundary));
        this.#replace("selectedPoints", skin.sharing(new Uint32Array(0)));
        skin.geometry.computeBoundingBox();
        this.#viewport.setBounds(skin.geometry.boundingBox!);
      }
    }
    if (given && this.#givenSkin) {
      const positions = given.positions.slice();
      for (const [v, x, y, z] of moves) positions.set([x, y, z], 3 * v);
      this.#givenSkin.move(null, positions, null);
    }
    this.#update();
  }

  setSurface(surface: Geometry | null): void {
    this.#surface = surface && new Skin(surface);
    if (this.#surface) {
      this.#replace("surface", this.#surface.geometry);
      this.#objects.surfaceEdges.geometry.dispose();
      this.#objects.surfaceEdges.userData["of"] = null;
      this.#objects.patches.userData["of"] = null;
    }
    this.setFaces(this.#selected);
    this.setHover(this.#hovered);
    this.#update();
  }

  /** Takes a step of a drag. */
  patch(answer: DragAnswer, moved: Uint32Array, at: Float32Array): void {
    this.#surface?.move(answer.vertices, answer.positions, answer.normals);
    this.#givenSkin?.move(moved, at, null);
    if (this.#control && answer.controlVertices.length > 0) {
      const last = this.#control.positions.length / 3;
      if (answer.controlVertices.every((v) => v < last)) {
        this.#control.move(answer.controlVertices, answer.controlPositions, null);
      }
    }
    this.#viewport.invalidate();
  }

  setControl(control: Geometry | null): void {
    this.#control = control && new Skin(control);
    if (this.#control) {
      const lines = this.#control.sharing(control!.edges);
      this.#replace("control", lines);
      this.#objects.hiddenControl.geometry = lines;
    }
    this.#update();
  }

  setValues(values: Values | null, colouring: Colouring | null): void {
    const { uniforms } = this.#materials.surface;
    const fits = values && this.#surface && values.values.length * 3 === this.#surface.positions.length;
    uniforms["coloured"]!.value = Boolean(fits && colouring);
    if (fits && colouring) {
      this.#surface!.setValues(values.values);
      uniforms["low"]!.value = values.low;
      uniforms["high"]!.value = values.high;
      uniforms["ramp"]!.value = RAMP_TEXTURES[isDiverging(colouring) ? "diverging" : "sequential"];
    }
    this.#viewport.invalidate();
  }

  setFaces(faces: Indices): void {
    this.#selected = faces;
    this.#cover("selection", faces);
  }

  setHover(face: number | null): void {
    if (face === this.#hovered && face === null) return;
    this.#hovered = face;
    this.#cover("hover", face === null ? new Uint32Array(0) : Uint32Array.of(face));
  }

  setVertices(vertices: Indices): void {
    const { selectedPoints } = this.#objects;
    const count = (this.#givenSkin?.positions.length ?? 0) / 3;
    selectedPoints.geometry.setIndex(new THREE.BufferAttribute(vertices.filter((v) => v < count), 1));
    selectedPoints.visible = vertices.length > 0;
    this.#viewport.invalidate();
  }

  setEdges(edges: Indices, creases: Design["creases"]): void {
    const ends = this.#given?.ends;
    const chosen: [number, number][] = [];
    if (ends) for (const e of edges) if (2 * e + 1 < ends.length) chosen.push([ends[2 * e]!, ends[2 * e + 1]!]);
    this.#thick("selectedEdges", chosen);
    this.#thick("creases", creases.map(([a, b]) => [a, b] as [number, number]));
    this.#objects.creases.visible &&= this.#shown?.creases !== false;
    this.#viewport.invalidate();
  }

  setSettings({ shown, shading, colouring }: Settings): void {
    this.#shown = shown;
    this.#materials.surface.uniforms["finish"]!.value = FINISH[shading];
    if (!colouring) this.#materials.surface.uniforms["coloured"]!.value = false;
    this.#update();
  }

  #update(): void {
    const shown = this.#shown;
    if (!shown) return;
    const o = this.#objects;
    const hasGiven = this.#givenSkin !== null;
    const hasSurface = this.#surface !== null;
    o.surface.visible = hasSurface && shown.surface;
    // Without a surface, the mesh itself is better than nothing.
    o.given.visible = hasGiven && (shown.faces || !hasSurface);
    const alone = !o.surface.visible;
    const { given } = this.#materials;
    given.uniforms["opacity"]!.value = alone ? 1 : 0.3;
    given.transparent = !alone;
    given.depthWrite = alone;
    o.surfaceEdges.visible = o.surface.visible && shown.surfaceEdges;
    if (o.surfaceEdges.visible) this.#line("surfaceEdges", () => this.#surface!.edges);
    o.patches.visible = o.surface.visible && shown.patches;
    if (o.patches.visible) this.#line("patches", () => this.#surface!.patchEdges());
    o.edges.visible = hasGiven && (shown.edges || (alone && shown.patches));
    o.hiddenEdges.visible = o.edges.visible && !alone;
    o.control.visible = this.#control !== null && shown.control;
    o.hiddenControl.visible = o.control.visible;
    o.points.visible = hasGiven && shown.points;
    this.#materials.points.uniforms["size"]!.value = this.#pointSize();
    o.boundary.visible = hasGiven && shown.boundary;
    o.creases.visible = shown.creases && o.creases.userData["count"] > 0;
    const pixels = this.#viewport.renderer.getPixelRatio();
    for (const m of [this.#materials.points, this.#materials.boundary, this.#materials.selectedPoints]) {
      m.uniforms["pixels"]!.value = pixels;
    }
    this.#viewport.invalidate();
  }

  /** Many points are small, or they would hide the surface. */
  #pointSize(): number {
    const count = (this.#givenSkin?.positions.length ?? 0) / 3;
    return count > 3000 ? 3.5 : count > 800 ? 5 : 7;
  }

  #line(name: "surfaceEdges" | "patches", index: () => Uint32Array): void {
    const object = this.#objects[name];
    if (object.userData["of"] === this.#surface) return;
    object.userData["of"] = this.#surface;
    this.#replace(name, this.#surface!.sharing(index()));
  }

  #cover(name: "selection" | "hover", faces: Indices): void {
    const { skin } = this;
    const object = this.#objects[name];
    object.visible = faces.length > 0 && skin !== null;
    if (object.visible) this.#replace(name, skin!.sharing(skin!.cornersOf(faces, this.faceCount)));
    this.#viewport.invalidate();
  }

  #thick(name: "creases" | "selectedEdges", edges: [number, number][]): void {
    const positions = this.#givenSkin?.positions;
    const object = this.#objects[name] as LineSegments2;
    object.visible = edges.length > 0 && positions !== undefined;
    object.userData["count"] = edges.length;
    if (!object.visible || !positions) return;
    const places = new Float32Array(6 * edges.length);
    edges.forEach(([a, b], i) => {
      places.set(positions.subarray(3 * a, 3 * a + 3), 6 * i);
      places.set(positions.subarray(3 * b, 3 * b + 3), 6 * i + 3);
    });
    object.geometry.dispose();
    object.geometry = new LineSegmentsGeometry().setPositions(places);
  }

  #replace(name: ObjectName, geometry: THREE.BufferGeometry): void {
    const object = this.#objects[name];
    object.geometry.dispose();
    object.geometry = geometry;
  }
}
