// The Gaussian sphere: tangents as points on it, great arcs between neighbours, refined tangents as curves.

import * as THREE from "three";
import { LineMaterial } from "three/addons/lines/LineMaterial.js";
import { LineSegments2 } from "three/addons/lines/LineSegments2.js";
import { LineSegmentsGeometry } from "three/addons/lines/LineSegmentsGeometry.js";
import { colourOf, ringColour, shapeOf, sizeOf, type Numbering, type TangentPalette } from "./arrows";

/** Everything on the sphere is drawn a little outside, so that what veils the far side lies below it. */
const LIFT = 1.004;
const POINT_SIZE = 16;

function ballMaterial(): THREE.ShaderMaterial {
  return new THREE.ShaderMaterial({
    transparent: true,
    depthWrite: false,
    uniforms: { colour: { value: new THREE.Color() }, ink: { value: new THREE.Color() }, veil: { value: 0.38 } },
    vertexShader: /* glsl */ `
      varying vec3 vNormal;
      varying vec3 vPlace;
      void main() {
        vec4 place = modelViewMatrix * vec4(position, 1.0);
        vPlace = place.xyz;
        vNormal = normalMatrix * normal;
        gl_Position = projectionMatrix * place;
      }`,
    fragmentShader: /* glsl */ `
      uniform vec3 colour;
      uniform vec3 ink;
      uniform float veil;
      varying vec3 vNormal;
      varying vec3 vPlace;
      void main() {
        float facing = clamp(dot(normalize(vNormal), normalize(-vPlace)), 0.0, 1.0);
        float rim = pow(1.0 - facing, 3.0);
        float light = 0.94 + 0.06 * normalize(vNormal).y;
        gl_FragColor = vec4(mix(colour * light, ink, 0.34 * rim), veil + 0.25 * rim);
        #include <colorspace_fragment>
      }`,
  });
}

/** Thin lines, fainter on the far side. */
function gridMaterial(opacity: number): THREE.ShaderMaterial {
  return new THREE.ShaderMaterial({
    transparent: true,
    depthWrite: false,
    uniforms: { colour: { value: new THREE.Color() }, opacity: { value: opacity } },
    vertexShader: /* glsl */ `
      varying float vFacing;
      void main() {
        vec4 place = modelViewMatrix * vec4(position, 1.0);
        vFacing = dot(normalize(normalMatrix * position), normalize(-place.xyz));
        gl_Position = projectionMatrix * place;
      }`,
    fragmentShader: /* glsl */ `
      uniform vec3 colour;
      uniform float opacity;
      varying float vFacing;
      void main() {
        gl_FragColor = vec4(colour, opacity * mix(0.3, 1.0, smoothstep(-0.05, 0.1, vFacing)));
        #include <colorspace_fragment>
      }`,
  });
}

/** Discs, squares and diamonds of a size in pixels, each with a ring of its own colour. */
function markMaterial(): THREE.ShaderMaterial {
  return new THREE.ShaderMaterial({
    transparent: true,
    uniforms: { pixels: { value: 1 }, ink: { value: new THREE.Color() } },
    vertexShader: /* glsl */ `
      attribute vec3 fill;
      attribute vec3 ring;
      attribute vec2 form;
      uniform float pixels;
      varying vec3 vFill;
      varying vec3 vRing;
      varying vec2 vForm;
      void main() {
        vFill = fill;
        vRing = ring;
        vForm = form;
        gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
        gl_Position.z -= 1e-3 * gl_Position.w;
        gl_PointSize = form.x * pixels;
      }`,
    fragmentShader: /* glsl */ `
      uniform float pixels;
      uniform vec3 ink;
      varying vec3 vFill;
      varying vec3 vRing;
      varying vec2 vForm;
      void main() {
        vec2 p = abs(gl_PointCoord - 0.5) * vForm.x * pixels;
        float r = vForm.y < 0.5 ? length(p) : vForm.y < 1.5 ? max(p.x, p.y) * 1.12 : (p.x + p.y) * 0.98;
        float edge = 0.5 * vForm.x * pixels;
        if (r > edge) discard;
        float wide = 2.6 * pixels;
        vec3 colour = mix(vFill, vRing, smoothstep(edge - wide - 0.7, edge - wide + 0.3, r));
        colour = mix(colour, ink, smoothstep(edge - 1.2 * pixels, edge - 0.4 * pixels, r) * 0.75);
        gl_FragColor = vec4(colour, 1.0 - smoothstep(edge - 0.8, edge, r));
        #include <colorspace_fragment>
      }`,
  });
}

/** Meridians and parallels every 15 degrees. */
function graticule(): THREE.BufferGeometry {
  const places: THREE.Vector3[] = [];
  const radians = THREE.MathUtils.degToRad;
  const at = (phi: number, theta: number) => new THREE.Vector3().setFromSphericalCoords(1, radians(phi), radians(theta));
  for (let theta = 0; theta < 360; theta += 15) {
    for (let phi = 15; phi < 165; phi += 3) places.push(at(phi, theta), at(phi + 3, theta));
  }
  for (let phi = 15; phi < 180; phi += 15) {
    for (let theta = 0; theta < 360; theta += 3) places.push(at(phi, theta), at(phi, theta + 3));
  }
  return new THREE.BufferGeometry().setFromPoints(places);
}

