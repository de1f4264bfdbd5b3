// The viewports of the interpolation workspace: they show what the session has, and tell it what is pointed at.

import { computed, effect } from "@preact/signals";
import * as THREE from "three";
import { TransformControls } from "three/addons/controls/TransformControls.js";
import type { Design } from "../kernel/api";
import { Gestures } from "../scene/gestures";
import { MeshView, paletteOf } from "../scene/meshView";
import { Picker } from "../scene/picker";
import { Viewport, type Insets, type Preset } from "../scene/viewport";
import { NONE, type Combine, type Indices } from "../state/indices";
import { settings } from "../state/settings";
import { look } from "../theme";
import type { Pipeline } from "./pipeline";
import type { Session, Target } from "./session";

const NO_MOVES: Design["moves"] = [];
const NO_CREASES: Design["creases"] = [];

/** One viewport with the mesh and the surface of one pipeline. */
class Stage {
  readonly viewport: Viewport;
  readonly view: MeshView;
  readonly #stop: (() => void)[] = [];

  constructor(host: HTMLElement, label: string, session: Session, pipeline: Pipeline, side: "a" | "b") {
    const viewport = new Viewport(host, label);
    const view = new MeshView(viewport);
    this.viewport = viewport;
    this.view = view;
    const design = () => {
      const mesh = session.mesh.value;
      return side === "a" ? mesh?.design : mesh?.compare;
    };
    // Computed, so that only what changed is drawn anew.
    const moves = computed(() => design()?.moves ?? NO_MOVES);
    const creases = computed(() => design()?.creases ?? NO_CREASES);
    const faces = computed(() => session.mesh.value?.faces ?? NONE);
    const vertices = computed(() => session.mesh.value?.vertices ?? NONE);
    const edges = computed(() => session.mesh.value?.edges ?? NONE);
    this.#stop.push(
      effect(() => {
        viewport.up = settings.value.up;
      }),
      effect(() => {
        void look.value;
        view.setPalette(paletteOf(host));
      }),
      effect(() => view.setGiven(pipeline.given.value, moves.value)),
      effect(() => view.setControl(pipeline.control.value)),
      effect(() => {
        view.setSurface(pipeline.surface.value);
        // Side by side, one legend goes for both.
        const range = session.main.values.value;
        const values = pipeline.values.value;
        view.setValues(values && range && { ...values, low: range.low, high: range.high }, settings.value.colouring);
      }),
      effect(() => view.setFaces(faces.value)),
      effect(() => {
        void pipeline.given.value;
        view.setVertices(vertices.value);
      }),
      effect(() => {
        void pipeline.given.value;
        view.setEdges(edges.value, creases.value);
      }),
      effect(() => view.setSettings(settings.value)),
    );
  }

  dispose(): void {
    for (const stop of this.#stop) stop();
    this.view.dispose();
    this.viewport.dispose();
  }
}

export class MeshScene {
  readonly #session: Session;
  readonly #main: Stage;
  #other: Stage | null = null;
  #insets: Insets;
  readonly #picker: Picker;
  readonly #gestures: Gestures;
  readonly #gizmo: TransformControls;
  /** What the gizmo holds: the middle of the selected vertices. */
  readonly #handle = new THREE.Object3D();
  readonly #grabbed = new THREE.Vector3();
  readonly #stop: (() => void)[] = [];

