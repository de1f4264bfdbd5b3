// Control tangents as arrows in the scene. Heads differ along a line in shape, size and the colour of a ring, so
// that arrows that coincide can be told apart.

import * as THREE from "three";

/** Colours of tangents, from the style sheet. */
export interface TangentPalette {
  first: string;
  other: string;
  selected: string;
  hover: string;
  ink: string;
}

export function tangentPaletteOf(element: Element): TangentPalette {
  const style = getComputedStyle(element);
  const of = (name: string) => style.getPropertyValue(`--scene-${name}`).trim() || "#888888";
  return {
    first: of("tangent-first"),
    other: of("tangent"),
    selected: of("tangent-selected"),
    hover: of("tangent-hover"),
    ink: of("ink"),
  };
}

export const SHAPES = 3;
/** Sizes repeat after so many tangents; with the shapes, marks repeat only after 12. */
const SIZES = [1, 0.8, 1.2, 0.65];

export function sizeOf(number: number): number {
  return SIZES[number % SIZES.length]!;
}

export function shapeOf(number: number): number {
  return number % SHAPES;
}

/** Numbers of tangents along their lines: by column on streamlines, or by row across them. */
export class Numbering {
  readonly columnCount: number;
  readonly across: boolean;
  /** Tangents of a line. */
  readonly count: number;

  constructor(rowCount: number, columnCount: number, across: boolean) {
    this.columnCount = Math.max(1, columnCount);
    this.across = across;
    this.count = across ? rowCount : columnCount;
  }

  of(index: number): number {
    return this.across ? Math.floor(index / this.columnCount) : index % this.columnCount;
  }

  isSame(other: Numbering): boolean {
    return this.columnCount === other.columnCount && this.across === other.across && this.count === other.count;
  }
}

export function colourOf(palette: TangentPalette, isSelected: boolean, isHovered: boolean, number: number): string {
  if (isSelected) return palette.selected;
  if (isHovered) return palette.hover;
  return number === 0 ? palette.first : palette.other;
}

/** Colour of the ring: once around the hues from the first tangent to the last, leaving out a sixth at the end. */
export function ringColour(number: number, count: number, target = new THREE.Color()): THREE.Color {
  return target.setHSL((0.58 + (0.83 * number) / Math.max(1, count)) % 1, 0.72, 0.5);
}

/** Lit from the eye, one colour per instance, a little nearer than it is so that the surface does not eat it. */
function arrowMaterial(): THREE.ShaderMaterial {
  return new THREE.ShaderMaterial({
    vertexShader: /* glsl */ `
      varying vec3 vNormal;
      varying vec3 vColour;
      void main() {
        vColour = instanceColor;
        vNormal = normalMatrix * (mat3(instanceMatrix) * normal);
        gl_Position = projectionMatrix * modelViewMatrix * instanceMatrix * vec4(position, 1.0);
        gl_Position.z -= 6e-4 * gl_Position.w;
      }`,
    fragmentShader: /* glsl */ `
      varying vec3 vNormal;
      varying vec3 vColour;
      void main() {
        vec3 n = normalize(vNormal);
        float light = 0.52 + 0.42 * max(n.z, 0.0) + 0.16 * max(n.y, 0.0);
        gl_FragColor = vec4(vColour * light, 1.0);
        #include <colorspace_fragment>
      }`,
  });
}

/** Pointed along +y from its base at 0 to its tip at 1. */
function heads(): THREE.BufferGeometry[] {
  const cone = new THREE.ConeGeometry(0.36, 1, 20).translate(0, 0.5, 0);
  const pyramid = new THREE.ConeGeometry(0.42, 1, 4).translate(0, 0.5, 0).toNonIndexed();
  pyramid.computeVertexNormals();
  const diamond = new THREE.OctahedronGeometry(0.5).scale(0.72, 1, 0.72).translate(0, 0.5, 0);
  return [cone, pyramid, diamond];
}

const UP = new THREE.Vector3(0, 1, 0);

export class Arrows {
  readonly root = new THREE.Group();
  readonly #material = arrowMaterial();
  readonly #shaft = new THREE.CylinderGeometry(1, 1, 1, 10).translate(0, 0.5, 0);
  readonly #ring = new THREE.TorusGeometry(1, 0.32, 8, 20).rotateX(Math.PI / 2);
  readonly #heads = heads();
  #shafts: THREE.InstancedMesh | null = null;
  #rings: THREE.InstancedMesh | null = null;
  #tips: THREE.InstancedMesh[] = [];
  #numbering = new Numbering(0, 0, false);
  #count = 0;
  #feet: Float32Array = new Float32Array(0);
  #tangents: Float32Array = new Float32Array(0);
  #length = 1;
  #palette: TangentPalette | null = null;
  #selected = -1;
  #hovered = -1;

