// Vertices are dragged, and the surface follows; what was made is saved, read by the command, and restored.

import { join } from "node:path";

import { data, expect, fairform, gap, test, triples, vertices, type Studio } from "./harness";

interface Drawn {
  given: number[];
  surface: number[];
}

/** Drags a vertex in the middle of the picture by its handle; where it is let go, and what was drawn meanwhile. */
async function dragOne(studio: Studio, by = { x: -70, y: 46 }) {
  await studio.control("tool.vertices").click();
  const v = await studio.vertexNear({ x: 520, y: 440 });
  const from = await studio.vertex(v);
  await studio.page.mouse.click(from.x, from.y);
  expect((await studio.settled()).mesh!.vertices).toEqual([v]);
  const seen = new Set<number | null>();
  const to = { x: from.x + by.x, y: from.y + by.y };
  let last = (await studio.state()).fingerprint;
  await studio.drag(from, to, 5, async () => {
    const next = await studio.until("the surface follows", () => studio.state(), (now) => now.fingerprint !== last);
    last = next.fingerprint;
    seen.add(last);
  });
  return { v, to, seen, after: await studio.settled() };
}

test("a vertex is dragged, and the surface follows and passes through all of them", async ({ studio }) => {
  const before = await studio.settled();
  const { v, to, seen, after } = await dragOne(studio);
  expect(seen.size).toBe(5);
  // It is where the pointer left it.
  const at = await studio.vertex(v);
  expect(Math.hypot(at.x - to.x, at.y - to.y)).toBeLessThan(4);
  expect(after.mesh!.design.moves.map(([moved]) => moved)).toEqual([v]);
  expect(after.undo).toBe("Move a vertex");
  const drawn = await studio.ask<Drawn>("places()");
  expect(gap(triples(drawn.given), triples(drawn.surface))).toBeLessThan(4e-6);
  expect(gap(triples(drawn.given), vertices(data("sample/spot.obj")))).toBeGreaterThan(0.05);
  expect(await studio.number("fit-max")).toBeLessThanOrEqual(1e-6);

  await studio.control("edit.undo").click();
  const undone = await studio.settled();
  expect(undone.mesh!.design.moves).toEqual([]);
  expect(undone.fingerprint).toBe(before.fingerprint);
  await studio.page.keyboard.press("Control+Shift+Z");
  const redone = await studio.settled();
  expect(redone.mesh!.design.moves).toEqual(after.mesh!.design.moves);
  const again = await studio.ask<Drawn>("places()");
  expect(gap(triples(again.given), triples(drawn.given))).toBeLessThan(1e-6);
  expect(gap(triples(again.given), triples(again.surface))).toBeLessThan(4e-6);
});

test("a vertex goes where its numbers say, and where arrows push it", async ({ studio }) => {
  await studio.control("tool.vertices").click();
  const v = await studio.vertexNear({ x: 520, y: 440 });
  const at = await studio.vertex(v);
  await studio.page.mouse.click(at.x, at.y);
  await studio.section("vertices");
  await studio.type("vertex-x", "0.4");
  const typed = await studio.until("it moved", () => studio.settled(), (now) => now.mesh!.design.moves.length > 0);
  expect(typed.mesh!.design.moves[0]![1]).toBeCloseTo(0.4, 6);
  const canvas = studio.page.locator("canvas.viewport").first();
  await canvas.focus();
  const { y } = await studio.vertex(v);
  await studio.page.keyboard.press("Alt+ArrowUp");
  await studio.settled();
  await studio.until("it moved up", () => studio.vertex(v), (place) => place.y < y - 1);
  await studio.control("vertex.reset").click();
  expect((await studio.settled()).mesh!.design.moves).toEqual([]);
});

