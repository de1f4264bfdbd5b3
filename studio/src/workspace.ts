// The workspaces that share the page: each brings a view, actions and the files that it opens.

import { signal } from "@preact/signals";
import type { ComponentType } from "preact";
import type { Action } from "./actions";
import type { Project } from "./kernel/api";
import type { Source } from "./state/document";
import type { Camera } from "./state/project";
import type { Studio } from "./studio";

export type WorkspaceId = Project["workspace"];

export interface Workspace {
  id: WorkspaceId;
  title: string;
  /** Everything between the bar at the top and the status line. Mounted while the workspace is open. */
  View: ComponentType<{ studio: Studio }>;
  /** Registered while the workspace is open. */
  actions: readonly Action[];
  /** Whether a file of this name is one of its own; the first workspace that says so opens it. */
  opens: (name: string) => boolean;
  /** Opens a file of its own; rejects with a `Problem`. */
  open: (source: Source) => Promise<void>;
  /** What the dialog offers, like `.obj,.ply`. */
  accept: string;
  /** Where its camera is, for project files; null if it was not open yet. */
  camera: () => Camera | null;
  setCamera: (camera: Camera) => void;
}

export const current = signal<WorkspaceId>("interpolation");
