// Documents as `*.fairform.json` and back. The kernel checks and writes the JSON; this only translates.

import type { Design, Project } from "../kernel/api";
import type { Document } from "./document";
import { indicesOf, NONE } from "./indices";
import type { Settings } from "./settings";

export type Camera = NonNullable<Project["camera"]>;

export const PROJECT_SUFFIX = ".fairform.json";

/** What the studio keeps in the field `studio`, which the command passes on as it is. */
interface StudioPart {
  compare?: Design | null;
  edges?: number[];
  settings?: Partial<Settings>;
}

export function toBase64(bytes: Uint8Array): string {
  // In pieces, because a call takes only so many arguments.
  let text = "";
  for (let i = 0; i < bytes.length; i += 0x8000) {
    text += String.fromCharCode(...bytes.subarray(i, i + 0x8000));
  }
  return btoa(text);
}

export function fromBase64(text: string): Uint8Array {
  const plain = atob(text);
  const bytes = new Uint8Array(plain.length);
  for (let i = 0; i < plain.length; i += 1) bytes[i] = plain.charCodeAt(i);
  return bytes;
}

export function toProject(
  document: Document,
  workspace: Project["workspace"],
  camera: Camera | null,
  settings: Settings,
): Project {
  const { mesh, model } = document;
  const studio: StudioPart = {
    compare: mesh?.compare ?? null,
    edges: [...(mesh?.edges ?? NONE)],
    settings,
  };
  return {
    fairform: 1,
    workspace,
    mesh: mesh && {
      name: mesh.source.name,
      bytes: toBase64(mesh.source.bytes),
      repairs: [...mesh.repairs],
      design: mesh.design,
      fineness: mesh.fineness,
      faces: [...mesh.faces],
      vertices: [...mesh.vertices],
    },
    model: model ?? null,
    camera,
    studio,
  };
}

export interface Opened {
  document: Document;
  workspace: Project["workspace"];
  camera: Camera | null;
  settings: Partial<Settings>;
}

export function fromProject(project: Project): Opened {
  const studio = (isObject(project.studio) ? project.studio : {}) as StudioPart;
  const { mesh } = project;
  return {
    document: {
      mesh: mesh && {
        source: { name: mesh.name, bytes: fromBase64(mesh.bytes) },
        repairs: mesh.repairs,
        design: mesh.design,
        compare: studio.compare ?? null,
        fineness: mesh.fineness,
        faces: indicesOf(mesh.faces),
        vertices: indicesOf(mesh.vertices),
        edges: indicesOf(Array.isArray(studio.edges) ? studio.edges : []),
      },
      model: project.model,
    },
    workspace: project.workspace,
    camera: project.camera,
    settings: isObject(studio.settings) ? studio.settings : {},
  };
}

export function isProjectName(name: string): boolean {
  return name.toLowerCase().endsWith(PROJECT_SUFFIX);
}

function isObject(value: unknown): value is object {
  return typeof value === "object" && value !== null;
}
