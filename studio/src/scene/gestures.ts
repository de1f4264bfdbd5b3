// Pointing: clicks, boxes, lassos and brushes over a canvas whose drags otherwise turn the camera.

import type { Combine } from "../state/indices";
import type { Viewport } from "./viewport";

export interface Place {
  x: number;
  y: number;
}

export type Drawn = "box" | "lasso" | "brush";

export interface Listener {
  /** What a drag with the first button draws; null lets it turn the camera. */
  drawn: () => Drawn | null;
  brushRadius: () => number;
  /** Whether something else, such as the gizmo, has the pointer. */
  busy: () => boolean;
  click: (at: Place, how: Combine) => void;
  /** Box and lasso, when they are finished. */
  area: (inside: (x: number, y: number) => boolean, how: Combine) => void;
  /** Every step of a brush stroke. */
  stroke: (at: Place, how: Combine, isFirst: boolean) => void;
  strokeEnd: () => void;
  hover: (at: Place | null) => void;
}

/** Pixels that a click may move. */
const STILL = 4;
const SVG = "http://www.w3.org/2000/svg";

export class Gestures {
  readonly #viewport: Viewport;
  readonly #listener: Listener;
  readonly #svg: SVGSVGElement;
  readonly #shape: SVGPathElement;
  readonly #abort = new AbortController();
  #down: { at: Place; id: number; how: Combine; drawn: Drawn | null; path: Place[] } | null = null;
  #pointers = 0;
  #hover: Place | null = null;
  #hoverRequest = 0;

  constructor(viewport: Viewport, listener: Listener) {
    this.#viewport = viewport;
    this.#listener = listener;
    this.#svg = document.createElementNS(SVG, "svg");
    this.#svg.setAttribute("class", "gesture");
    this.#svg.setAttribute("aria-hidden", "true");
    this.#shape = document.createElementNS(SVG, "path");
    this.#svg.append(this.#shape);
    viewport.canvas.after(this.#svg);
    const { canvas } = viewport;
    const options = { signal: this.#abort.signal };
    // Before the camera's own listeners, so that a drawn drag can keep them out.
    canvas.addEventListener("pointerdown", (e) => this.#onDown(e), { ...options, capture: true });
    canvas.addEventListener("pointermove", (e) => this.#onMove(e), options);
    canvas.addEventListener("pointerup", (e) => this.#onUp(e), options);
    canvas.addEventListener("pointercancel", () => this.#cancel(), options);
    canvas.addEventListener(
      "pointerleave",
      () => {
        this.#setHover(null);
        if (!this.#down) this.#outline([]);
      },
      options,
    );
  }

  dispose(): void {
    this.#abort.abort();
    cancelAnimationFrame(this.#hoverRequest);
    this.#svg.remove();
  }

  #onDown(event: PointerEvent): void {
    this.#pointers += event.isPrimary ? 1 - this.#pointers : 1;
    if (this.#pointers > 1) {
      // A second finger: the camera takes over.
      this.#cancel();
      return;
    }
    if (event.button !== 0 || this.#listener.busy()) return;
    const drawn = event.altKey ? null : this.#listener.drawn();
    const how: Combine =
      event.ctrlKey || event.metaKey ? "remove" : event.shiftKey ? (drawn ? "add" : "toggle") : "replace";
    const at = { x: event.clientX, y: event.clientY };
    this.#down = { at, id: event.pointerId, how, drawn, path: [at] };
    if (drawn) {
      this.#viewport.controls.enabled = false;
      this.#viewport.canvas.setPointerCapture(event.pointerId);
      if (drawn === "brush") this.#listener.stroke(at, how, true);
      this.#outline(this.#down?.path ?? []);
    }
  }

  #onMove(event: PointerEvent): void {
    const at = { x: event.clientX, y: event.clientY };
    const down = this.#down;
    if (!down) {
      if (event.buttons === 0) this.#setHover(at);
      this.#outline(this.#listener.drawn() === "brush" && event.buttons === 0 ? [at] : []);
      return;
    }
    if (event.pointerId !== down.id || !down.drawn) return;
    down.path.push(at);
    if (down.drawn === "brush") this.#listener.stroke(at, down.how, false);
    this.#outline(this.#down?.path ?? []);
  }

  #onUp(event: PointerEvent): void {
    this.#pointers = 0;
    const down = this.#down;
    if (!down || event.pointerId !== down.id) return;
    this.#cancel();
    const at = { x: event.clientX, y: event.clientY };
    const isStill = Math.hypot(at.x - down.at.x, at.y - down.at.y) <= STILL;
    if (down.drawn === "brush") this.#listener.strokeEnd();
    else if (isStill) this.#listener.click(at, down.drawn && down.how === "add" ? "toggle" : down.how);
    else if (down.drawn === "box") this.#listener.area(insideBox(down.at, at), down.how);
    else if (down.drawn === "lasso") this.#listener.area(insideLasso(down.path), down.how);
  }

  #cancel(): void {
    this.#down = null;
    this.#viewport.controls.enabled = true;
    this.#outline([]);
  }

  #setHover(at: Place | null): void {
    this.#hover = at;
    this.#hoverRequest ||= requestAnimationFrame(() => {
      this.#hoverRequest = 0;
      this.#listener.hover(this.#listener.busy() ? null : this.#hover);
    });
  }

  /** Draws a path in the way of the gesture; none if it is empty. */
  #outline(path: readonly Place[]): void {
    const [first, last] = [path[0], path.at(-1)];
    const drawn = this.#down ? this.#down.drawn : this.#listener.drawn();
    let d = "";
    if (first && last) {
      const box = this.#viewport.canvas.getBoundingClientRect();
      const local = ({ x, y }: Place) => `${x - box.left} ${y - box.top}`;
      if (drawn === "box") {
        d = `M${local(first)}L${local({ x: last.x, y: first.y })}L${local(last)}L${local({ x: first.x, y: last.y })}Z`;
      } else if (drawn === "lasso") {
        d = `M${path.map(local).join("L")}Z`;
      } else if (drawn === "brush") {
        const r = this.#listener.brushRadius();
        d = `M${local({ x: last.x - r, y: last.y })}a${r} ${r} 0 1 0 ${2 * r} 0a${r} ${r} 0 1 0 ${-2 * r} 0Z`;
      }
    }
    this.#shape.setAttribute("d", d);
  }
}

function insideBox(a: Place, b: Place): (x: number, y: number) => boolean {
  const [x0, x1] = [Math.min(a.x, b.x), Math.max(a.x, b.x)];
  const [y0, y1] = [Math.min(a.y, b.y), Math.max(a.y, b.y)];
  return (x, y) => x >= x0 && x <= x1 && y >= y0 && y <= y1;
}

/** Even-odd, like the shape that is drawn. */
export function insideLasso(path: readonly Place[]): (x: number, y: number) => boolean {
  return (x, y) => {
    let inside = false;
    for (let i = 0, j = path.length - 1; i < path.length; j = i, i += 1) {
      const [a, b] = [path[i]!, path[j]!];
      if (a.y > y !== b.y > y && x < ((b.x - a.x) * (y - a.y)) / (b.y - a.y) + a.x) inside = !inside;
    }
    return inside;
  };
}
