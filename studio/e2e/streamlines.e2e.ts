// Surfaces from tangents: dragged on the sphere, set by their components, inserted, saved.

import { readFileSync, writeFileSync } from "node:fs";
import { basename, join } from "node:path";

import type { PatchInfo, Triple } from "../src/kernel/api";
import { data, expect, fairform, gap, test, vertices, type Place, type Studio } from "./harness";

const CAR = "streamline/car.streamline.json";

interface StreamState {
  place: { row: number; column: number };
  tangent: Triple;
  infos: PatchInfo[];
  surfaces: { rowCount: number; columnCount: number; fingerprint: number }[];
  combs: number | null;
  values: { low: number; high: number; label: string }[] | null;
  trouble: unknown;
}

async function stream(studio: Studio): Promise<StreamState> {
  await studio.settled();
  return studio.ask("stream.state()");
}

function length(v: Triple): number {
  return Math.hypot(...v);
}

test("the car opens from the samples", async ({ studio }) => {
  const { workspace } = await studio.openSample(CAR);
  expect(workspace).toBe("streamline");
  expect(await studio.text("tangent-count")).toBe("6 × 9");
  const { surfaces, trouble } = await stream(studio);
  expect(trouble).toBeNull();
  const [surface] = surfaces;
  expect(await studio.text("point-count")).toBe(`${surface!.rowCount} × ${surface!.columnCount}`);
});

test("a tangent is dragged on the sphere, and the surface follows", async ({ studio }) => {
  await studio.openSample(CAR);
  const before = await stream(studio);
  const { row, column } = before.place;
  const from = await studio.ask<Place>(`stream.screenOfTangent(${row}, ${column}, "sphere")`);
  const to = { x: from.x + 24, y: from.y - 18 };
  let last = before.surfaces[0]!.fingerprint;
  let follows = 0;
  await studio.drag(from, to, 4, async () => {
    const ask = () => studio.ask<StreamState>("stream.state()");
    const now = await studio.until("the surface follows", ask, (s) => s.surfaces[0]?.fingerprint !== last);
    last = now.surfaces[0]!.fingerprint;
    expect(length(now.tangent)).toBeCloseTo(1, 12);
    follows += 1;
  });
  expect(follows).toBe(4);
  const after = await stream(studio);
  expect(after.place).toEqual(before.place);
  expect(length(after.tangent)).toBeCloseTo(1, 12);
  const at = await studio.ask<Place>(`stream.screenOfTangent(${row}, ${column}, "sphere")`);
  expect(Math.hypot(at.x - to.x, at.y - to.y)).toBeLessThan(4);
  // The drag is one step to take back.
  await studio.control("edit.undo").click();
  const undone = await stream(studio);
  expect(undone.tangent).toEqual(before.tangent);
  expect(undone.surfaces[0]!.fingerprint).toBe(before.surfaces[0]!.fingerprint);
  await studio.control("edit.redo").click();
  expect((await stream(studio)).tangent).toEqual(after.tangent);
});

test("components are set by sliders, and the length stays 1", async ({ studio }) => {
  await studio.openSample(CAR);
  const before = await stream(studio);
  for (const [i, axis] of ["x", "y", "z"].entries()) {
    await studio.slide(`tangent-${axis}`, 0.5, 0.8);
    const { tangent } = await stream(studio);
    expect(tangent[i]!).toBeCloseTo(0.6, 1);
    expect(length(tangent)).toBeCloseTo(1, 12);
    const shown = await studio.control(`tangent-${axis}-number`).inputValue();
    expect(Number(shown)).toBeCloseTo(tangent[i]!, 3);
  }
  await studio.slide("degrees", 0.5, 0.75);
  const turned = await stream(studio);
  expect(length(turned.tangent)).toBeCloseTo(1, 12);
  // Three components and a turn, each a step.
  for (let i = 0; i < 4; i += 1) {
    await studio.control("edit.undo").click();
    await studio.settled();
  }
  expect((await stream(studio)).tangent).toEqual(before.tangent);
});

