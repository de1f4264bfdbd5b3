// The work in the browser's own store, so that nothing is lost to a reload or a crash.

import type { Project } from "../kernel/api";
import type { Document, MeshDocument, Source } from "./document";
import type { Camera } from "./project";
import type { Settings } from "./settings";

export interface Saved {
  document: Document;
  workspace: Project["workspace"];
  camera: Camera | null;
  settings: Settings;
}

/** What is written: as `Saved`, but the bytes of the file, which are large and rarely change, lie apart. */
interface Stored {
  version: 1;
  mesh: (Omit<MeshDocument, "source"> & { name: string }) | null;
  model: unknown;
  workspace: Project["workspace"];
  camera: Camera | null;
  settings: Settings;
}

const STORE = "autosave";

/** A place that outlives the page. */
export class Autosave {
  #database: Promise<IDBDatabase> | null = null;
  #stored: Source | null = null;
  #waiting: { saved: Saved; timer: ReturnType<typeof setTimeout> } | null = null;
  #writing: Promise<void> = Promise.resolve();
  readonly #name: string;
  readonly #delay: number;

  /** Told when the browser refuses, for example because its disk is full. */
  onError: (message: string) => void = () => {};

  constructor(name = "fairform-studio", delay = 400) {
    this.#name = name;
    this.#delay = delay;
  }

  /** Writes soon, and only the last of what comes quickly one after another. */
  save(saved: Saved): void {
    if (this.#waiting) clearTimeout(this.#waiting.timer);
    this.#waiting = { saved, timer: setTimeout(() => void this.flush(), this.#delay) };
  }

  /** Writes now what still waits. */
  flush(): Promise<void> {
    const waiting = this.#waiting;
    this.#waiting = null;
    if (waiting) {
      clearTimeout(waiting.timer);
      this.#writing = this.#writing
        .then(() => this.#write(waiting.saved))
        .catch((error: unknown) => this.onError(String(error)));
    }
    return this.#writing;
  }

  async restore(): Promise<Saved | null> {
    const store = await this.#open("readonly");
    const [stored, bytes] = await Promise.all([
      done<Stored | undefined>(store.get("document")),
      done<Uint8Array | undefined>(store.get("bytes")),
    ]);
    if (stored?.version !== 1) return null;
    let mesh: MeshDocument | null = null;
    if (stored.mesh && bytes) {
      const { name, ...rest } = stored.mesh;
      this.#stored = { name, bytes };
      mesh = { ...rest, source: this.#stored };
    }
    const { model, workspace, camera, settings } = stored;
    return { document: { mesh, model }, workspace, camera, settings };
  }

  async clear(): Promise<void> {
    if (this.#waiting) clearTimeout(this.#waiting.timer);
    this.#waiting = null;
    await this.#writing;
    this.#stored = null;
    await done((await this.#open("readwrite")).clear());
  }

  async #write({ document, workspace, camera, settings }: Saved): Promise<void> {
    const store = await this.#open("readwrite");
    let mesh: Stored["mesh"] = null;
    const requests: Promise<unknown>[] = [];
    if (document.mesh) {
      const { source, ...rest } = document.mesh;
      mesh = { ...rest, name: source.name };
      if (source.bytes !== this.#stored?.bytes) requests.push(done(store.put(source.bytes, "bytes")));
      this.#stored = source;
    }
    const stored: Stored = { version: 1, mesh, model: document.model, workspace, camera, settings };
    requests.push(done(store.put(stored, "document")));
    try {
      await Promise.all(requests);
    } catch (error) {
      this.#stored = null;
      throw error;
    }
  }

  async #open(mode: IDBTransactionMode): Promise<IDBObjectStore> {
    this.#database ??= new Promise((resolve, reject) => {
      const request = indexedDB.open(this.#name, 1);
      request.onupgradeneeded = () => request.result.createObjectStore(STORE);
      request.onsuccess = () => resolve(request.result);
      request.onerror = () => reject(request.error);
    });
    return (await this.#database).transaction(STORE, mode).objectStore(STORE);
  }
}

function done<T>(request: IDBRequest<T>): Promise<T> {
  return new Promise((resolve, reject) => {
    request.onsuccess = () => resolve(request.result);
    request.onerror = () => reject(request.error);
  });
}
