// A mesh, its control mesh and its surface as objects of a viewport.

import * as THREE from "three";
import { LineMaterial } from "three/addons/lines/LineMaterial.js";
import { LineSegments2 } from "three/addons/lines/LineSegments2.js";
import { LineSegmentsGeometry } from "three/addons/lines/LineSegmentsGeometry.js";
import type { Colouring, Design, DragAnswer, Geometry, GivenMesh, Values } from "../kernel/api";
import { maskOf, NONE, same, type Indices } from "../state/indices";
import type { Settings } from "../state/settings";
import { FINISH, lineMaterial, overlayMaterial, pointMaterial, RAMP_TEXTURES, surfaceMaterial } from "./materials";
import { facesOfEdges, patchLines, trianglesOfFaces, type PatchLines } from "./patches";
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
  #lines: PatchLines | null = null;
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

  get lines(): PatchLines {
    this.#lines ??= patchLines(this.#source);
    return this.#lines;
  }

  hasConnectivityOf({ positions, triangles, faceOfTriangle }: Geometry): boolean {
    return (
      positions.length === this.positions.length &&
      same(triangles, this.triangles) &&
      same(faceOfTriangle, this.faceOfTriangle)
    );
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
    geometry.userData["shares"] = true;
    for (const name of ["position", "normal"]) geometry.setAttribute(name, this.geometry.getAttribute(name));
    geometry.setIndex(new THREE.BufferAttribute(index, 1));
    return geometry;
  }
}

/** Frees a geometry. Points that belong to a skin stay with it: freeing them would break all others that share. */
function release(geometry: THREE.BufferGeometry): void {
  if (geometry.userData["shares"]) {
    for (const name of Object.keys(geometry.attributes)) geometry.deleteAttribute(name);
  }
  geometry.dispose();
}