test("a streamline is inserted, deleted, and both are taken back", async ({ studio }) => {
  await studio.openSample(CAR);
  const before = await stream(studio);
  await studio.control("model.insert-row").click();
  await studio.until("there are seven", () => studio.text("tangent-count"), (text) => text === "7 × 9");
  const more = await stream(studio);
  expect(more.trouble).toBeNull();
  expect(more.surfaces[0]!.rowCount).toBeGreaterThan(before.surfaces[0]!.rowCount);
  await studio.control("model.delete-column").click();
  await studio.until("there are eight", () => studio.text("tangent-count"), (text) => text === "7 × 8");
  await studio.control("edit.undo").click();
  await studio.until("there are nine", () => studio.text("tangent-count"), (text) => text === "7 × 9");
  await studio.control("edit.undo").click();
  await studio.until("there are six", () => studio.text("tangent-count"), (text) => text === "6 × 9");
  const undone = await stream(studio);
  expect(undone.surfaces[0]!.fingerprint).toBe(before.surfaces[0]!.fingerprint);
});

test("the saved model makes the saved surface, also by the command", async ({ studio }) => {
  await studio.openSample(CAR);
  await studio.slide("tangent-y", 0.5, 0.7);
  await studio.slide("depth", 0.5, 0.67);
  await stream(studio);
  await studio.section("save");
  const model = await studio.download(() => studio.control("file.model").click());
  expect(basename(model)).toMatch(/\.streamline\.json$/);
  const surface = await studio.download(() => studio.control("file.surface-obj").click());
  const theirs = join(studio.folder, "theirs.obj");
  fairform(["streamline", model, "-o", theirs, "--quiet"]);
  const points = vertices(theirs);
  const size = Math.max(...points.map((p) => Math.hypot(...p)));
  expect(gap(vertices(surface), points) / size).toBeLessThan(1e-6);
  for (const format of ["ply", "stl", "glb"]) {
    const path = await studio.download(() => studio.control(`file.surface-${format}`).click());
    const read = JSON.parse(fairform(["info", path, "--json"])) as { vertices: number; faces: number };
    const quads = (await stream(studio)).surfaces[0]!;
    const count = (quads.rowCount - 1) * (quads.columnCount - 1);
    expect([count, 2 * count], path).toContain(read.faces);
  }
  // It opens again, as it was.
  const saved = JSON.parse(readFileSync(model, "utf8")) as unknown;
  await studio.openSample("streamline/saddle.streamline.json");
  await studio.choose(model);
  await studio.until("it is open", () => studio.text("tangent-count"), (text) => text === "6 × 9");
  expect((await studio.settled()).model).toEqual(saved);
});

test("every model of the samples opens, with its colours and combs", async ({ studio }) => {
  for (const name of ["saddle", "duct", "hull", "chair", "bottle"]) {
    await studio.openSample(`streamline/${name}.streamline.json`);
    expect((await stream(studio)).trouble, name).toBeNull();
  }
  await studio.openSample(CAR);
  await studio.control("show.combs").click();
  await studio.section("show");
  await studio.control("colouring").selectOption("gaussian");
  const { combs, values } = await stream(studio);
  expect(combs).toBeGreaterThan(0);
  expect(values![0]!.label).toContain("curvature");
  await studio.control("legend").waitFor();
});

test("a reload brings the model back, and the surface goes to the other workspace", async ({ studio }) => {
  await studio.openSample(CAR);
  await studio.slide("tangent-x", 0.5, 0.7);
  const before = await stream(studio);
  await studio.ask("flush()");
  await studio.reload();
  const back = await stream(studio);
  expect((await studio.state()).workspace).toBe("streamline");
  expect(back.surfaces[0]!.fingerprint).toBe(before.surfaces[0]!.fingerprint);

  await studio.section("save");
  await studio.control("file.to-mesh").click();
  const isMesh = async () => (await studio.state()).workspace === "interpolation";
  await studio.until("it is a mesh", isMesh, (is) => is);
  await studio.until("it is fitted", () => studio.settled(), (now) => now.fit !== null);
  const { info, fit } = await studio.settled();
  const { rowCount, columnCount } = before.surfaces[0]!;
  expect(info!.vertexCount).toBe(rowCount * columnCount);
  expect(fit!.converged).toBe(true);
});

test("a model with an error says where", async ({ studio }) => {
  const broken = join(studio.folder, "broken.streamline.json");
  const text = readFileSync(data("streamline/car.streamline.json"), "utf8");
  writeFileSync(broken, text.slice(0, text.length / 2));
  await studio.choose(broken);
  await studio.control("message").waitFor();
  expect(await studio.text("message")).toMatch(/broken\.streamline\.json.*line \d+/s);
});
