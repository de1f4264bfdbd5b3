// The studio as a whole: one document with its history, the kernel, the workspaces, files and autosave.

import { effect, signal } from "@preact/signals";
import { register, type Action } from "./actions";
import { announce, dismiss, tell } from "./announce";
import { askForFile, giveFile, stem } from "./files";
import type { Kernel, Repair } from "./kernel/api";
import { problemOf, sentence } from "./kernel/problem";
import { panelOpen } from "./perf";
import { Autosave } from "./state/autosave";
import { EMPTY, type Document, type Source } from "./state/document";
import { History } from "./state/history";
import { fromProject, isProjectName, PROJECT_SUFFIX, toProject } from "./state/project";
import { adopt, change, settings, type Theme } from "./state/settings";
import { nameOf } from "./stream/model";
import { applyTheme, watchSystem } from "./theme";
import { current, type Workspace, type WorkspaceId } from "./workspace";

export class Studio {
  readonly history = new History<Document>(EMPTY);
  readonly autosave: Autosave;
  readonly kernel: Kernel;
  /** A kernel of one's own, for what runs beside the first. */
  readonly newKernel: () => Kernel;
  readonly help = signal(false);
  readonly gallery = signal(false);
  /** Samples to choose from below the first one, until something is opened. */
  readonly welcome = signal(false);
  /** Increases whenever a camera came to rest, so that it is saved. */
  readonly cameraMoved = signal(0);

  #workspaces: readonly Workspace[] = [];
  #unregister: () => void = () => {};

  constructor(newKernel: () => Kernel, autosave = new Autosave()) {
    this.newKernel = newKernel;
    this.kernel = newKernel();
    this.autosave = autosave;
    autosave.onError = (error) => announce(`Your work could not be kept in the browser: ${error}`);
  }

  get document(): Document {
    return this.history.present.value;
  }

  /** What the open workspace shows, for the bar at the top and names of files. */
  get title(): string {
    const { mesh, model } = this.document;
    if (current.value === "streamline") return model === null ? "" : nameOf(model);
    return mesh?.source.name ?? "";
  }

  get workspaces(): readonly Workspace[] {
    return this.#workspaces;
  }

  get workspace(): Workspace {
    return this.#workspaces.find((w) => w.id === current.value) ?? this.#workspaces[0]!;
  }

  /** Brings the workspaces in and begins to save. */
  start(workspaces: readonly Workspace[]): void {
    this.#workspaces = workspaces;
    register(this.actions());
    effect(() => {
      const { actions } = this.workspace;
      this.#unregister();
      this.#unregister = register(actions);
    });
    effect(() => {
      // The first change of one's own ends the welcome, as opening something does.
      const isBeginning = this.history.undoLabel === null && current.value === "interpolation";
      if (!isBeginning) this.welcome.value = false;
    });
    effect(() => applyTheme(settings.value.theme));
    watchSystem(() => settings.value.theme);
    effect(() => {
      void this.cameraMoved.value;
      const document = this.document;
      if (document.mesh === null && document.model === null) return;
      this.autosave.save({
        document,
        workspace: current.value,
        camera: this.workspace.camera(),
        settings: settings.value,
      });
    });
    addEventListener("visibilitychange", () => void this.autosave.flush());
    addEventListener("pagehide", () => void this.autosave.flush());
  }

  enter(id: WorkspaceId): void {
    if (current.value === id) return;
    current.value = id;
    announce(this.workspace.title);
  }

  /** Takes up the work that an earlier page left; says whether there was any. */
  async restore(): Promise<boolean> {
    const saved = await this.autosave.restore();
    if (!saved || (saved.document.mesh === null && saved.document.model === null)) return false;
    adopt(saved.settings);
    change({ theme: saved.settings.theme });
    this.enter(saved.workspace);
    this.history.reset(saved.document);
    if (saved.camera) this.workspace.setCamera(saved.camera);
    announce("Your work was restored");
    return true;
  }

  /** Opens a project, a model or a mesh; whatever is wrong with it is told, with the repairs on offer. */
  async open(source: Source): Promise<void> {
    dismiss();
    this.gallery.value = false;
    this.welcome.value = false;
    try {
      if (isProjectName(source.name)) {
        await this.#openProject(source);
      } else {
        const workspace = this.#workspaces.find((w) => w.opens(source.name)) ?? this.#workspaces[0]!;
        this.enter(workspace.id);
        await workspace.open(source);
      }
    } catch (error) {
      this.explain(`${source.name} cannot be opened`, error);
    }
  }

