// The two viewports of the workspace: the surface with its tangents, and the Gaussian sphere.

import { effect, untracked } from "@preact/signals";
import * as THREE from "three";
import type { Triple } from "../kernel/api";
import { pointMaterial } from "../scene/materials";
import { paletteOf } from "../scene/meshView";
import { Viewport, type Insets, type Preset } from "../scene/viewport";
import { settings } from "../state/settings";
import { look } from "../theme";
import { Arrows, Numbering, tangentPaletteOf } from "./arrows";
import { directionAt, Handles, REACH } from "./handles";
import { alongColumns, segments } from "./lines";
import { fineLine, handlesOf, type Initial, type Place } from "./model";
import { PatchView } from "./patchView";
import { ARC_STEPS, type StreamSession } from "./session";
import { Sphere, type Marks } from "./sphere";

/** What can be dragged in the scene: the tip of a tangent, or a point of the initial curve. */
type Thing = { kind: "tangent"; index: number } | { kind: "initial"; index: number };

/** The box around the sphere and its labels. */
const BALL = new THREE.Vector3(1.45, 1.45, 1.45);

/** Length of an arrow, relative to the radius of the model. */
const ARROW = 0.15;

const sameThing = (a: Thing, b: Thing) => a.kind === b.kind && a.index === b.index;

/** A few words over a canvas that stay where a point of space is. */
class Label {
  readonly #element = document.createElement("span");
  readonly #viewport: Viewport;
  #at: THREE.Vector3 | null = null;

