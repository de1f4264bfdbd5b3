// The page as `fairform studio FILE` serves it: a mark in the page, and the file to begin with.

import type { Source } from "./state/document";

export function isServed(page: Pick<Document, "querySelector"> = document): boolean {
  return page.querySelector('meta[name="fairform-served"][content="yes"]') !== null;
}

/** The file that the server was started with, or null if with none. */
export async function servedFile(get: typeof fetch = fetch): Promise<Source | null> {
  const response = await get("./api/file");
  if (response.status === 204 || response.status === 404) return null;
  if (!response.ok) throw new Error(`the server does not give its file: ${response.status} ${response.statusText}`);
  const name = decodeURIComponent(response.headers.get("X-File-Name") ?? "mesh");
  return { name, bytes: new Uint8Array(await response.arrayBuffer()) };
}