function appendEdge(places: number[], positions: Float32Array, pairs: Uint32Array, edge: number): void {
  for (let k = 2 * edge; k < 2 * edge + 2; k += 1) {
    const v = 3 * pairs[k]!;
    places.push(positions[v]!, positions[v + 1]!, positions[v + 2]!);
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
  | "selectedEdges"
  | "outline"
  | "hoverPoint"
  | "hoverEdge";

export class MeshView {
  readonly #viewport: Viewport;
  readonly #root = new THREE.Group();

  #given: GivenMesh | null = null;
  #givenSkin: Skin | null = null;
  #surface: Skin | null = null;
  #control: Skin | null = null;
  #shown: Settings["shown"] | null = null;
  #isWire = false;
  #selected: Indices = NONE;
  #hovered: number | null = null;
  #faceCount = 0;
  #facesOfEdges: Uint32Array | null = null;
  /** Edges that are drawn thick: selected ones, and creases. */
  #thickEdges: Record<"selectedEdges" | "creases", Indices> = { selectedEdges: NONE, creases: NONE };

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
    hoverPoint: pointMaterial(12, 7e-4),
    hoverEdge: new LineMaterial({ linewidth: 4, polygonOffset: true, polygonOffsetFactor: -3, polygonOffsetUnits: -6 }),
    creases: new LineMaterial({ linewidth: 3.5, polygonOffset: true, polygonOffsetFactor: -2, polygonOffsetUnits: -4 }),
    selectedEdges: new LineMaterial({ linewidth: 4, polygonOffset: true, polygonOffsetFactor: -3, polygonOffsetUnits: -6 }),
    outline: new LineMaterial({ linewidth: 2.5, polygonOffset: true, polygonOffsetFactor: -3, polygonOffsetUnits: -6 }),
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
      outline: new LineSegments2(new LineSegmentsGeometry(), m.outline),
      points: new THREE.Points(none(), m.points),
      boundary: new THREE.Points(none(), m.boundary),
      hoverPoint: new THREE.Points(none(), m.hoverPoint),
      hoverEdge: new LineSegments2(new LineSegmentsGeometry(), m.hoverEdge),
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
    for (const object of Object.values(this.#objects)) release(object.geometry);
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
    for (const points of [m.points, m.boundary, m.selectedPoints, m.hoverPoint]) paint(points, "ring", palette.ring);
    m.creases.color.set(palette.crease);
    m.selectedEdges.color.set(palette.selected);
    m.outline.color.set(palette.selected);
    paint(m.hoverPoint, "colour", palette.hover);
    m.hoverEdge.color.set(palette.hover);
    this.#viewport.invalidate();
  }

  setGiven(given: GivenMesh | null, moves: Design["moves"]): void {
    if (given !== this.#given) {
      this.#given = given;
      this.#faceCount = (given?.faceOfTriangle.reduce((last, f) => Math.max(last, f), -1) ?? -1) + 1;
      this.#facesOfEdges = null;
      this.#givenSkin = given && new Skin(given, given.positions.slice());
      if (given && this.#givenSkin) {
        const skin = this.#givenSkin;
        this.#replace("given", skin.geometry);
        const lines = skin.sharing(given.ends.length > 0 ? given.ends : given.edges);
        this.#replace("edges", lines);
        this.#objects.hiddenEdges.geometry = lines;
        this.#replace("points", skin.sharing(new Uint32Array(0)).setIndex(null));
        this.#replace("boundary", skin.sharing(given.boundary));
        this.#replace("selectedPoints", skin.sharing(NONE));
        this.#replace("hoverPoint", skin.sharing(NONE));
        skin.geometry.computeBoundingBox();
        this.#viewport.setBounds(skin.geometry.boundingBox!, given.positions);
      }
    }
    if (given && this.#givenSkin) {
      const positions = given.positions.slice();
      // While another file opens, the moves are still those of the one before.
      for (const [v, x, y, z] of moves) if (3 * v < positions.length) positions.set([x, y, z], 3 * v);
      this.#givenSkin.move(null, positions, null);
    }
    this.#update();
  }

  setSurface(surface: Geometry | null): void {
    if (surface && this.#surface?.hasConnectivityOf(surface)) {
      // Lines, selections and what picking needs stay as they are; only points move.
      this.#surface.move(null, surface.positions, surface.normals);
      this.#drawThick();
      this.#drawOutline();
      this.#viewport.invalidate();
      return;
    }
    this.#surface = surface && new Skin(surface);
    if (this.#surface) {
      this.#replace("surface", this.#surface.geometry);
      this.#objects.surfaceEdges.userData["of"] = null;
      this.#objects.patches.userData["of"] = null;
    }
    this.setFaces(this.#selected);
    this.setHover(this.#hovered);
    this.#update();
    this.#drawThick();
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
    this.#drawThick();
    this.#drawOutline();
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
    // Colours that mean something are not painted over.
    this.#materials.selection.uniforms["opacity"]!.value = colouring ? 0.1 : 0.62;
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
    this.#drawOutline();
  }

  setHover(face: number | null): void {
    if (face === this.#hovered && face === null) return;
    this.#hovered = face;
    this.#cover("hover", face === null ? new Uint32Array(0) : Uint32Array.of(face));
  }

  /** The vertex under the pointer. */
  setHoverVertex(vertex: number | null): void {
    const { hoverPoint } = this.#objects;
    if (vertex === null && !hoverPoint.visible) return;
    hoverPoint.visible = vertex !== null && this.#givenSkin !== null;
    const index = vertex === null ? NONE : Uint32Array.of(vertex);
    hoverPoint.geometry.setIndex(new THREE.BufferAttribute(index, 1));
    this.#viewport.invalidate();
  }

  /** The edge under the pointer. */
  setHoverEdge(edge: number | null): void {
    const object = this.#objects.hoverEdge as LineSegments2;
    if (edge === null && !object.visible) return;
    object.visible = edge !== null && this.#given !== null;
    if (edge !== null && this.#given) {
      release(object.geometry);
      object.geometry = new LineSegmentsGeometry().setPositions(this.#placesOf(Uint32Array.of(edge), this.#given));
    }
    this.#viewport.invalidate();
  }

  setVertices(vertices: Indices): void {
    const { selectedPoints } = this.#objects;
    const count = (this.#givenSkin?.positions.length ?? 0) / 3;
    selectedPoints.geometry.setIndex(new THREE.BufferAttribute(vertices.filter((v) => v < count), 1));
    selectedPoints.visible = vertices.length > 0;
    this.#viewport.invalidate();
  }

  setEdges(edges: Indices, creases: Design["creases"]): void {
    const ends = this.#given?.ends ?? NONE;
    const isCrease = new Set(creases.map(([a, b]) => (a < b ? `${a} ${b}` : `${b} ${a}`)));
    const found: number[] = [];
    for (let e = 0; isCrease.size > 0 && 2 * e < ends.length; e += 1) {
      const [a, b] = [ends[2 * e]!, ends[2 * e + 1]!];
      if (isCrease.has(a < b ? `${a} ${b}` : `${b} ${a}`)) found.push(e);
    }
    this.#thickEdges = {
      selectedEdges: edges.filter((e) => 2 * e < ends.length),
      creases: Uint32Array.from(found),
    };
    this.#drawThick();
    this.#viewport.invalidate();
  }

  setSettings({ shown, shading, colouring }: Settings): void {
    const before = this.#shown;
    this.#shown = shown;
    this.#isWire = shading === "wire";
    if (before?.creases !== shown.creases || before.surface !== shown.surface) this.#drawThick();
    if (before?.surface !== shown.surface) this.setFaces(this.#selected);
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
    const isShown = hasSurface && shown.surface;
    o.surface.visible = isShown && !this.#isWire;
    // Without a surface, the mesh itself is better than nothing.
    o.given.visible = hasGiven && (shown.faces || !hasSurface);
    const alone = !isShown;
    const { given } = this.#materials;
    given.uniforms["opacity"]!.value = alone ? 1 : 0.3;
    given.transparent = !alone;
    given.depthWrite = alone;
    o.surfaceEdges.visible = hasSurface && (shown.surfaceEdges || (isShown && this.#isWire));
    this.#materials.surfaceEdges.uniforms["opacity"]!.value = o.surface.visible ? 0.16 : 0.4;
    if (o.surfaceEdges.visible) this.#line("surfaceEdges", () => this.#surface!.edges);
    o.patches.visible = isShown && shown.patches;
    if (o.patches.visible) this.#line("patches", () => this.#surface!.lines.pairs);
    o.edges.visible = hasGiven && (shown.edges || (alone && shown.patches));
    o.hiddenEdges.visible = o.edges.visible && !alone;
    o.control.visible = this.#control !== null && shown.control;
    o.hiddenControl.visible = o.control.visible;
    o.points.visible = hasGiven && shown.points;
    this.#materials.points.uniforms["size"]!.value = this.#pointSize();
    o.boundary.visible = hasGiven && shown.boundary;
    const pixels = this.#viewport.renderer.getPixelRatio();
    const { points, boundary, selectedPoints, hoverPoint } = this.#materials;
    for (const m of [points, boundary, selectedPoints, hoverPoint]) m.uniforms["pixels"]!.value = pixels;
    this.#viewport.invalidate();
  }

  /** Many points are small, or they would hide the surface. */
  #pointSize(): number {
    const count = (this.#givenSkin?.positions.length ?? 0) / 3;
    return count > 3000 ? 3 : count > 1200 ? 4 : count > 400 ? 5.5 : 7;
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

  /** Thick edges run along the surface where there is one, and straight elsewhere. */
  #drawThick(): void {
    for (const name of ["selectedEdges", "creases"] as const) {
      const edges = this.#thickEdges[name];
      const object = this.#objects[name] as LineSegments2;
      const given = this.#given;
      object.visible = edges.length > 0 && given !== null && (name !== "creases" || this.#shown?.creases !== false);
      if (!object.visible || !given) continue;
      release(object.geometry);
      object.geometry = new LineSegmentsGeometry().setPositions(this.#placesOf(edges, given));
    }
  }

  #placesOf(edges: Indices, given: GivenMesh): Float32Array {
    const hasSurface = this.#surface && this.#shown?.surface !== false;
    return hasSurface ? this.#alongSurface(edges, given, this.#surface!) : this.#straight(edges, given.ends);
  }

  /** The rim of the selected faces. */
  #drawOutline(): void {
    const { skin } = this;
    const object = this.#objects.outline as LineSegments2;
    object.visible = this.#selected.length > 0 && skin !== null;
    if (!object.visible || !skin) return;
    const isSelected = maskOf(this.#selected, this.#faceCount);
    const { pairs, faces } = skin.lines;
    const places: number[] = [];
    for (let i = 0; 2 * i < faces.length; i += 1) {
      // What is outside has no mask, and is not selected.
      if (Boolean(isSelected[faces[2 * i]!]) === Boolean(isSelected[faces[2 * i + 1]!])) continue;
      appendEdge(places, skin.positions, pairs, i);
    }
    object.visible = places.length > 0;
    if (!object.visible) return;
    release(object.geometry);
    object.geometry = new LineSegmentsGeometry().setPositions(places);
  }

  #straight(edges: Indices, ends: Uint32Array): Float32Array {
    const { positions } = this.#givenSkin!;
    const places = new Float32Array(6 * edges.length);
    edges.forEach((e, i) => {
      for (let k = 0; k < 2; k += 1) {
        const v = ends[2 * e + k]!;
        places.set(positions.subarray(3 * v, 3 * v + 3), 6 * i + 3 * k);
      }
    });
    return places;
  }

  #alongSurface(edges: Indices, given: GivenMesh, { lines, positions }: Skin): Float32Array {
    this.#facesOfEdges ??= facesOfEdges(given, given.ends);
    const faces = this.#facesOfEdges;
    const key = (a: number, b: number) => a * 0x1_0000_0000 + b;
    const wanted = new Set<number>();
    for (const e of edges) wanted.add(key(faces[2 * e]!, faces[2 * e + 1]!));
    const places: number[] = [];
    for (let i = 0; 2 * i < lines.faces.length; i += 1) {
      if (!wanted.has(key(lines.faces[2 * i]!, lines.faces[2 * i + 1]!))) continue;
      appendEdge(places, positions, lines.pairs, i);
    }
    return Float32Array.from(places);
  }

  #replace(name: ObjectName, geometry: THREE.BufferGeometry): void {
    const object = this.#objects[name];
    release(object.geometry);
    object.geometry = geometry;
  }
}