  /** Shows what went wrong, with what helps; `repair` runs the steps that the kernel offers. */
  explain(title: string, error: unknown, repair?: (repairs: Repair[]) => void): void {
    const problem = problemOf(error);
    if (problem.cancelled) return;
    const choices =
      repair && problem.repairs.length > 0
        ? [
            ...(problem.repairs.length > 1
              ? [{ label: `Repair: all ${problem.repairs.length} steps`, run: () => repair(problem.repairs) }]
              : []),
            ...problem.repairs.map((step) => ({ label: `Repair: ${step.says}`, run: () => repair([step]) })),
          ]
        : [];
    tell({
      kind: "error",
      title,
      text: problem.message,
      help: problem.help && sentence(problem.help),
      choices,
    });
  }

  async #openProject(source: Source): Promise<void> {
    const opened = fromProject(await this.kernel.readProject(source.bytes.slice()));
    adopt(opened.settings);
    this.enter(opened.workspace);
    this.history.commit(opened.document, `Open ${source.name}`);
    if (opened.camera) this.workspace.setCamera(opened.camera);
    announce(`${source.name} is open`);
  }

  async saveProject(): Promise<void> {
    const project = toProject(this.document, current.value, this.workspace.camera(), settings.value);
    const name = stem(this.title || "design") + PROJECT_SUFFIX;
    await this.give("The project cannot be saved", name, () => this.kernel.writeProject(project));
  }

  /** Makes a file and gives it to the person, or says what went wrong. */
  async give(trouble: string, name: string, make: () => Promise<Uint8Array | Blob>): Promise<void> {
    try {
      giveFile(name, await make());
      announce(`${name} is saved`);
    } catch (error) {
      this.explain(trouble, error);
    }
  }

  async openDialog(): Promise<void> {
    const accept = [PROJECT_SUFFIX, ".json", ...this.#workspaces.map((w) => w.accept)].join(",");
    const source = await askForFile(accept);
    if (source) await this.open(source);
  }

  undo(): void {
    const label = this.history.undo();
    announce(label ? `Undone: ${label}` : "Nothing to undo");
  }

  redo(): void {
    const label = this.history.redo();
    announce(label ? `Redone: ${label}` : "Nothing to redo");
  }

  /** What can be done in every workspace. */
  actions(): Action[] {
    const theme = (name: Theme, label: string): Action => ({
      name: `theme.${name}`,
      label,
      run: () => change({ theme: name }),
      on: () => settings.value.theme === name,
    });
    return [
      { name: "file.open", label: "Open a file…", keys: ["Mod+O"], run: () => void this.openDialog() },
      { name: "file.gallery", label: "Samples", keys: ["G"], run: () => void (this.gallery.value = !this.gallery.value) },
      { name: "file.save", label: "Save the project", keys: ["Mod+S"], run: () => void this.saveProject() },
      {
        name: "edit.undo",
        label: "Undo",
        keys: ["Mod+Z"],
        run: () => this.undo(),
        detail: () => this.history.undoLabel,
        enabled: () => this.history.undoLabel !== null,
      },
      {
        name: "edit.redo",
        label: "Redo",
        keys: ["Mod+Shift+Z", "Mod+Y"],
        run: () => this.redo(),
        detail: () => this.history.redoLabel,
        enabled: () => this.history.redoLabel !== null,
      },
      ...this.#workspaces.map(
        (w, i): Action => ({
          name: `workspace.${w.id}`,
          label: w.title,
          keys: [`Alt+${i + 1}`],
          run: () => this.enter(w.id),
          on: () => current.value === w.id,
        }),
      ),
      theme("auto", "Look as the system"),
      theme("light", "Light look"),
      theme("dark", "Dark look"),
      theme("contrast", "High contrast"),
      {
        name: "help.commands",
        label: "All commands and keys",
        keys: ["?", "F1", "Mod+K"],
        run: () => void (this.help.value = !this.help.value),
      },
      {
        name: "help.performance",
        label: "How long things take",
        keys: ["Shift+P"],
        run: () => void (panelOpen.value = !panelOpen.value),
        on: () => panelOpen.value,
      },
    ];
  }
}