  constructor(host: HTMLElement, session: Session, insets: Insets) {
    this.#session = session;
    this.#insets = insets;
    this.#main = new Stage(host, "The mesh and its surface", session, session.main, "a");
    const { viewport, view } = this.#main;
    viewport.insets = insets;
    this.#picker = new Picker(viewport, view);
    viewport.onCamera = () => void (session.studio.cameraMoved.value = session.studio.cameraMoved.peek() + 1);
    viewport.onDraw = () => void (session.turns.value = viewport.axes());
    viewport.onView = () => this.#link(viewport, this.#other?.viewport);

    this.#gizmo = new TransformControls(viewport.camera, viewport.canvas);
    this.#gizmo.setSize(0.75);
    this.#gizmo.setColors("#e5484d", "#46a758", "#3e7bfa", "#ffb224");
    viewport.scene.add(this.#handle, this.#gizmo.getHelper());
    this.#gizmo.addEventListener("change", () => viewport.invalidate());
    this.#gizmo.addEventListener("dragging-changed", ({ value }) => {
      viewport.controls.enabled = !value;
      if (value) {
        this.#grabbed.copy(this.#handle.position);
        session.beginDrag();
      } else {
        void session.endDrag();
      }
    });
    this.#gizmo.addEventListener("objectChange", () => {
      session.drag(this.#handle.position.clone().sub(this.#grabbed).toArray());
    });

    this.#gestures = new Gestures(viewport, {
      drawn: () => {
        const gesture = session.gesture.peek();
        return gesture === "click" || session.target.peek() === "edges" ? null : gesture;
      },
      brushRadius: () => session.brushRadius.peek(),
      busy: () => this.#gizmo.axis !== null || this.#gizmo.dragging,
      click: (at, how) => this.#click(at.x, at.y, how),
      area: (inside, how) => this.#pickArea(inside, how),
      stroke: (at, how, isFirst) => {
        const r = session.brushRadius.peek();
        const step = how === "replace" && !isFirst ? "add" : how;
        this.#pickArea((x, y) => Math.hypot(x - at.x, y - at.y) <= r, step, at, "brush");
      },
      strokeEnd: () => session.seal(),
      hover: (at) => this.#hover(at),
    });

    session.onDrag = (answer, moved, at) => view.patch(answer, moved, at);
    this.#stop.push(
      effect(() => {
        if (!session.main.given.value) return;
        const camera = session.pendingCamera;
        session.pendingCamera = null;
        if (camera) viewport.view = camera;
        else viewport.fit(session.firstLook ?? "iso", false);
      }),
      effect(() => this.#placeGizmo()),
      effect(() => {
        const draws = session.gesture.value !== "click" && session.target.value !== "edges";
        viewport.canvas.style.cursor = draws ? "crosshair" : "";
      }),
    );
    session.scene.value = this;
  }

  dispose(): void {
    this.#session.pendingCamera = this.#main.viewport.view;
    this.#session.scene.value = null;
    this.#session.onDrag = () => {};
    for (const stop of this.#stop) stop();
    this.#gestures.dispose();
    this.#gizmo.dispose();
    this.#other?.dispose();
    this.#other = null;
    this.#main.dispose();
  }

  get viewport(): Viewport {
    return this.#main.viewport;
  }

  get view(): MeshView {
    return this.#main.view;
  }

  get picker(): Picker {
    return this.#picker;
  }

  set insets(insets: Insets) {
    this.#insets = insets;
    this.#main.viewport.insets = insets;
    if (this.#other) this.#other.viewport.insets = insets;
  }

  /** Opens the second viewport in `host`, with linked cameras; null closes it. */
  setOther(host: HTMLElement | null): void {
    if (this.#other) {
      this.#other.dispose();
      this.#other = null;
      this.#main.viewport.fit(undefined, false);
    }
    const pipeline = this.#session.other.peek();
    if (!host || !pipeline) return;
    const other = new Stage(host, "The same mesh with the other settings", this.#session, pipeline, "b");
    this.#other = other;
    other.viewport.onView = () => this.#link(other.viewport, this.#main.viewport);
    other.viewport.onCamera = this.#main.viewport.onCamera;
    other.viewport.insets = this.#insets;
    // Half as wide: what did not fit is made to fit again.
    this.#main.viewport.fit(undefined, false);
    other.viewport.view = this.#main.viewport.view;
  }

  show(preset?: Preset): void {
    this.#main.viewport.fit(preset);
  }

  async picture(): Promise<Blob> {
    const background = getComputedStyle(this.#main.viewport.canvas).getPropertyValue("--scene-background").trim();
    return this.#main.viewport.png(background || null);
  }

  screenOf(vertex: number): { x: number; y: number } | null {
    const positions = this.#main.view.givenPositions;
    if (!positions || 3 * vertex + 2 >= positions.length) return null;
    const { x, y } = this.#main.viewport.projector()(new THREE.Vector3().fromArray(positions, 3 * vertex));
    return { x, y };
  }

  #link(from: Viewport, to: Viewport | undefined): void {
    if (!to) return;
    const { position, target } = from.view;
    // Told by hand, because a change of its controls would come back here.
    to.camera.position.fromArray(position);
    to.controls.target.fromArray(target);
    to.camera.lookAt(to.controls.target);
    to.invalidate();
  }

  #click(x: number, y: number, how: Combine): void {
    const target = this.#session.target.peek();
    const picked = this.#at(x, y);
    if (picked === null && how !== "replace") return;
    this.#session.pick(target, picked === null ? NONE : Uint32Array.of(picked), how);
  }

  #at(x: number, y: number): number | null {
    switch (this.#session.target.peek()) {
      case "faces":
        return this.#picker.faceAt(x, y);
      case "vertices":
        return this.#picker.vertexAt(x, y);
      case "edges":
        return this.#picker.edgeAt(x, y, this.#session.main.given.peek()?.ends ?? NONE);
    }
  }

  #pickArea(
    inside: (x: number, y: number) => boolean,
    how: Combine,
    at: { x: number; y: number } | null = null,
    key: string | null = null,
  ): void {
    const session = this.#session;
    const target = session.target.peek() === "vertices" ? "vertices" : "faces";
    let picked: Indices =
      target === "vertices"
        ? this.#picker.verticesIn(inside, session.through.peek())
        : this.#picker.facesIn(inside, session.through.peek());
    const under = at && target === "faces" ? this.#picker.faceAt(at.x, at.y) : null;
    if (under !== null && !picked.includes(under)) picked = Uint32Array.from([...picked, under]).sort();
    session.pick(target, picked, how, key);
  }

  #hover(at: { x: number; y: number } | null): void {
    // Preparing to pick from very many triangles takes a moment, which only a click is worth.
    const isQuick = (this.#main.view.skin?.triangles.length ?? 0) < 3 * 400_000;
    const face = at && isQuick && this.#session.target.peek() === "faces" ? this.#picker.faceAt(at.x, at.y) : null;
    this.#main.view.setHover(face);
    const target = this.#session.target.peek();
    const isFew = (this.#main.view.givenPositions?.length ?? 0) < 3 * 20_000;
    const pick = (wanted: Target) => (at && isFew && isQuick && target === wanted ? this.#at(at.x, at.y) : null);
    this.#main.view.setHoverVertex(pick("vertices"));
    this.#main.view.setHoverEdge(pick("edges"));
  }

  #placeGizmo(): void {
    const session = this.#session;
    const vertices = session.mesh.value?.vertices ?? NONE;
    void session.mesh.value?.design.moves;
    void session.main.given.value;
    if (vertices.length === 0 || session.target.value !== "vertices") {
      this.#gizmo.detach();
    } else if (!this.#gizmo.dragging) {
      this.#handle.position.set(0, 0, 0);
      for (const v of vertices) this.#handle.position.add(new THREE.Vector3(...(session.placeOf(v) ?? [0, 0, 0])));
      this.#handle.position.divideScalar(vertices.length);
      this.#gizmo.attach(this.#handle);
    }
    this.#main.viewport.invalidate();
  }
}
