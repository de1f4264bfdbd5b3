// One patch in the scene: its surface, streamlines and combs.

import * as THREE from "three";
import { LineMaterial } from "three/addons/lines/LineMaterial.js";
import { LineSegments2 } from "three/addons/lines/LineSegments2.js";
import { LineSegmentsGeometry } from "three/addons/lines/LineSegmentsGeometry.js";
import { MeshBVH } from "three-mesh-bvh";
import type { Colouring, PatchGeometry, PatchInfo, Values } from "../kernel/api";
import { FINISH, lineMaterial, RAMP_TEXTURES, surfaceMaterial } from "../scene/materials";
import { Skin, type Palette } from "../scene/meshView";
import { isDiverging } from "../scene/ramps";
import type { Settings } from "../state/settings";
import { alongRows, combLines, numbers, segments } from "./lines";
import { fineLine } from "./model";

type LineName = "streamlines" | "fine" | "wire" | "combs";

export class PatchView {
  readonly root = new THREE.Group();
  readonly #materials = {
    surface: surfaceMaterial(),
    streamlines: lineMaterial(0.8, 6e-5),
    fine: lineMaterial(0.28, 5e-5),
    wire: lineMaterial(0.3, 5e-5),
    combs: lineMaterial(0.75, 1e-4),
    chosen: new LineMaterial({
      linewidth: 3.5,
      polygonOffset: true,
      polygonOffsetFactor: -2,
      polygonOffsetUnits: -4,
    }),
  };
  readonly #surface = new THREE.Mesh(new THREE.BufferGeometry(), this.#materials.surface);
  readonly #lines: Record<LineName, THREE.LineSegments>;
  readonly #chosen = new LineSegments2(new LineSegmentsGeometry(), this.#materials.chosen);
  #skin: Skin | null = null;
  #tree: { skin: Skin; version: number; bvh: MeshBVH } | null = null;
  #geometry: PatchGeometry | null = null;
  #info: PatchInfo | null = null;
  /** What the lines were made for; the same grid keeps them. */
  #grid = "";

  constructor() {
    const m = this.#materials;
    const line = (name: LineName) => new THREE.LineSegments(new THREE.BufferGeometry(), m[name]);
    this.#lines = { wire: line("wire"), fine: line("fine"), streamlines: line("streamlines"), combs: line("combs") };
    const all = [this.#surface, ...Object.values(this.#lines), this.#chosen];
    all.forEach((object, order) => {
      object.frustumCulled = false;
      object.renderOrder = order;
      this.root.add(object);
    });
    this.#lines.combs.visible = false;
  }

  dispose(): void {
    this.root.removeFromParent();
    this.#surface.geometry.dispose();
    for (const line of Object.values(this.#lines)) line.geometry.dispose();
    this.#chosen.geometry.dispose();
    for (const material of Object.values(this.#materials)) material.dispose();
  }

  /** How far a ray goes until it meets the surface; infinitely if it does not. */
  wayTo(ray: THREE.Ray): number {
    const skin = this.#skin;
    if (!skin || !this.#surface.visible) return Infinity;
    if (this.#tree?.skin !== skin) {
      this.#tree = { skin, version: skin.version, bvh: new MeshBVH(skin.geometry, { indirect: true }) };
    } else if (this.#tree.version !== skin.version) {
      this.#tree.bvh.refit();
      this.#tree.version = skin.version;
    }
    return this.#tree.bvh.raycastFirst(ray, THREE.DoubleSide)?.distance ?? Infinity;
  }

  setPalette(palette: Palette): void {
    const m = this.#materials;
    const paint = (material: THREE.ShaderMaterial, name: string, colour: string) =>
      (material.uniforms[name]!.value as THREE.Color).set(colour);
    paint(m.surface, "front", palette.surface);
    paint(m.surface, "back", palette.back);
    for (const lines of [m.streamlines, m.fine, m.wire]) paint(lines, "colour", palette.ink);
    paint(m.combs, "colour", palette.control);
    m.chosen.color.set(palette.selected);
  }

  setGeometry(geometry: PatchGeometry, info: PatchInfo): void {
    const grid = `${info.rowCount} ${info.columnCount} ${geometry.rowCount} ${geometry.columnCount}`;
    this.#geometry = geometry;
    this.#info = info;
    if (grid === this.#grid && this.#skin) {
      this.#skin.move(null, geometry.positions, geometry.normals);
      return;
    }
    this.#grid = grid;
    this.#surface.geometry.dispose();
    this.#skin = new Skin(geometry, geometry.positions.slice());
    this.#surface.geometry = this.#skin.geometry;
    const { rowCount, columnCount } = geometry;
    const given = numbers(info.rowCount).map((row) => fineLine(row, info.rowCount, rowCount));
    this.#replace("streamlines", this.#skin.sharing(alongRows(given, columnCount)));
    this.#replace("fine", this.#skin.sharing(alongRows(numbers(rowCount), columnCount)));
    this.#replace("wire", this.#skin.sharing(geometry.edges));
    this.#lines.combs.visible = false;
  }

  /** The line that is drawn thick, as a row of points or, across the streamlines, a column; null for none. */
  setChosen(line: number | null, across = false): void {
    const geometry = this.#geometry;
    this.#chosen.visible = line !== null && geometry !== null;
    if (line === null || !geometry) return;
    const { positions, rowCount, columnCount } = geometry;
    const pairs = across
      ? segments(positions, line, rowCount, columnCount)
      : segments(positions, line * columnCount, columnCount);
    this.#chosen.geometry.dispose();
    this.#chosen.geometry = new LineSegmentsGeometry().setPositions(pairs);
  }

  /** Combs of all points; drawn on one row of points, or on the streamlines of all rows of tangents. */
  setCombs(combs: Float32Array | null, only: number | null): void {
    const geometry = this.#geometry;
    const info = this.#info;
    const line = this.#lines.combs;
    const fits = geometry && info && combs?.length === 2 * geometry.positions.length;
    line.visible = Boolean(fits);
    if (!fits || !combs) return;
    const fine =
      only === null ? numbers(info.rowCount).map((r) => fineLine(r, info.rowCount, geometry.rowCount)) : [only];
    const made = new THREE.BufferGeometry();
    made.setAttribute("position", new THREE.BufferAttribute(combs, 3));
    made.setIndex(new THREE.BufferAttribute(combLines(fine, geometry.columnCount), 1));
    this.#replace("combs", made);
  }

  setValues(values: Values | null, range: readonly [number, number], colouring: Colouring | null): void {
    const { uniforms } = this.#materials.surface;
    const fits = values && this.#skin && values.values.length * 3 === this.#skin.positions.length;
    uniforms["coloured"]!.value = Boolean(fits && colouring);
    if (!fits || !colouring) return;
    this.#skin!.setValues(values.values);
    [uniforms["low"]!.value, uniforms["high"]!.value] = range;
    uniforms["ramp"]!.value = RAMP_TEXTURES[isDiverging(colouring) ? "diverging" : "sequential"];
  }

  setSettings({ stream, shading }: Settings): void {
    this.#materials.surface.uniforms["finish"]!.value = FINISH[shading];
    this.#surface.visible = stream.surface;
    this.#lines.streamlines.visible = stream.streamlines;
    this.#lines.fine.visible = stream.fine;
    this.#lines.wire.visible = stream.wire;
  }

  #replace(name: LineName, geometry: THREE.BufferGeometry): void {
    this.#lines[name].geometry.dispose();
    this.#lines[name].geometry = geometry;
  }
}
