// What the streamline workspace offers on `window.fairform.stream`, for tests only.

import { fingerprint } from "../fingerprint";
import type { StreamSession } from "./session";

export interface StreamHooks {
  /** Plain data: what is selected, and the sizes of what is drawn. */
  state: () => unknown;
  /** Where a tangent is on the page: its point on the sphere, or the tip of its arrow. */
  screenOfTangent: (row: number, column: number, where: "sphere" | "scene") => { x: number; y: number } | null;
  screenOfInitial: (index: number) => { x: number; y: number } | null;
}

export function streamHooks(session: StreamSession): StreamHooks {
  return {
    state: () => ({
      patch: session.patch.peek(),
      place: session.place.peek(),
      hovered: session.hovered.peek(),
      tangent: session.tangent.peek(),
      infos: session.infos.peek(),
      surfaces: session.geometries.peek().map(({ rowCount, columnCount, positions, milliseconds }) => ({
        rowCount,
        columnCount,
        milliseconds,
        last: [...positions.subarray(-3)],
        fingerprint: fingerprint(positions),
      })),
      arcs: session.arcs.peek()?.length ?? null,
      combs: session.combs.peek()?.length ?? null,
      values: session.values.peek()?.map(({ low, high, label }) => ({ low, high, label })) ?? null,
      trouble: session.trouble.peek(),
      camera: session.scene.peek()?.viewport.view ?? null,
    }),
    screenOfTangent: (row, column, where) => session.scene.peek()?.screenOfTangent(row, column, where) ?? null,
    screenOfInitial: (index) => session.scene.peek()?.screenOfInitial(index) ?? null,
  };
}