  constructor(viewport: Viewport, name: string) {
    this.#viewport = viewport;
    this.#element.className = name;
    this.#element.setAttribute("aria-hidden", "true");
    viewport.canvas.after(this.#element);
    this.show(null);
  }

  show(at: THREE.Vector3 | null, text = ""): void {
    this.#at = at;
    this.#element.textContent = text;
    this.#element.hidden = at === null;
    this.place();
  }

  place(): void {
    if (!this.#at) return;
    const { x, y } = this.#viewport.projector()(this.#at);
    const box = this.#viewport.canvas.getBoundingClientRect();
    this.#element.style.transform = `translate(${(x - box.left).toFixed(1)}px, ${(y - box.top).toFixed(1)}px)`;
  }
}

export class StreamScene {
  readonly #session: StreamSession;
  readonly #main: Viewport;
  readonly #ball: Viewport;
  readonly #sphere = new Sphere();
  readonly #arrows = new Arrows();
  readonly #initial = {
    points: new THREE.Points(new THREE.BufferGeometry(), pointMaterial(11, 9e-4)),
    polygon: new THREE.Line(
      new THREE.BufferGeometry(),
      new THREE.LineBasicMaterial({ transparent: true, opacity: 0.7 }),
    ),
    curve: new THREE.LineSegments(new THREE.BufferGeometry(), new THREE.LineBasicMaterial()),
  };
  #patches: PatchView[] = [];
  readonly #handles: { main: Handles<Thing>; ball: Handles<number> };
  readonly #labels: { main: Label; ball: Label; axes: Label[] };
  readonly #stop: (() => void)[] = [];
  /** Of the direction that is dragged: whether it is on the far side. */
  #isFar = false;
  /** Where a point of the initial curve was grabbed, and the plane in which it moves. */
  #plane = new THREE.Plane();
  /** What the camera was last pointed at by itself. */
  #framed: THREE.Sphere | null = null;

  constructor(main: HTMLElement, ball: HTMLElement, session: StreamSession) {
    this.#session = session;
    this.#main = new Viewport(main, "The surface with its tangents");
    this.#ball = new Viewport(ball, "The Gaussian sphere with the tangents as points");
    this.#ball.scene.add(this.#sphere.root);
    this.#ball.setBounds(new THREE.Box3().setFromCenterAndSize(new THREE.Vector3(), BALL));
    this.#main.scene.add(this.#arrows.root, ...Object.values(this.#initial));
    this.#arrows.root.renderOrder = 20;
    for (const object of Object.values(this.#initial)) {
      object.frustumCulled = false;
      object.renderOrder = 21;
    }

    this.#labels = {
      main: new Label(this.#main, "tangent-label"),
      ball: new Label(this.#ball, "tangent-label"),
      axes: ["x", "y", "z"].map((name, i) => {
        const label = new Label(this.#ball, "axis-label");
        label.show(new THREE.Vector3().setComponent(i, 1.1), name);
        return label;
      }),
    };
    this.#main.onDraw = () => this.#labels.main.place();
    this.#ball.onDraw = () => {
      for (const label of [this.#labels.ball, ...this.#labels.axes]) label.place();
    };
    this.#main.onCamera = () => void (session.studio.cameraMoved.value += 1);
    this.#main.onView = () => this.#turnTogether(this.#main, this.#ball);
    this.#ball.onView = () => this.#turnTogether(this.#ball, this.#main);

    this.#handles = {
      main: new Handles<Thing>(this.#main, {
        at: (x, y) => this.#thingsAt(x, y),
        same: sameThing,
        hover: (thing) => this.#hover(thing?.kind === "tangent" ? thing.index : null),
        grab: (thing) => this.#grab(thing),
        drag: (thing, x, y, event) => this.#drag(thing, x, y, event.shiftKey),
        drop: () => session.seal(),
        cancel: () => session.cancelDrag(),
        miss: (x, y) => this.#pickPatch(x, y),
      }),
      ball: new Handles<number>(this.#ball, {
        at: (x, y) => this.#marksAt(x, y),
        same: (a, b) => a === b,
        hover: (index) => this.#hover(index),
        grab: (index) => {
          session.beginDrag();
          session.select(this.#placeOf(index));
          this.#isFar = this.#facing(this.#tangent(index), this.#ball) < 0;
        },
        drag: (index, x, y, event) => {
          const isFar = this.#isFar !== event.shiftKey;
          const direction = directionAt(this.#ball.ray(x, y), new THREE.Vector3(), 1, isFar);
          session.setTangent(direction.toArray(), this.#placeOf(index));
        },
        drop: () => session.seal(),
        cancel: () => session.cancelDrag(),
        miss: () => {},
      }),
    };

    this.#stop.push(
      effect(() => {
        const { up } = settings.value;
        untracked(() => {
          this.#main.up = this.#ball.up = up;
          // Its controls may be new ones now.
          this.#ball.controls.enablePan = false;
          this.#ball.controls.zoomToCursor = false;
        });
      }),
      effect(() => {
        void look.value;
        this.#paint(main, ball);
      }),
      effect(() => this.#showSurfaces()),
      effect(() => {
        void session.drawn.value;
        // Apart from what it reads, or its own answers would call it again.
        untracked(() => this.#frame());
      }),
      effect(() => this.#showValues()),
      effect(() => this.#showTangents()),
      effect(() => this.#showMarks()),
      effect(() => this.#showCurves()),
      effect(() => this.#showInitial()),
    );
    this.#ball.fit("iso", false);
    session.scene.value = this;
  }

  dispose(): void {
    this.#session.pendingCamera = this.#main.view;
    this.#session.scene.value = null;
    for (const stop of this.#stop) stop();
    this.#handles.main.dispose();
    this.#handles.ball.dispose();
    for (const view of this.#patches) view.dispose();
    this.#arrows.dispose();
    this.#sphere.dispose();
    for (const { geometry, material } of Object.values(this.#initial)) {
      geometry.dispose();
      material.dispose();
    }
    this.#main.dispose();
    this.#ball.dispose();
  }

  get viewport(): Viewport {
    return this.#main;
  }

  set insets(insets: Insets) {
    this.#main.insets = insets;
  }

  show(preset?: Preset): void {
    this.#main.fit(preset);
  }

  async picture(): Promise<Blob> {
    const background = getComputedStyle(this.#main.canvas).getPropertyValue("--scene-background").trim();
    return this.#main.png(background || null);
  }

  /** Where a tangent of the patch that is worked on is on the page, for tests. */
  screenOfTangent(row: number, column: number, where: "sphere" | "scene"): { x: number; y: number } | null {
    const index = row * this.#arrows.columnCount + column;
    if (column >= this.#arrows.columnCount || index >= this.#arrows.count) return null;
    const { x, y } =
      where === "scene"
        ? this.#main.projector()(this.#arrows.tipOf(index))
        : this.#ball.projector()(this.#tangent(index));
    return { x, y };
  }

  /** Where a point of the initial curve is on the page, for tests. */
  screenOfInitial(index: number): { x: number; y: number } | null {
    const point = handlesOf(this.#session.current.peek()?.initial ?? NO_CURVE)[index];
    if (!point) return null;
    const { x, y } = this.#main.projector()(new THREE.Vector3(...point));
    return { x, y };
  }

  // -------------------------------------------------------------- what is shown

  #paint(main: HTMLElement, ball: HTMLElement): void {
    const palette = paletteOf(main);
    const tangents = tangentPaletteOf(main);
    for (const view of this.#patches) view.setPalette(palette);
    this.#arrows.setPalette(tangents);
    const style = getComputedStyle(ball);
    const of = (name: string) => style.getPropertyValue(name).trim() || "#888888";
    const pixels = this.#ball.renderer.getPixelRatio();
    const colours = { ball: of("--scene-ball"), meridian: of("--scene-meridian"), curve: of("--scene-curve") };
    this.#sphere.setPalette(tangents, colours, pixels);
    const { points, polygon, curve } = this.#initial;
    (points.material.uniforms["colour"]!.value as THREE.Color).set(palette.control);
    (points.material.uniforms["ring"]!.value as THREE.Color).set(palette.ring);
    points.material.uniforms["pixels"]!.value = pixels;
    polygon.material.color.set(palette.control);
    curve.material.color.set(palette.control);
    this.#redraw();
  }

  #redraw(): void {
    this.#main.invalidate();
    this.#ball.invalidate();
  }

  #showSurfaces(): void {
    const session = this.#session;
    const geometries = session.geometries.value;
    const infos = session.infos.value;
    const patch = session.patch.value;
    const all = settings.value;
    const count = Math.min(geometries.length, infos.length);
    // Between two models there is nothing to draw for a moment; the old picture is better than none.
    if (count === 0 && infos.length > 0) return;
    while (this.#patches.length > count) this.#patches.pop()!.dispose();
    while (this.#patches.length < count) {
      const view = new PatchView();
      view.setPalette(paletteOf(this.#main.canvas));
      this.#main.scene.add(view.root);
      this.#patches.push(view);
    }
    const { stream } = all;
    const { row, column } = session.place.value;
    const control = session.control.value;
    this.#patches.forEach((view, i) => {
      view.setGeometry(geometries[i]!, infos[i]!);
      view.setSettings(all);
      const isCurrent = i === patch;
      const line = control && stream.sphere !== "all" ? fineLine(row, control.rowCount, geometries[i]!.rowCount) : null;
      const isShown = isCurrent && control !== null && stream.streamlines && stream.sphere !== "all";
      if (isShown && stream.sphere === "column") {
        view.setChosen(fineLine(column, control.columnCount, geometries[i]!.columnCount), true);
      } else {
        view.setChosen(isShown ? line : null);
      }
      view.setCombs(isCurrent && stream.combs ? session.combs.value : null, line);
    });
    this.#main.invalidate();
  }

  /** Looks at what was drawn anew, unless it is about where it was before. */
  #frame(): void {
    const geometries = this.#session.geometries.peek();
    if (geometries.length === 0) return;
    const box = new THREE.Box3();
    for (const { positions } of geometries) box.union(new THREE.Box3().setFromArray(positions));
    if (box.isEmpty()) return;
    // With room for the arrows.
    this.#main.setBounds(box.clone().expandByScalar(0.08 * box.getSize(new THREE.Vector3()).length()));
    const now = box.getBoundingSphere(new THREE.Sphere());
    const old = this.#framed;
    this.#session.size.value = now.radius;
    const isElsewhere =
      !old ||
      now.radius > 1.6 * old.radius ||
      old.radius > 1.6 * now.radius ||
      now.center.distanceTo(old.center) > old.radius;
    if (!isElsewhere) return;
    this.#framed = now;
    const camera = this.#session.pendingCamera;
    this.#session.pendingCamera = null;
    if (camera) this.#main.view = camera;
    else this.#main.fit(this.#session.firstLook ?? "iso", false);
    this.#turnTogether(this.#main, this.#ball);
  }

  #showValues(): void {
    const session = this.#session;
    void session.geometries.value;
    const values = session.values.value;
    const colouring = session.colouring.value;
    const range = session.range.value;
    this.#patches.forEach((view, i) => view.setValues(values?.[i] ?? null, range, colouring));
    this.#main.invalidate();
  }

  #showTangents(): void {
    const session = this.#session;
    const control = session.control.value;
    const { arrows, arrowSize, sphere } = settings.value.stream;
    this.#arrows.root.visible = arrows && control !== null;
    if (control) {
      const { feet, tangents, rowCount, columnCount } = control;
      // Many would hide the surface, if they were as long as few.
      const crowd = Math.min(1, Math.max(0.3, Math.sqrt(70 / (rowCount * columnCount))));
      const numbering = new Numbering(rowCount, columnCount, sphere === "column");
      this.#arrows.set(feet, tangents, numbering, ARROW * session.size.value * arrowSize * crowd);
      this.#arrows.mark(this.#indexOf(session.place.value), this.#hovered());
    }
    this.#main.invalidate();
  }

  #showMarks(): void {
    const session = this.#session;
    const control = session.control.value;
    const place = session.place.value;
    const hovered = this.#hovered();
    if (!control) {
      this.#sphere.setMarks(NO_MARKS);
    } else {
      const { rowCount, columnCount, tangents } = control;
      const numbering = new Numbering(rowCount, columnCount, settings.value.stream.sphere === "column");
      const indices = this.#shownIndices();
      // What is pointed at in the scene lights up here, also if its row is not shown.
      if (hovered >= 0 && !indices.includes(hovered)) indices.push(hovered);
      const selected = place.row * columnCount + place.column;
      this.#sphere.setMarks({ tangents, indices, numbering, selected, hovered });
    }
    this.#showLabels(hovered);
    this.#ball.invalidate();
  }

  #showLabels(hovered: number): void {
    const { main, ball } = this.#labels;
    if (hovered < 0 || hovered >= this.#arrows.count) {
      main.show(null);
      ball.show(null);
      return;
    }
    const { row, column } = this.#placeOf(hovered);
    const text = `${row + 1}, ${column + 1}`;
    main.show(settings.peek().stream.arrows ? this.#arrows.tipOf(hovered) : null, text);
    ball.show(this.#tangent(hovered), text);
    this.#main.invalidate();
  }

  #showCurves(): void {
    const session = this.#session;
    const geometry = session.geometry.value;
    const info = session.control.value;
    const { stream } = settings.value;
    const { row, column } = session.place.value;
    let pairs: Float32Array | null = null;
    if (geometry && info && stream.curves) {
      const { fineTangents, rowCount, columnCount } = geometry;
      if (stream.sphere === "column") {
        const line = fineLine(column, info.columnCount, columnCount);
        pairs = segments(fineTangents, line, rowCount, columnCount);
      } else {
        const rows = stream.sphere === "row" ? [row] : Array.from({ length: info.rowCount }, (_, i) => i);
        const runs = rows.map((r) =>
          segments(fineTangents, fineLine(r, info.rowCount, rowCount) * columnCount, columnCount),
        );
        pairs = new Float32Array(runs.reduce((sum, run) => sum + run.length, 0));
        let at = 0;
        for (const run of runs) {
          pairs.set(run, at);
          at += run.length;
        }
      }
    }
    this.#sphere.setCurves(pairs);
    const arcs = stream.arcs && session.level.value === 0 ? session.arcs.value : null;
    const perLine = (stream.sphere === "column" ? (info?.rowCount ?? 1) : (info?.columnCount ?? 1)) - 1;
    const line = stream.sphere === "column" ? column : row;
    this.#sphere.setArcs(arcs, ARC_STEPS, stream.sphere === "all" ? null : [line * perLine, (line + 1) * perLine]);
    this.#ball.invalidate();
  }

  #showInitial(): void {
    const session = this.#session;
    const patch = session.current.value;
    const geometry = session.geometry.value;
    const isShown = settings.value.stream.initial && patch !== null;
    const { points, polygon, curve } = this.#initial;
    points.visible = polygon.visible = isShown;
    curve.visible = false;
    if (isShown) {
      const places = handlesOf(patch.initial).map((p) => new THREE.Vector3(...p));
      for (const object of [points, polygon]) {
        object.geometry.dispose();
        object.geometry = new THREE.BufferGeometry().setFromPoints(places);
      }
      // The curve itself is a line of the surface where the streamlines begin or end on it.
      const { s0 = "min" } = patch;
      if (geometry && (s0 === "min" || s0 === "max")) {
        const column = s0 === "min" ? 0 : geometry.columnCount - 1;
        curve.visible = true;
        curve.geometry.dispose();
        curve.geometry = new THREE.BufferGeometry();
        curve.geometry.setAttribute("position", new THREE.BufferAttribute(geometry.positions, 3));
        curve.geometry.setIndex([...alongColumns([column], geometry.rowCount, geometry.columnCount)]);
      }
    }
    this.#main.invalidate();
  }

  // -------------------------------------------------------------- pointing

  #placeOf(index: number): Place {
    const columnCount = Math.max(1, this.#arrows.columnCount);
    return { row: Math.floor(index / columnCount), column: index % columnCount };
  }

  #indexOf({ row, column }: Place): number {
    return row * this.#arrows.columnCount + column;
  }

  #hovered(): number {
    const hovered = this.#session.hovered.value;
    return hovered && hovered.patch === this.#session.patch.value ? this.#indexOf(hovered) : -1;
  }

  #tangent(index: number): THREE.Vector3 {
    const tangents = this.#session.control.peek()?.tangents ?? new Float32Array(0);
    return new THREE.Vector3().fromArray(tangents, 3 * index);
  }

  /** Positive where a direction points to the eye. */
  #facing(direction: THREE.Vector3, viewport: Viewport, foot = new THREE.Vector3()): number {
    return direction.dot(viewport.camera.position.clone().sub(foot));
  }

  /** The tangents that the sphere shows. */
  #shownIndices(): number[] {
    const info = this.#session.control.value;
    if (!info) return [];
    const { row, column } = this.#session.place.value;
    const { sphere } = settings.value.stream;
    const all = Array.from({ length: info.rowCount * info.columnCount }, (_, i) => i);
    if (sphere === "all") return all;
    return all.filter((i) =>
      sphere === "row" ? Math.floor(i / info.columnCount) === row : i % info.columnCount === column,
    );
  }

  #marksAt(x: number, y: number): number[] {
    const project = this.#ball.projector();
    const found = this.#shownIndices().map((index) => {
      const tangent = this.#tangent(index);
      const at = project(tangent);
      // What is on the far side gives way to what is in front.
      const isFar = this.#facing(tangent, this.#ball) < 1;
      return { index, away: Math.hypot(at.x - x, at.y - y), rank: isFar ? 1 : 0 };
    });
    return found
      .filter(({ away }) => away < REACH)
      .sort((a, b) => a.rank - b.rank || a.away - b.away)
      .map(({ index }) => index);
  }

  #thingsAt(x: number, y: number): Thing[] {
    const project = this.#main.projector();
    const found: { thing: Thing; away: number }[] = [];
    const { stream } = settings.peek();
    const patch = this.#session.current.peek();
    if (stream.initial && patch) {
      handlesOf(patch.initial).forEach((p, index) => {
        const at = project(new THREE.Vector3(...p));
        found.push({ thing: { kind: "initial", index }, away: Math.hypot(at.x - x, at.y - y) });
      });
    }
    if (stream.arrows) {
      const [foot, tip] = [new THREE.Vector3(), new THREE.Vector3()];
      const line = new THREE.Line3();
      const pointer = new THREE.Vector3(x, y, 0);
      const nearest = new THREE.Vector3();
      for (let index = 0; index < this.#arrows.count; index += 1) {
        const a = project(this.#arrows.footOf(index, foot));
        const b = project(this.#arrows.tipOf(index, tip));
        if (b.depth > 1) continue;
        // The head counts as a whole, the shaft only close by, the tip most.
        line.start.set(a.x, a.y, 0).lerp(line.end.set(b.x, b.y, 0), 0.5);
        const onHead = line.closestPointToPoint(pointer, true, nearest).distanceTo(pointer);
        const onTip = Math.hypot(b.x - x, b.y - y);
        found.push({ thing: { kind: "tangent", index }, away: Math.min(onTip, onHead + 4) });
      }
    }
    const eye = this.#main.camera.position;
    const isHidden = ({ kind, index }: Thing) => {
      if (kind === "initial") return false;
      const tip = this.#arrows.tipOf(index);
      const way = tip.distanceTo(eye) - 0.5 * this.#arrows.length;
      const ray = new THREE.Ray(eye, tip.sub(eye).normalize());
      return this.#patches.some((view) => view.wayTo(ray) < way);
    };
    // What the surface hides gives way to what is seen.
    return found
      .filter(({ away }) => away < REACH)
      .map(({ thing, away }) => ({ thing, away: away + (isHidden(thing) ? REACH : 0) }))
      .sort((a, b) => a.away - b.away)
      .map(({ thing }) => thing);
  }

  /** Goes on with the patch that is clicked. */
  #pickPatch(x: number, y: number): void {
    const ray = this.#main.ray(x, y);
    const ways = this.#patches.map((view) => view.wayTo(ray));
    const patch = ways.indexOf(Math.min(...ways));
    const session = this.#session;
    if (ways[patch] === Infinity || patch < 0 || patch === session.patch.peek()) return;
    session.select(session.place.peek(), patch);
  }

  #hover(index: number | null): void {
    const session = this.#session;
    session.hovered.value = index === null ? null : { patch: session.patch.peek(), ...this.#placeOf(index) };
  }

  #grab(thing: Thing): void {
    this.#session.beginDrag();
    if (thing.kind === "initial") {
      const place = new THREE.Vector3(...handlesOf(this.#session.current.peek()!.initial)[thing.index]!);
      const eye = this.#main.camera.getWorldDirection(new THREE.Vector3());
      this.#plane.setFromNormalAndCoplanarPoint(eye, place);
      return;
    }
    this.#session.select(this.#placeOf(thing.index));
    const foot = this.#arrows.footOf(thing.index);
    this.#isFar = this.#facing(this.#tangent(thing.index), this.#main, foot) < 0;
  }

  #drag(thing: Thing, x: number, y: number, isOther: boolean): void {
    const ray = this.#main.ray(x, y);
    if (thing.kind === "initial") {
      const place = ray.intersectPlane(this.#plane, new THREE.Vector3());
      if (place) this.#session.moveInitial(thing.index, place.toArray() as Triple);
      return;
    }
    const foot = this.#arrows.footOf(thing.index);
    const direction = directionAt(ray, foot, this.#arrows.length, this.#isFar !== isOther);
    this.#session.setTangent(direction.toArray(), this.#placeOf(thing.index));
  }

  /** The other viewport looks from the same side. */
  #turnTogether(from: Viewport, to: Viewport): void {
    if (!settings.peek().stream.linked) return;
    const arm = from.camera.position.clone().sub(from.controls.target).normalize();
    const distance = to.camera.position.distanceTo(to.controls.target);
    to.camera.up.copy(from.camera.up);
    to.camera.position.copy(to.controls.target).addScaledVector(arm, distance);
    to.camera.lookAt(to.controls.target);
    to.invalidate();
  }
}

const NO_MARKS: Marks = {
  tangents: new Float32Array(0),
  indices: [],
  numbering: new Numbering(0, 0, false),
  selected: -1,
  hovered: -1,
};
const NO_CURVE: Initial = { type: "polyline", points: [], t: [] };
