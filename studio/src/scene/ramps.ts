// Numbers as colours: the same two maps as the command draws with, in the same even steps for the eye.

import type { Colouring } from "../kernel/api";

/** Viridis, by van der Walt, Smith and Firing (CC0): for sizes. */
const VIRIDIS =
  "440154 481769 472a7a 433d84 3d4e8a 355e8d 2e6d8e 297b8e 23898e 1f978b 21a585 2eb37c 46c06f 65cb5e 89d548 b0dd2f d8e219 fde725";

/** Moreland's map from blue over white to red: for what has a sign. */
const COOL_WARM =
  "3b4cc0 445acc 4e68d7 5775e1 6282ea 6c8ef1 779af7 82a5fb 8db0fe 98b9ff a3c2ff aec9fd b8d0f9 c2d5f4 ccd9ee d5dbe6 dddddd e5d8d1 ecd3c5 f1ccb9 f5c4ad f7bba0 f7b194 f7a687 f49a7b f18d6f ec7f63 e57058 de604d d55042 cb3d38 c0282f b40426";

export type Ramp = readonly (readonly [number, number, number])[];

const parse = (text: string): Ramp =>
  text.split(" ").map((hex) => {
    const n = Number.parseInt(hex, 16);
    return [n >> 16, (n >> 8) & 255, n & 255] as const;
  });

export const RAMPS = { sequential: parse(VIRIDIS), diverging: parse(COOL_WARM) } as const;

export function isDiverging(colouring: Colouring): boolean {
  return colouring === "gaussian" || colouring === "mean";
}

/** The ramp in `count` texels of RGBA. */
export function texels(ramp: Ramp, count = 256): Uint8Array {
  const data = new Uint8Array(4 * count);
  for (let i = 0; i < count; i += 1) {
    const at = (i / (count - 1)) * (ramp.length - 1);
    const k = Math.min(Math.floor(at), ramp.length - 2);
    for (let c = 0; c < 3; c += 1) {
      const [a, b] = [ramp[k]![c]!, ramp[k + 1]![c]!];
      data[4 * i + c] = Math.round(a + (at - k) * (b - a));
    }
    data[4 * i + 3] = 255;
  }
  return data;
}

/** The ramp as a CSS gradient from left to right. */
export function gradient(ramp: Ramp): string {
  return `linear-gradient(to right, ${ramp.map((c) => `rgb(${c.join(" ")})`).join(", ")})`;
}