  dispose(): void {
    this.#clear();
    this.#material.dispose();
    for (const geometry of [this.#shaft, this.#ring, ...this.#heads]) geometry.dispose();
  }

  get count(): number {
    return this.#count;
  }

  get columnCount(): number {
    return this.#numbering.columnCount;
  }

  /** Length of an arrow in the units of the scene. */
  get length(): number {
    return this.#length;
  }

  set(feet: Float32Array, tangents: Float32Array, numbering: Numbering, length: number): void {
    const count = tangents.length / 3;
    if (count !== this.#count || !numbering.isSame(this.#numbering)) {
      this.#count = count;
      this.#numbering = numbering;
      this.#make();
    }
    this.#feet = feet;
    this.#tangents = tangents;
    this.#length = length;
    this.#place();
  }

  mark(selected: number, hovered: number): void {
    if (selected === this.#selected && hovered === this.#hovered) return;
    this.#selected = selected;
    this.#hovered = hovered;
    this.#place();
    this.#paint();
  }

  setPalette(palette: TangentPalette): void {
    this.#palette = palette;
    this.#paint();
  }

  footOf(index: number, target = new THREE.Vector3()): THREE.Vector3 {
    return target.fromArray(this.#feet, 3 * index);
  }

  tipOf(index: number, target = new THREE.Vector3()): THREE.Vector3 {
    return target.fromArray(this.#tangents, 3 * index).multiplyScalar(this.#length).add(this.footOf(index));
  }

  #clear(): void {
    for (const mesh of [this.#shafts, this.#rings, ...this.#tips]) {
      mesh?.dispose();
      mesh?.removeFromParent();
    }
    this.#shafts = this.#rings = null;
    this.#tips = [];
  }

  #make(): void {
    this.#clear();
    if (this.#count === 0) return;
    const instanced = (geometry: THREE.BufferGeometry, count: number) => {
      const mesh = new THREE.InstancedMesh(geometry, this.#material, Math.max(1, count));
      mesh.instanceColor = new THREE.InstancedBufferAttribute(new Float32Array(3 * Math.max(1, count)), 3);
      mesh.count = count;
      mesh.frustumCulled = false;
      this.root.add(mesh);
      return mesh;
    };
    this.#shafts = instanced(this.#shaft, this.#count);
    this.#rings = instanced(this.#ring, this.#count);
    this.#tips = this.#heads.map((geometry, shape) => {
      let count = 0;
      for (let i = 0; i < this.#count; i += 1) if (shapeOf(this.#numbering.of(i)) === shape) count += 1;
      return instanced(geometry, count);
    });
    this.#paint();
  }

  #place(): void {
    if (!this.#shafts || !this.#rings) return;
    const next = this.#tips.map(() => 0);
    const matrix = new THREE.Matrix4();
    const turn = new THREE.Quaternion();
    const [foot, direction, at, scale] = [0, 0, 0, 0].map(() => new THREE.Vector3()) as Three4;
    for (let i = 0; i < this.#count; i += 1) {
      const number = this.#numbering.of(i);
      const grown = i === this.#selected || i === this.#hovered ? 1.35 : 1;
      const head = this.#length * 0.36 * sizeOf(number) * grown;
      const thick = this.#length * 0.026 * grown;
      this.footOf(i, foot);
      direction.fromArray(this.#tangents, 3 * i);
      turn.setFromUnitVectors(UP, direction);
      const neck = this.#length - head;
      matrix.compose(foot, turn, scale.set(thick, neck, thick));
      this.#shafts.setMatrixAt(i, matrix);
      at.copy(foot).addScaledVector(direction, neck);
      const shape = shapeOf(number);
      matrix.compose(at, turn, scale.setScalar(head));
      this.#tips[shape]!.setMatrixAt(next[shape]!++, matrix);
      at.copy(foot).addScaledVector(direction, neck - head * 0.12);
      matrix.compose(at, turn, scale.setScalar(head * 0.24));
      this.#rings.setMatrixAt(i, matrix);
    }
    for (const mesh of [this.#shafts, this.#rings, ...this.#tips]) mesh.instanceMatrix.needsUpdate = true;
  }

  #paint(): void {
    const palette = this.#palette;
    if (!palette || !this.#shafts || !this.#rings) return;
    const next = this.#tips.map(() => 0);
    const colour = new THREE.Color();
    for (let i = 0; i < this.#count; i += 1) {
      const number = this.#numbering.of(i);
      colour.set(colourOf(palette, i === this.#selected, i === this.#hovered, number));
      this.#shafts.setColorAt(i, colour);
      const shape = shapeOf(number);
      this.#tips[shape]!.setColorAt(next[shape]!++, colour);
      this.#rings.setColorAt(i, ringColour(number, this.#numbering.count, colour));
    }
    for (const mesh of [this.#shafts, this.#rings, ...this.#tips]) {
      if (mesh.instanceColor) mesh.instanceColor.needsUpdate = true;
    }
  }
}

type Three4 = [THREE.Vector3, THREE.Vector3, THREE.Vector3, THREE.Vector3];
