// How surfaces, lines and points look. Shading works on the normals that the kernel gives.

import * as THREE from "three";
import { RAMPS, texels } from "./ramps";

function rampTexture(name: keyof typeof RAMPS): THREE.DataTexture {
  const texture = new THREE.DataTexture(texels(RAMPS[name]), 256, 1);
  texture.colorSpace = THREE.SRGBColorSpace;
  texture.magFilter = texture.minFilter = THREE.LinearFilter;
  texture.needsUpdate = true;
  return texture;
}

export const RAMP_TEXTURES = {
  sequential: rampTexture("sequential"),
  diverging: rampTexture("diverging"),
};

/** The direction that points up, shared by all materials. */
export const UP = { value: new THREE.Vector3(0, 1, 0) };

export const FINISH = { shaded: 0, wire: 0, zebra: 1, reflection: 2 } as const;

/** Three lamps that turn with the camera above a sky that does not, a soft highlight, a sheen at the rim. */
export function surfaceMaterial(): THREE.ShaderMaterial {
  return new THREE.ShaderMaterial({
    side: THREE.DoubleSide,
    // Lines and points on the surface win over it.
    polygonOffset: true,
    polygonOffsetFactor: 1,
    polygonOffsetUnits: 1,
    uniforms: {
      finish: { value: FINISH.shaded },
      flatly: { value: false },
      coloured: { value: false },
      ramp: { value: RAMP_TEXTURES.sequential },
      low: { value: 0 },
      high: { value: 1 },
      front: { value: new THREE.Color() },
      back: { value: new THREE.Color() },
      opacity: { value: 1 },
      upward: UP,
    },
    vertexShader: /* glsl */ `
      attribute float value;
      varying vec3 vNormal;
      varying vec3 vPlace;
      varying float vValue;
      void main() {
        vec4 place = modelViewMatrix * vec4(position, 1.0);
        vPlace = place.xyz;
        vNormal = normalMatrix * normal;
        vValue = value;
        gl_Position = projectionMatrix * place;
      }`,
    fragmentShader: /* glsl */ `
      uniform int finish;
      uniform bool flatly;
      uniform bool coloured;
      uniform sampler2D ramp;
      uniform float low;
      uniform float high;
      uniform vec3 front;
      uniform vec3 back;
      uniform float opacity;
      uniform vec3 upward;
      varying vec3 vNormal;
      varying vec3 vPlace;
      varying float vValue;

      // Dark and light bands of equal width; edges as wide as a pixel.
      float bands(float phase) {
        float s = sin(3.14159265 * phase);
        float w = max(fwidth(phase) * 3.14159265, 1e-4);
        return smoothstep(-w, w, s);
      }

      void main() {
        vec3 eye = normalize(-vPlace);
        vec3 n = normalize(cross(dFdx(vPlace), dFdy(vPlace)));
        if (!flatly && dot(vNormal, vNormal) > 0.0) {
          n = normalize(vNormal);
          if (!gl_FrontFacing) n = -n;
        }
        vec3 up = (viewMatrix * vec4(upward, 0.0)).xyz;
        vec3 albedo = gl_FrontFacing ? front : back;
        float gloss = 1.0;
        if (coloured) {
          float t = (vValue - low) / max(high - low, 1e-30);
          albedo = texture2D(ramp, vec2((clamp(t, 0.0, 1.0) * 255.0 + 0.5) / 256.0, 0.5)).rgb;
          gloss = 0.25;
        }

        const vec3 key = vec3(-0.40, 0.62, 0.675);
        const vec3 fill = vec3(0.78, 0.10, 0.617);
        const vec3 rim = vec3(0.30, 0.55, -0.779);
        float sky = 0.5 + 0.5 * dot(n, up);
        vec3 light = mix(vec3(0.20, 0.19, 0.20), vec3(0.50, 0.53, 0.58), sky);
        light += vec3(0.66, 0.63, 0.58) * max(dot(n, key), 0.0);
        light += vec3(0.13, 0.15, 0.19) * max(dot(n, fill), 0.0);
        light += vec3(0.30, 0.32, 0.36) * max(dot(n, rim), 0.0);
        vec3 h = normalize(eye + key);
        float grazing = 1.0 - clamp(dot(n, eye), 0.0, 1.0);
        float highlight = 0.20 * pow(max(dot(n, h), 0.0), 42.0) + 0.05 * pow(max(dot(n, h), 0.0), 8.0);
        float sheen = 0.26 * grazing * grazing * grazing * (0.35 + 0.65 * sky);
        // Colours that mean something stay readable beside their legend.
        if (coloured) light = mix(light, vec3(1.0), 0.45);
        vec3 colour = albedo * light + gloss * (highlight + sheen);

        if (finish == 1) {
          vec3 r = normalize((vec4(reflect(-eye, n), 0.0) * viewMatrix).xyz);
          float band = bands(acos(clamp(dot(r, upward), -1.0, 1.0)) / 3.14159265 * 24.0);
          vec3 own = coloured ? albedo : mix(vec3(0.95), albedo, 0.25);
          colour = own * mix(0.03, 1.0, band) * mix(light, vec3(1.0), 0.55);
        } else if (finish == 2) {
          vec3 r = normalize((vec4(reflect(-eye, n), 0.0) * viewMatrix).xyz);
          // Lamps along x, side by side.
          float around = atan(dot(r, upward), dot(r, cross(vec3(1.0, 0.0, 0.0), upward))) / 3.14159265 * 10.0;
          float d = abs(fract(around) - 0.5);
          // The derivative jumps where the angle starts anew; the smaller one is right there.
          float w = min(fwidth(around), fwidth(fract(around + 0.5))) + 1e-4;
          float lamp = 1.0 - smoothstep(0.13 - w, 0.13 + w, d);
          colour = albedo * light * 0.16 + 0.88 * lamp + 0.10 * grazing;
        }
        gl_FragColor = vec4(colour, opacity);
        #include <colorspace_fragment>
      }`,
  });
}