test("what is saved is what is seen, and the command reads it", async ({ studio }) => {
  const { after } = await dragOne(studio);
  const { points, triangles } = after.surface!;
  const { given } = await studio.ask<Drawn>("places()");
  await studio.section("save");
  for (const format of ["obj", "ply", "stl", "glb"]) {
    for (const what of ["surface", "control"]) {
      const path = await studio.download(() => studio.control(`file.${what}-${format}`).click());
      expect(path.endsWith(`spot-${what}.${format}`), path).toBe(true);
      const counts = what === "surface" ? [points, triangles] : [188, 372];
      const read = JSON.parse(fairform(["info", path, "--json"])) as { vertices: number; faces: number };
      if (format !== "stl") expect(read.vertices, path).toBe(counts[0]);
      expect(read.faces, path).toBe(counts[1]);
    }
  }
  // The surface of the control mesh passes through the vertices, moved as they are.
  const limit = join(studio.folder, "limit.obj");
  fairform(["limit", join(studio.folder, "spot-control.obj"), "-o", limit]);
  expect(gap(vertices(limit), triples(given))).toBeLessThan(4e-6);
  // And so does the surface that was saved, whose first vertices are theirs.
  expect(gap(vertices(join(studio.folder, "spot-surface.obj")).slice(0, 188), triples(given))).toBeLessThan(4e-6);
});

test("a project keeps everything, also for the command", async ({ studio }) => {
  const { after } = await dragOne(studio);
  await studio.control("save-menu").click();
  const path = await studio.download(() => studio.control("menu-file.save").click());
  expect(path.endsWith("spot.fairform.json")).toBe(true);
  const fitted = join(studio.folder, "fitted.obj");
  fairform(["fit", path, "--quiet", "--control", fitted, "-o", join(studio.folder, "surface.ply")]);
  const limit = join(studio.folder, "limit.obj");
  fairform(["limit", fitted, "-o", limit]);
  const { given } = await studio.ask<Drawn>("places()");
  expect(gap(vertices(limit), triples(given))).toBeLessThan(4e-6);

  await studio.openSample("torus.obj");
  await studio.choose(path);
  await studio.until("the project is open", () => studio.state(), (now) => now.mesh?.name === "spot.obj");
  const opened = await studio.settled();
  expect(opened.mesh).toEqual(after.mesh);
  expect(opened.fit?.converged).toBe(true);
});

/** Until what a page shows is in the browser's store. */
async function isKept(studio: Studio): Promise<void> {
  const moves = () =>
    studio.page.evaluate<number>(`new Promise((done) => {
      const opened = indexedDB.open("fairform-studio");
      opened.onerror = () => done(-1);
      opened.onsuccess = () => {
        const database = opened.result;
        const read = database.transaction("autosave").objectStore("autosave").get("document");
        read.onsuccess = () => { database.close(); done(read.result?.mesh?.design.moves.length ?? 0); };
      };
    })`);
  await studio.until("it is kept", moves, (count) => count > 0);
}

test("a reload brings the work back", async ({ studio }) => {
  const { after } = await dragOne(studio);
  await isKept(studio);
  await studio.reload();
  const back = await studio.settled();
  expect(back.mesh).toEqual(after.mesh);
  expect(back.workspace).toBe("interpolation");
  expect(back.fit?.converged).toBe(true);
  const { camera } = after;
  for (const [i, x] of back.camera!.position.entries()) expect(x).toBeCloseTo(camera!.position[i]!, 5);
});

test("a page that is closed, and one that crashes, leave the work for the next", async ({ studio }) => {
  const { after } = await dragOne(studio);
  await isKept(studio);
  await studio.page.close();
  await studio.newPage();
  expect((await studio.settled()).mesh).toEqual(after.mesh);

  await studio.control("scheme").selectOption("butterfly");
  await studio.settled();
  await studio.ask("flush()");
  const crashed = new Promise((done) => studio.page.once("crash", done));
  void (await studio.protocol()).send("Page.crash").catch(() => {});
  await crashed;
  await studio.page.close();
  await studio.newPage();
  const back = await studio.settled();
  expect(back.mesh!.design.scheme).toBe("butterfly");
  expect(back.mesh!.design.moves).toEqual(after.mesh!.design.moves);
});
