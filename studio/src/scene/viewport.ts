// A view into space: renderer, camera, orbiting. It draws when something changed, and not otherwise.

import * as THREE from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import type { Triple } from "../kernel/api";
import { record } from "../perf";
import type { Camera } from "../state/project";
import type { Up } from "../state/settings";
import { UP } from "./materials";

export type Preset = "front" | "back" | "left" | "right" | "top" | "bottom" | "iso";

/** With y up; with z up, what was z is -y. */
const TOWARDS: Record<Preset, Triple> = {
  front: [0, 0, 1],
  back: [0, 0, -1],
  left: [-1, 0, 0],
  right: [1, 0, 0],
  // Not quite from above, because there is no left and right there.
  top: [0, 1, 1e-4],
  bottom: [0, -1, 1e-4],
  iso: [-0.62, 0.42, 0.78],
};

/** Turns what is said with y up into what is meant with another axis up. */
const FROM_Y = {
  y: new THREE.Quaternion(),
  z: new THREE.Quaternion().setFromAxisAngle(new THREE.Vector3(1, 0, 0), Math.PI / 2),
} as const;

/** Air around what is shown. */
const AIR = 1.12;

function cornersOf({ min, max }: THREE.Box3): number[] {
  const corners: number[] = [];
  for (const x of [min.x, max.x]) {
    for (const y of [min.y, max.y]) for (const z of [min.z, max.z]) corners.push(x, y, z);
  }
  return corners;
}

export interface Insets {
  left: number;
  right: number;
  top: number;
  bottom: number;
}

export interface Projected {
  x: number;
  y: number;
  depth: number;
}

export class Viewport {
  readonly scene = new THREE.Scene();
  readonly camera = new THREE.PerspectiveCamera(32, 1, 0.01, 100);
  readonly canvas: HTMLCanvasElement;
  readonly renderer: THREE.WebGLRenderer;
  /** Told after the camera came to rest. */
  onCamera: () => void = () => {};
  /** Told while the camera moves, for a second view that follows. */
  onView: () => void = () => {};
  /** Told after each picture, for what lies over the canvas. */
  onDraw: () => void = () => {};

  #controls: OrbitControls;
  #up: Up = "y";
  #insets: Insets = { left: 0, right: 0, top: 0, bottom: 0 };
  #nextInsets = this.#insets;
  #points: ArrayLike<number> = [];
  #sphere = new THREE.Sphere(new THREE.Vector3(), 1);
  #request = 0;
  #flight = 0;
  #lastFrame = 0;
  readonly #observer: ResizeObserver;

  constructor(host: HTMLElement, label: string) {
    this.canvas = document.createElement("canvas");
    this.canvas.tabIndex = 0;
    this.canvas.setAttribute("role", "img");
    this.canvas.setAttribute("aria-label", label);
    this.canvas.className = "viewport";
    host.prepend(this.canvas);
    this.renderer = new THREE.WebGLRenderer({ canvas: this.canvas, antialias: true, alpha: true });
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    this.renderer.setClearAlpha(0);
    this.camera.position.set(...TOWARDS.iso).multiplyScalar(5);
    this.#controls = this.#newControls();
    this.canvas.addEventListener("webglcontextrestored", () => this.invalidate());
    this.#observer = new ResizeObserver(() => this.#resize());
    this.#observer.observe(host);
    this.#resize();
  }

  get controls(): OrbitControls {
    return this.#controls;
  }