/** One colour over faces that are marked, as if a lamp of that colour shone on them. */
export function overlayMaterial(opacity: number): THREE.ShaderMaterial {
  return new THREE.ShaderMaterial({
    side: THREE.DoubleSide,
    transparent: true,
    depthWrite: false,
    polygonOffset: true,
    polygonOffsetFactor: 0.5,
    polygonOffsetUnits: 0.5,
    uniforms: { colour: { value: new THREE.Color() }, opacity: { value: opacity } },
    vertexShader: /* glsl */ `
      varying vec3 vNormal;
      void main() {
        vNormal = normalMatrix * normal;
        gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
      }`,
    fragmentShader: /* glsl */ `
      uniform vec3 colour;
      uniform float opacity;
      varying vec3 vNormal;
      void main() {
        float facing = length(vNormal) > 0.0 ? abs(normalize(vNormal).z) : 1.0;
        gl_FragColor = vec4(colour * (0.55 + 0.45 * facing), opacity);
        #include <colorspace_fragment>
      }`,
  });
}

/** Lines one pixel wide, drawn a little nearer than they are so that the surface below does not eat them. */
export function lineMaterial(opacity: number, bias = 1e-4): THREE.ShaderMaterial {
  return new THREE.ShaderMaterial({
    transparent: true,
    depthWrite: false,
    uniforms: {
      colour: { value: new THREE.Color() },
      opacity: { value: opacity },
      bias: { value: bias },
    },
    vertexShader: /* glsl */ `
      uniform float bias;
      void main() {
        gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
        gl_Position.z -= bias * gl_Position.w;
      }`,
    fragmentShader: /* glsl */ `
      uniform vec3 colour;
      uniform float opacity;
      void main() {
        gl_FragColor = vec4(colour, opacity);
        #include <colorspace_fragment>
      }`,
  });
}

/** Round points of a size in pixels with a thin ring around them. */
export function pointMaterial(size: number, bias = 4e-4): THREE.ShaderMaterial {
  return new THREE.ShaderMaterial({
    transparent: true,
    uniforms: {
      colour: { value: new THREE.Color() },
      ring: { value: new THREE.Color() },
      size: { value: size },
      pixels: { value: 1 },
      bias: { value: bias },
    },
    vertexShader: /* glsl */ `
      uniform float size;
      uniform float pixels;
      uniform float bias;
      void main() {
        gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
        gl_Position.z -= bias * gl_Position.w;
        gl_PointSize = size * pixels;
      }`,
    fragmentShader: /* glsl */ `
      uniform vec3 colour;
      uniform vec3 ring;
      uniform float size;
      uniform float pixels;
      void main() {
        float r = length(gl_PointCoord - 0.5) * size * pixels;
        float edge = 0.5 * size * pixels;
        if (r > edge) discard;
        float inside = 1.0 - smoothstep(edge - 1.5 * pixels - 0.7, edge - 1.5 * pixels, r);
        gl_FragColor = vec4(mix(ring, colour, inside), 1.0 - smoothstep(edge - 0.8, edge, r));
        #include <colorspace_fragment>
      }`,
  });
}
