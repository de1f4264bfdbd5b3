// Things on a canvas that are hovered, clicked and dragged; drags elsewhere turn the camera.

import * as THREE from "three";
import type { Viewport } from "../scene/viewport";

/** Pixels from a thing that still count as on it. */
export const REACH = 13;

export interface Listener<T> {
  /** The things under a place of the page, the nearest first. */
  at: (x: number, y: number) => readonly T[];
  same: (a: T, b: T) => boolean;
  hover: (thing: T | null) => void;
  grab: (thing: T) => void;
  drag: (thing: T, x: number, y: number, event: PointerEvent) => void;
  drop: (thing: T, hasMoved: boolean) => void;
  /** Escape was pressed during a drag that had moved it. */
  cancel: (thing: T) => void;
  /** Clicked where there is none. */
  miss: (x: number, y: number) => void;
}

export class Handles<T> {
  readonly #viewport: Viewport;
  readonly #listener: Listener<T>;
  readonly #abort = new AbortController();
  #down: { thing: T; others: readonly T[]; id: number; x: number; y: number; hasMoved: boolean } | null = null;
  #missed: { x: number; y: number } | null = null;
  #last: T | null = null;
  #hover: { x: number; y: number } | null = null;
  #request = 0;

  constructor(viewport: Viewport, listener: Listener<T>) {
    this.#viewport = viewport;
    this.#listener = listener;
    const { canvas } = viewport;
    const options = { signal: this.#abort.signal };
    // Before the camera's own listeners, so that a grabbed thing can keep them out.
    canvas.addEventListener("pointerdown", (e) => this.#onDown(e), { ...options, capture: true });
    canvas.addEventListener("pointermove", (e) => this.#onMove(e), options);
    canvas.addEventListener("pointerup", (e) => this.#onUp(e), options);
    canvas.addEventListener("pointercancel", (e) => this.#onUp(e), options);
    addEventListener("keydown", (e) => this.#onKey(e), { ...options, capture: true });
    canvas.addEventListener("pointerleave", () => this.#setHover(null), options);
  }

  get dragging(): boolean {
    return this.#down !== null;
  }

  dispose(): void {
    this.#abort.abort();
    cancelAnimationFrame(this.#request);
  }

  #onDown(event: PointerEvent): void {
    this.#viewport.canvas.focus({ preventScroll: true });
    if (event.button !== 0 || !event.isPrimary || this.#down) return;
    const things = this.#listener.at(event.clientX, event.clientY);
    this.#missed = things.length === 0 ? { x: event.clientX, y: event.clientY } : null;
    if (things.length === 0) return;
    // Of several at one place, the one that was taken last stays taken until a click asks for the next.
    const last = this.#last;
    const thing = things.find((t) => last !== null && this.#listener.same(t, last)) ?? things[0]!;
    this.#down = { thing, others: things, id: event.pointerId, x: event.clientX, y: event.clientY, hasMoved: false };
    this.#viewport.controls.enabled = false;
    this.#viewport.canvas.setPointerCapture(event.pointerId);
    this.#listener.grab(thing);
  }

  #onMove(event: PointerEvent): void {
    const down = this.#down;
    if (!down) {
      if (event.buttons === 0) this.#setHover({ x: event.clientX, y: event.clientY });
      return;
    }
    if (event.pointerId !== down.id) return;
    if (!down.hasMoved && Math.hypot(event.clientX - down.x, event.clientY - down.y) < 3) return;
    down.hasMoved = true;
    this.#listener.drag(down.thing, event.clientX, event.clientY, event);
  }

  #onUp(event: PointerEvent): void {
    const down = this.#down;
    const missed = this.#missed;
    this.#missed = null;
    if (missed && Math.hypot(event.clientX - missed.x, event.clientY - missed.y) < 4) {
      this.#listener.miss(missed.x, missed.y);
    }
    if (!down || event.pointerId !== down.id) return;
    this.#down = null;
    this.#viewport.controls.enabled = true;
    this.#listener.drop(down.thing, down.hasMoved);
    const wasLast = this.#last !== null && this.#listener.same(down.thing, this.#last);
    this.#last = down.thing;
    if (!down.hasMoved && wasLast && down.others.length > 1) {
      // A second click on the same heap takes the next.
      const at = down.others.findIndex((t) => this.#listener.same(t, down.thing));
      const next = down.others[(at + 1) % down.others.length]!;
      this.#last = next;
      this.#listener.grab(next);
      this.#listener.drop(next, false);
    }
  }

  #onKey(event: KeyboardEvent): void {
    const down = this.#down;
    if (event.key !== "Escape" || !down) return;
    event.preventDefault();
    event.stopPropagation();
    this.#down = null;
    this.#viewport.controls.enabled = true;
    if (down.hasMoved) this.#listener.cancel(down.thing);
  }

  #setHover(at: { x: number; y: number } | null): void {
    this.#hover = at;
    this.#request ||= requestAnimationFrame(() => {
      this.#request = 0;
      if (this.#down) return;
      const place = this.#hover;
      const thing = place ? (this.#listener.at(place.x, place.y)[0] ?? null) : null;
      this.#viewport.canvas.style.cursor = thing ? "grab" : "";
      this.#listener.hover(thing);
    });
  }
}

/**
 * The direction from `centre` to where a ray meets the sphere around it, or to the nearest point of its outline.
 * `far` takes the second point where it meets.
 */
export function directionAt(ray: THREE.Ray, centre: THREE.Vector3, radius: number, far: boolean): THREE.Vector3 {
  const hit = new THREE.Vector3();
  const nearest = ray.closestPointToPoint(centre, new THREE.Vector3());
  if (!ray.intersectSphere(new THREE.Sphere(centre, radius), hit)) return nearest.sub(centre).normalize();
  // The second point is the image of the first in the point of the ray that is nearest to the centre.
  if (far) hit.lerp(nearest, 2);
  return hit.sub(centre).normalize();
}
