// Files that come in and go out through the browser.

import type { Source } from "./state/document";

/** Shows the browser's dialog. Resolves with null if nothing was chosen. */
export function askForFile(accept: string): Promise<Source | null> {
  return new Promise((resolve) => {
    const input = document.createElement("input");
    input.type = "file";
    input.accept = accept;
    input.addEventListener("change", () => {
      const file = input.files?.[0];
      resolve(file ? readFile(file) : null);
    });
    input.addEventListener("cancel", () => resolve(null));
    input.click();
  });
}

export async function readFile(file: File): Promise<Source> {
  return { name: file.name, bytes: new Uint8Array(await file.arrayBuffer()) };
}

export async function fetchFile(address: string, name: string): Promise<Source> {
  const response = await fetch(address);
  if (!response.ok) throw new Error(`${name} cannot be loaded: ${response.status} ${response.statusText}`);
  return { name, bytes: new Uint8Array(await response.arrayBuffer()) };
}

/** Gives a file to the person, as the browser does with downloads. */
export function giveFile(name: string, content: Uint8Array | Blob): void {
  const blob = content instanceof Blob ? content : new Blob([content.slice()]);
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  // The download has begun by then.
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}

/** `dir/bunny.obj` → `bunny`. */
export function stem(name: string): string {
  const base = name.split(/[/\\]/).at(-1)!;
  const ending = /\.(fairform|streamline)\.json$/i.test(base) ? /\.\w+\.json$/ : /\.[A-Za-z]+(\.gz)?$/;
  return base.replace(ending, "") || base;
}