  /** The axis that points up. */
  set up(up: Up) {
    if (up === this.#up) return;
    const turn = FROM_Y[this.#up].clone().invert().premultiply(FROM_Y[up]);
    const arm = this.camera.position.clone().sub(this.controls.target).applyQuaternion(turn);
    const target = this.controls.target.clone();
    this.#up = up;
    this.camera.up.set(0, 1, 0).applyQuaternion(FROM_Y[up]);
    this.camera.position.copy(arm).add(target);
    // They take up the direction only when they are made.
    this.#controls.dispose();
    this.#controls = this.#newControls();
    this.#controls.target.copy(target);
    this.#setLimits();
    this.#controls.update();
    this.invalidate();
  }

  #newControls(): OrbitControls {
    const controls = new OrbitControls(this.camera, this.canvas);
    controls.zoomToCursor = true;
    controls.rotateSpeed = 0.9;
    controls.addEventListener("change", () => {
      this.invalidate();
      this.onView();
    });
    controls.addEventListener("start", () => this.#stopFlight());
    controls.addEventListener("end", () => this.onCamera());
    return controls;
  }

  dispose(): void {
    cancelAnimationFrame(this.#request);
    this.#stopFlight();
    this.#observer.disconnect();
    this.controls.dispose();
    this.renderer.dispose();
    this.renderer.forceContextLoss();
    this.canvas.remove();
  }

  /** Draws again with the next frame. */
  invalidate(): void {
    this.#request ||= requestAnimationFrame((now) => {
      this.#request = 0;
      this.#draw(now);
    });
  }

  /**
   * Parts of the canvas that panels cover; what is shown is centred in the rest. From the next `fit` on, since
   * nothing shall jump because a panel closed.
   */
  set insets(insets: Insets) {
    this.#nextInsets = insets;
  }

  /** What `fit` shows and the depth range covers: a box, or more closely the points in it. */
  setBounds(box: THREE.Box3, points: Float32Array | null = null): void {
    box.getBoundingSphere(this.#sphere);
    this.#points = points ?? cornersOf(box);
    if (!(this.#sphere.radius > 0)) this.#sphere.radius = 1;
    this.#setLimits();
    this.invalidate();
  }

  #setLimits(): void {
    this.controls.minDistance = this.#sphere.radius * 0.02;
    this.controls.maxDistance = this.#sphere.radius * 60;
  }

  get radius(): number {
    return this.#sphere.radius;
  }

  /** Shows everything, from where the camera looks or from a given side. */
  fit(from?: Preset | Triple, fly = true): void {
    // The place for it may have changed just now, and the observer tells only later.
    this.#resize();
    this.#takeInsets();
    const towards = from
      ? new THREE.Vector3(...(typeof from === "string" ? TOWARDS[from] : from)).applyQuaternion(FROM_Y[this.#up])
      : this.camera.position.clone().sub(this.controls.target);
    const { clientWidth: w, clientHeight: h } = this.canvas;
    const { left, right, top, bottom } = this.#insets;
    towards.normalize();
    const slope = Math.tan(THREE.MathUtils.degToRad(this.camera.fov / 2)) / Math.max(h, 1);
    const wide = slope * Math.max(w - left - right, 80);
    const high = slope * Math.max(h - top - bottom, 80);
    const distance = this.#distanceToSee(towards, wide, high);
    const position = this.#sphere.center.clone().addScaledVector(towards, distance);
    this.#go(position, this.#sphere.center.clone(), fly);
  }

  /** How far from the middle all points are within slopes to the side and up, and a little air around them. */
  #distanceToSee(towards: THREE.Vector3, wide: number, high: number): number {
    const side = new THREE.Vector3().crossVectors(this.camera.up, towards).normalize();
    const over = new THREE.Vector3().crossVectors(towards, side);
    const p = new THREE.Vector3();
    let distance = this.#sphere.radius * 0.1;
    for (let i = 0; i < this.#points.length; i += 3) {
      p.fromArray(this.#points, i).sub(this.#sphere.center);
      const needs = Math.max(Math.abs(p.dot(side)) / wide, Math.abs(p.dot(over)) / high);
      distance = Math.max(distance, p.dot(towards) + AIR * needs);
    }
    return distance;
  }

  /** Turns the camera around what it looks at, by degrees to the right and up. */
  turn(right: number, up: number): void {
    const arm = this.camera.position.clone().sub(this.controls.target);
    const s = this.#sphericalOf(arm);
    s.theta -= THREE.MathUtils.degToRad(right);
    s.phi = THREE.MathUtils.clamp(s.phi - THREE.MathUtils.degToRad(up), 1e-4, Math.PI - 1e-4);
    this.#go(this.#armOf(s).add(this.controls.target), this.controls.target.clone(), false);
  }

  zoom(factor: number): void {
    const arm = this.camera.position.clone().sub(this.controls.target).divideScalar(factor);
    this.#go(arm.add(this.controls.target), this.controls.target.clone(), false);
  }

  /** A vector of space that goes so far to the right, up and towards the eye on the screen. */
  alongScreen(right: number, up: number, near: number): Triple {
    return new THREE.Vector3(right, up, near).applyQuaternion(this.camera.quaternion).toArray();
  }

  /** Where x, y and z point on the screen: right, up and towards the eye. */
  axes(): Triple[] {
    const turn = this.camera.quaternion.clone().invert();
    return [0, 1, 2].map((i) => new THREE.Vector3().setComponent(i, 1).applyQuaternion(turn).toArray());
  }

  get view(): Camera {
    return {
      position: this.camera.position.toArray(),
      target: this.controls.target.toArray(),
      up: this.camera.up.toArray(),
      zoom: this.camera.zoom,
    };
  }

  set view(view: Camera) {
    this.#stopFlight();
    this.#takeInsets();
    this.camera.position.fromArray(view.position);
    this.controls.target.fromArray(view.target);
    this.camera.zoom = view.zoom;
    this.camera.updateProjectionMatrix();
    this.controls.update();
    this.invalidate();
  }

  /** Where points are on the page, in CSS pixels, and their depths from -1 to 1; good until the camera moves. */
  projector(): (point: THREE.Vector3) => Projected {
    this.camera.updateMatrixWorld();
    const box = this.canvas.getBoundingClientRect();
    const matrix = new THREE.Matrix4().multiplyMatrices(
      this.camera.projectionMatrix,
      this.camera.matrixWorldInverse,
    );
    const p = new THREE.Vector3();
    return (point) => {
      p.copy(point).applyMatrix4(matrix);
      return {
        x: box.left + ((p.x + 1) / 2) * box.width,
        y: box.top + ((1 - p.y) / 2) * box.height,
        depth: p.z,
      };
    };
  }

  /** The ray behind a place of the page. */
  ray(x: number, y: number): THREE.Ray {
    this.camera.updateMatrixWorld();
    const box = this.canvas.getBoundingClientRect();
    const at = new THREE.Vector2(((x - box.left) / box.width) * 2 - 1, 1 - ((y - box.top) / box.height) * 2);
    const caster = new THREE.Raycaster();
    caster.setFromCamera(at, this.camera);
    return caster.ray;
  }

  /** The view as a PNG, over `background` or over nothing. */
  async png(background: string | null): Promise<Blob> {
    this.#draw(performance.now());
    const picture = document.createElement("canvas");
    picture.width = this.canvas.width;
    picture.height = this.canvas.height;
    const context = picture.getContext("2d")!;
    if (background) {
      context.fillStyle = background;
      context.fillRect(0, 0, picture.width, picture.height);
    }
    context.drawImage(this.canvas, 0, 0);
    return new Promise((resolve, reject) => {
      picture.toBlob((blob) => (blob ? resolve(blob) : reject(new Error("the browser drew no picture"))), "image/png");
    });
  }

  #go(position: THREE.Vector3, target: THREE.Vector3, fly: boolean): void {
    this.#stopFlight();
    const from = { arm: this.camera.position.clone().sub(this.controls.target), target: this.controls.target.clone() };
    const start = performance.now();
    const calm = matchMedia("(prefers-reduced-motion: reduce)").matches;
    const duration = fly && !calm ? 260 : 0;
    const a = this.#sphericalOf(from.arm);
    const b = this.#sphericalOf(position.clone().sub(target));
    // The shorter way around.
    a.theta += Math.round((b.theta - a.theta) / (2 * Math.PI)) * 2 * Math.PI;
    const step = (now: number) => {
      const t = duration === 0 ? 1 : Math.min(1, Math.max(0, (now - start) / duration));
      const s = t * t * (3 - 2 * t);
      const mix = (x: number, y: number) => x + s * (y - x);
      const at = new THREE.Spherical(mix(a.radius, b.radius), mix(a.phi, b.phi), mix(a.theta, b.theta));
      this.controls.target.lerpVectors(from.target, target, s);
      this.camera.position.copy(this.#armOf(at)).add(this.controls.target);
      this.controls.update();
      this.invalidate();
      this.onView();
      if (t < 1) this.#flight = requestAnimationFrame(step);
      else this.onCamera();
    };
    step(start);
  }

  /** Angles around the axis that points up. */
  #sphericalOf(arm: THREE.Vector3): THREE.Spherical {
    const upright = arm.clone().applyQuaternion(FROM_Y[this.#up].clone().invert());
    return new THREE.Spherical().setFromVector3(upright);
  }

  #armOf(s: THREE.Spherical): THREE.Vector3 {
    return new THREE.Vector3().setFromSpherical(s).applyQuaternion(FROM_Y[this.#up]);
  }

  #stopFlight(): void {
    cancelAnimationFrame(this.#flight);
    this.#flight = 0;
  }

  #takeInsets(): void {
    if (this.#insets === this.#nextInsets) return;
    this.#insets = this.#nextInsets;
    this.#resize();
  }

  #resize(): void {
    const host = this.canvas.parentElement;
    if (!host) return;
    const w = Math.max(1, host.clientWidth);
    const h = Math.max(1, host.clientHeight);
    this.renderer.setSize(w, h, false);
    this.canvas.style.width = `${w}px`;
    this.canvas.style.height = `${h}px`;
    this.camera.aspect = w / h;
    const { left, right, top, bottom } = this.#insets;
    this.camera.setViewOffset(w, h, (right - left) / 2, (bottom - top) / 2, w, h);
    this.camera.updateProjectionMatrix();
    this.invalidate();
  }

  #draw(now: number): void {
    const distance = this.camera.position.distanceTo(this.#sphere.center);
    this.camera.near = Math.max(distance - 4 * this.#sphere.radius, distance * 0.005, this.#sphere.radius * 0.002);
    this.camera.far = distance + 4 * this.#sphere.radius;
    this.camera.updateProjectionMatrix();
    UP.value.copy(this.camera.up);
    const start = performance.now();
    this.renderer.render(this.scene, this.camera);
    // Pictures that follow each other closely tell the time of one; after a rest only the call counts.
    const since = now - this.#lastFrame;
    record("frame", since < 250 ? Math.max(since, performance.now() - start) : performance.now() - start);
    this.#lastFrame = now;
    this.onDraw();
  }
}
