import { fetchFile } from "./files";
import type { Triple } from "./kernel/api";
import type { Source } from "./state/document";

export interface Sample {
  file: string;
  title: string;
  says: string;
  /** Where it looks best from. */
  look?: Triple;
  up?: "y" | "z";
}

const COW: Triple = [-0.8, 0.3, -0.75];

/** Meshes to begin with; origins and licences are in `public/samples/README.md`. */
export const SAMPLES: readonly Sample[] = [
  { file: "spot.obj", title: "Spot", says: "A cow of 372 triangles, by Keenan Crane", look: COW },
  { file: "spot-quads.obj", title: "Spot, quads", says: "The same in quadrilaterals", look: COW },
  { file: "penguin.obj", title: "Penguin", says: "3- to 5-gons, by Oded Stein (CC BY 4.0)" },
  { file: "cube.obj", title: "Cube", says: "Six faces in three groups" },
  { file: "torus.obj", title: "Torus", says: "32 regular quadrilaterals" },
  { file: "pawn.obj", title: "Pawn", says: "Open below: a boundary in red", up: "z" },
  { file: "fandisk.off", title: "Fan disk", says: "A machine part, for creases" },
  { file: "knot.obj", title: "Knot", says: "1440 regular quadrilaterals" },
];

/** Models of streamlines, our own. */
export const MODELS: readonly Sample[] = [
  { file: "streamline/car.streamline.json", title: "Car", says: "6 × 9 tangents, Kobbelt", look: [-0.6, 0.4, 0.7] },
  { file: "streamline/saddle.streamline.json", title: "Saddle", says: "7 × 7, Catmull–Clark, from its middle" },
  { file: "streamline/duct.streamline.json", title: "Duct", says: "17 × 10, closed around" },
  { file: "streamline/hull.streamline.json", title: "Hull", says: "7 × 9; begins at the stem", look: [-0.8, 0.2, 0.55] },
  { file: "streamline/chair.streamline.json", title: "Chair", says: "7 × 12, Doo–Sabin, seat and back in one" },
  { file: "streamline/bottle.streamline.json", title: "Bottle", says: "Two halves, joined smoothly; lengths as L(t)", look: [-0.9, 0.35, 0.33] },
];

export async function openSample({ file, look, up = "y" }: Sample): Promise<Source> {
  const source = await fetchFile(`./samples/${file}`, file.split("/").at(-1)!);
  return look ? { ...source, look, up } : { ...source, up };
}