/** What is on the sphere: `indices` of control tangents, and their numbers for their marks. */
export interface Marks {
  tangents: Float32Array;
  indices: readonly number[];
  numbering: Numbering;
  selected: number;
  hovered: number;
}

export class Sphere {
  readonly root = new THREE.Group();
  readonly #ball = new THREE.Mesh(new THREE.SphereGeometry(1, 96, 64), ballMaterial());
  readonly #grid = new THREE.LineSegments(graticule(), gridMaterial(0.16));
  readonly #arcs = new THREE.LineSegments(new THREE.BufferGeometry(), gridMaterial(0.75));
  readonly #curves = new LineSegments2(new LineSegmentsGeometry(), new LineMaterial({ linewidth: 2.5 }));
  readonly #points = new THREE.Points(new THREE.BufferGeometry(), markMaterial());
  #palette: TangentPalette | null = null;
  #marks: Marks | null = null;

  constructor() {
    const lifted = [this.#arcs, this.#curves, this.#points];
    for (const object of lifted) object.scale.setScalar(LIFT);
    [this.#curves, this.#points, this.#ball, this.#grid, this.#arcs].forEach((object, order) => {
      object.frustumCulled = false;
      object.renderOrder = order;
      this.root.add(object);
    });
    this.#curves.visible = this.#arcs.visible = this.#points.visible = false;
  }

  dispose(): void {
    for (const { geometry, material } of [this.#ball, this.#grid, this.#arcs, this.#curves, this.#points]) {
      geometry.dispose();
      material.dispose();
    }
  }

  setPalette(
    palette: TangentPalette,
    { ball, meridian, curve }: { ball: string; meridian: string; curve: string },
    pixels: number,
  ): void {
    this.#palette = palette;
    const paint = (material: THREE.ShaderMaterial, name: string, colour: string) =>
      (material.uniforms[name]!.value as THREE.Color).set(colour);
    paint(this.#ball.material, "colour", ball);
    paint(this.#ball.material, "ink", meridian);
    paint(this.#grid.material, "colour", meridian);
    paint(this.#arcs.material, "colour", meridian);
    paint(this.#points.material, "ink", palette.ink);
    this.#points.material.uniforms["pixels"]!.value = pixels;
    this.#curves.material.color.set(curve);
    if (this.#marks) this.setMarks(this.#marks);
  }

  /** Pairs of points, 3 numbers each. */
  setCurves(pairs: Float32Array | null): void {
    this.#curves.visible = pairs !== null && pairs.length > 0;
    if (!pairs || pairs.length === 0) return;
    this.#curves.geometry.dispose();
    this.#curves.geometry = new LineSegmentsGeometry().setPositions(pairs);
  }

  /** Runs of `steps` points each, of which those in `chosen` are drawn; null draws all. */
  setArcs(arcs: Float32Array | null, steps: number, chosen: readonly [number, number] | null): void {
    const count = arcs && steps > 1 ? Math.floor(arcs.length / 3 / steps) : 0;
    this.#arcs.visible = count > 0;
    if (!arcs || count === 0) return;
    const [first, end] = chosen ?? [0, count];
    const index: number[] = [];
    for (let arc = first; arc < Math.min(end, count); arc += 1) {
      for (let i = 1; i < steps; i += 1) index.push(arc * steps + i - 1, arc * steps + i);
    }
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(arcs, 3));
    geometry.setIndex(index);
    this.#arcs.geometry.dispose();
    this.#arcs.geometry = geometry;
  }

  setMarks(marks: Marks): void {
    this.#marks = marks;
    const palette = this.#palette;
    this.#points.visible = marks.indices.length > 0;
    if (!palette || marks.indices.length === 0) return;
    const { tangents, numbering, selected, hovered } = marks;
    const isMarked = (i: number) => i === selected || i === hovered;
    // Large ones first, or they would hide the small ones at the same place; what is marked is on top.
    const order = [...marks.indices].sort(
      (a, b) => Number(isMarked(a)) - Number(isMarked(b)) || sizeOf(numbering.of(b)) - sizeOf(numbering.of(a)),
    );
    const position = new Float32Array(3 * order.length);
    const fill = new Float32Array(3 * order.length);
    const ring = new Float32Array(3 * order.length);
    const form = new Float32Array(2 * order.length);
    const colour = new THREE.Color();
    order.forEach((index, i) => {
      const number = numbering.of(index);
      position.set(tangents.subarray(3 * index, 3 * index + 3), 3 * i);
      colour
        .set(colourOf(palette, index === selected, index === hovered, number))
        .toArray(fill, 3 * i);
      ringColour(number, numbering.count, colour).toArray(ring, 3 * i);
      form.set([POINT_SIZE * sizeOf(number) * (isMarked(index) ? 1.3 : 1), shapeOf(number)], 2 * i);
    });
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(position, 3));
    geometry.setAttribute("fill", new THREE.BufferAttribute(fill, 3));
    geometry.setAttribute("ring", new THREE.BufferAttribute(ring, 3));
    geometry.setAttribute("form", new THREE.BufferAttribute(form, 2));
    this.#points.geometry.dispose();
    this.#points.geometry = geometry;
  }
}
