// A mesh, the surface through its vertices, and everything that says how it came about.

import { join } from "node:path";

import { data, expect, fairform, gap, test, triples, vertices, type Studio } from "./harness";

/** The largest distance of the drawn surface from a vertex, relative to the diagonal. */
async function miss(studio: Studio): Promise<number> {
  const { given, surface } = await studio.ask<{ given: number[]; surface: number[] }>("places()");
  const { min, max } = (await studio.state()).info!;
  const diagonal = Math.hypot(...max.map((x, i) => x - min[i]!));
  return gap(triples(given), triples(surface)) / diagonal;
}

test("the surface passes through every vertex, as the panel says", async ({ studio }) => {
  const { fit } = await studio.settled();
  expect(fit?.converged).toBe(true);
  const shown = await studio.number("fit-max");
  expect(shown).toBeLessThanOrEqual(1e-6);
  expect(Math.abs(shown - fit!.max)).toBeLessThan(0.01 * fit!.max);
  // The picture has 24 bits.
  expect(await miss(studio)).toBeLessThan(1.5e-6);
  expect(await studio.text("status")).toContain("passes through every vertex");
});

test("the page and the command find the same control mesh", async ({ studio }) => {
  await studio.section("save");
  const ours = await studio.download(() => studio.control("file.control-obj").click());
  const theirs = join(studio.folder, "theirs.obj");
  fairform(["fit", data("sample/spot.obj"), "--quiet", "--control", theirs, "-o", join(studio.folder, "surface.obj")]);
  expect(gap(vertices(ours), vertices(theirs))).toBe(0);
});

test("each scheme makes another surface, which passes through the vertices", async ({ studio }) => {
  const seen = new Set([(await studio.settled()).fingerprint]);
  for (const scheme of ["butterfly", "catmull-clark", "doo-sabin", "loop"]) {
    await studio.control("scheme").selectOption(scheme);
    const { fingerprint, fit, mesh } = await studio.settled();
    expect(mesh?.design.scheme).toBe(scheme);
    expect(fit?.converged, scheme).toBe(true);
    // Doo–Sabin's surface has no vertex of its own for each that is given.
    if (scheme !== "doo-sabin") expect(await miss(studio), scheme).toBeLessThan(1.5e-6);
    seen.add(fingerprint);
  }
  // Loop, the first and the last, is the same to the last bit.
  expect(seen.size).toBe(4);
});

test("only schemes for what the mesh has are on offer", async ({ studio }) => {
  await studio.openSample("spot-quads.obj");
  const names = () => studio.control("scheme").locator("option").allInnerTexts();
  // It has triangles and pentagons, too.
  expect(await names()).toEqual(["Catmull–Clark", "Doo–Sabin"]);
  await studio.openSample("torus.obj");
  expect(await names()).toEqual(["Catmull–Clark", "Doo–Sabin", "Kobbelt"]);
});

test("levels refine the surface", async ({ studio }) => {
  // A closed triangle mesh of the sphere: each step has four times the faces, and F/2 + 2 vertices.
  for (const [keys, level] of [["Home", 0], ["ArrowRight", 1], ["ArrowRight", 2], ["ArrowRight", 3]] as const) {
    await studio.control("levels").focus();
    await studio.page.keyboard.press(keys);
    const { surface, mesh } = await studio.settled();
    const triangles = 372 * 4 ** level;
    expect(mesh?.fineness.levels).toBe(level);
    expect(surface).toEqual({ points: triangles / 2 + 2, triangles });
    const words = [triangles / 2 + 2, triangles].map((x) => x.toLocaleString("en"));
    expect(await studio.text("surface-numbers")).toBe(`${words[0]} points, ${words[1]} triangles`);
  }
});

test("the polygon mesh is not the limit surface", async ({ studio }) => {
  await studio.control("levels").focus();
  await studio.page.keyboard.press("Home");
  await studio.settled();
  expect(await miss(studio)).toBeLessThan(1.5e-6);
  await studio.control("points-polygon").check({ force: true });
  await studio.settled();
  // At level 0 that is the control mesh, and away from the vertices.
  expect(await miss(studio)).toBeGreaterThan(1e-3);
  await studio.control("points-limit").check({ force: true });
  await studio.settled();
  expect(await miss(studio)).toBeLessThan(1.5e-6);
});

test("the error is plotted, and the replay walks along it", async ({ studio }) => {
  const { fit, fingerprint } = await studio.settled();
  const updates = await studio.number("fit-iterations");
  expect(updates).toBe(fit!.history.at(-1)!.iteration);
  const plot = studio.control("plot");
  expect(await plot.getAttribute("aria-label")).toContain(`over ${updates} updates`);
  const line = (await plot.locator("path.max").getAttribute("d"))!;
  expect(line.match(/[ML]/g)!.length).toBe(fit!.history.length);

  await studio.slide("replay", 1, 0);
  const begin = await studio.settled();
  expect(begin.iteration).toBe(0);
  expect(begin.fingerprint).not.toBe(fingerprint);
  expect(await miss(studio)).toBeGreaterThan(0.01);
  expect(await plot.locator(".now").count()).toBe(1);

  const errors = [await miss(studio)];
  for (let i = 0; i < 3; i += 1) {
    await studio.page.keyboard.press("ArrowRight");
    await studio.settled();
    errors.push(await miss(studio));
  }
  for (const [i, error] of errors.entries()) expect(error).toBeCloseTo(fit!.history[i]!.max, 5);

  await studio.page.keyboard.press("End");
  const end = await studio.settled();
  expect(end.iteration).toBeNull();
  expect(end.fingerprint).toBe(fingerprint);
});

test("a long fit does not hold up the page, and can be stopped", async ({ studio }) => {
  const path = join(studio.folder, "fine.ply");
  fairform(["refine", data("sample/spot.obj"), "-o", path, "--levels", "4", "--quiet"]);
  await studio.openFile(path);
  // The looser the faces, the more updates it takes; and to make it fair takes longer than all of them.
  await studio.control("scheme").selectOption("doo-sabin");
  await studio.control("method").selectOption("plain");
  await studio.type("iterations", "1000000");
  await studio.type("tolerance-number", "1e-14");
  await studio.section("tension");
  await studio.type("tension-number", "0.01");
  const before = await studio.settled();
  expect(before.fit?.converged).toBe(true);
  await studio.control("fair").check({ force: true });
  await studio.control("cancel").waitFor();

  // Meanwhile clocks tick, dialogs open, and the view turns.
  const ticks = await studio.page.evaluate<number>(`new Promise((done) => {
    let count = 0;
    const timer = setInterval(() => (count += 1), 10);
    setTimeout(() => { clearInterval(timer); done(count); }, 200);
  })`);
  expect(ticks).toBeGreaterThan(3);
  await studio.control("help").click();
  await studio.control("help-dialog").waitFor();
  await studio.page.keyboard.press("Escape");
  await studio.control("help-dialog").waitFor({ state: "detached" });
  const { camera } = await studio.state();
  await studio.page.keyboard.press("ArrowLeft");
  const during = await studio.state();
  expect(during.camera).not.toEqual(camera);
  expect(during.stage).toBe("fit");
  expect(await studio.text("progress")).toMatch(/update \d+: \d/);

  await studio.control("cancel").click();
  const after = await studio.settled();
  expect(after.stage).toBeNull();
  expect(after.trouble).toBeNull();
  expect(after.surface).toEqual(before.surface);
  // It goes on from there.
  await studio.control("edit.undo").click();
  const again = await studio.settled();
  expect(again.fit?.converged).toBe(true);
  expect(again.fingerprint).toBe(before.fingerprint);
});
