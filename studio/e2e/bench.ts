// How long the page takes, with the real kernel in a real browser: `npm run bench`. It wants a quiet machine.
//
// The times of the kernel are those that a worker measures around its own work; the others go from the press of
// a button to the answer being there, drawn by a processor instead of a graphics card.

import { readdirSync, readFileSync } from "node:fs";
import { join } from "node:path";
import { fileURLToPath } from "node:url";
import { gzipSync } from "node:zlib";

import { data, fairform, test, type Place, type Studio } from "./harness";

const rows: [string, string, string][] = [];

const ms = (time: number): string => `${time.toFixed(time < 10 ? 2 : 0)} ms`;

/** What a first visit loads, compressed as a web server would. */
function firstLoad(): void {
  const dist = fileURLToPath(new URL("../dist", import.meta.url));
  const files = ["index.html", ...readdirSync(join(dist, "assets")).map((name) => join("assets", name))];
  let sum = 0;
  for (const name of files) {
    const bytes = readFileSync(join(dist, name));
    const small = gzipSync(bytes, { level: 9 }).length;
    sum += small;
    const kind = name.replace(/^assets\//, "").replace(/-[\w-]{8}\./, ".");
    const plain = `${(bytes.length / 1000).toFixed(0)} kB plain`;
    rows.push([`first load: ${kind}`, `${(small / 1000).toFixed(1)} kB`, plain]);
  }
  rows.push(["first load", `${(sum / 1000).toFixed(0)} kB`, "gzip -9; as served by the command it is not compressed"]);
}

/** Opens a mesh of about 35 000 vertices and fits it. */
async function openAndFit(studio: Studio): Promise<void> {
  const path = join(studio.folder, "large.ply");
  fairform(["refine", data("meshes/tri_closed/torus_2k.obj"), "-o", path, "--levels", "2", "--quiet"]);
  const start = performance.now();
  const { info, fit, milliseconds, surface } = await studio.openFile(path);
  const whole = performance.now() - start;
  const size = `${info!.vertexCount.toLocaleString("en")} vertices`;
  rows.push(["open, fit and draw", ms(whole), `${size}, ${surface!.triangles.toLocaleString("en")} triangles drawn`]);
  rows.push(["open", ms(milliseconds["open"]!.last), "in the worker, with the way there and back"]);
  rows.push(["fit", ms(fit!.milliseconds), `kernel; ${fit!.history.at(-1)!.iteration} updates to 1e-6, one thread`]);
}

/** Drags a vertex of a mesh of about 5000 vertices, drawn after two steps. */
async function dragVertex(studio: Studio): Promise<void> {
  await studio.openFile(data("meshes/tri_closed/homer.off"));
  await studio.type("levels-number", "2");
  await studio.settled();
  await studio.control("tool.vertices").click();
  const v = await studio.vertexNear({ x: 520, y: 400 });
  const from = await studio.vertex(v);
  await studio.page.mouse.click(from.x, from.y);
  await studio.settled();
  await studio.drag(from, { x: from.x + 40, y: from.y + 20 }, 40, () => studio.frame());
  const { info, surface, milliseconds } = await studio.settled();
  const [vertices, points] = [info!.vertexCount, surface!.points].map((x) => x.toLocaleString("en"));
  const size = `${vertices} vertices, ${points} points drawn`;
  reportDrag("vertex", milliseconds, size);
}

/** Drags a tangent of the car, refined four times. */
async function dragTangent(studio: Studio): Promise<void> {
  await studio.openSample("streamline/car.streamline.json");
  await studio.type("depth-number", "4");
  await studio.settled();
  const { place } = await studio.ask<{ place: { row: number; column: number } }>("stream.state()");
  const from = await studio.ask<Place>(`stream.screenOfTangent(${place.row}, ${place.column}, "sphere")`);
  await studio.drag(from, { x: from.x + 40, y: from.y + 30 }, 40, () => studio.frame());
  const { milliseconds } = await studio.settled();
  const { surfaces } = await studio.ask<{ surfaces: { rowCount: number; columnCount: number }[] }>("stream.state()");
  const [{ rowCount, columnCount }] = surfaces as [(typeof surfaces)[0]];
  reportDrag("tangent", milliseconds, `${rowCount} × ${columnCount} points`);
}

type Times = Awaited<ReturnType<Studio["state"]>>["milliseconds"];

function reportDrag(what: string, milliseconds: Times, size: string): void {
  const { kernel, drag } = milliseconds;
  rows.push([`${what} drag`, ms(kernel!.median), `kernel, median of ${kernel!.count}; ${size}`]);
  rows.push([`${what} drag, answered`, ms(drag!.median), "with the way to the worker and back"]);
}

test("figures", async ({ open }) => {
  firstLoad();
  for (const measure of [openAndFit, dragVertex, dragTangent]) await measure(await open());
  const widths = [0, 1].map((i) => Math.max(...rows.map((row) => row[i]!.length)));
  const line = ([what, value, how]: (typeof rows)[0]) =>
    `| ${what.padEnd(widths[0]!)} | ${value.padStart(widths[1]!)} | ${how} |`;
  console.log(`| What | | |\n|---|--:|---|\n${rows.map(line).join("\n")}`);
});
