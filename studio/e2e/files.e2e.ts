// Files come in by the dialog, by dropping them and with the command; what is wrong with one is told and mended.

import { copyFileSync, readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { gzipSync } from "node:zlib";

import { data, expect, test, type Studio } from "./harness";

/** Vertices, faces, boundaries and parts, as data/meshes/README.md has them. */
const MESHES: readonly [string, number, number, number, number][] = [
  ["sample/spot-quads.obj", 188, 180, 0, 1],
  ["meshes/tri_closed/icosahedron.off", 12, 20, 0, 1],
  ["meshes/tri_open/lego_1loop.ply", 1649, 3072, 1, 1],
  ["meshes/tri_closed/sphere_soup_ascii.stl", 114, 224, 0, 1],
  ["meshes/odd/cube_two_instances.glb", 16, 24, 0, 2],
  ["meshes/odd/cube_embedded.gltf", 8, 12, 0, 1],
  ["meshes/quad/pipes_6loops.off", 32, 24, 6, 1],
];

async function expectNumbers(studio: Studio, vertices: number, faces: number, loops: number, parts: number) {
  expect(await studio.number("vertex-count")).toBe(vertices);
  expect(await studio.number("face-count")).toBe(faces);
  expect(await studio.text("mesh-numbers")).toMatch(new RegExp(`Boundaries\\s+${loops}\\s+Parts\\s+${parts}\\s`));
}

test("every format opens, and its numbers are right", async ({ studio }) => {
  for (const [path, ...numbers] of MESHES) {
    const { fit, trouble } = await studio.openFile(data(path));
    await expectNumbers(studio, ...numbers);
    expect(trouble, path).toBeNull();
    expect(fit?.converged, path).toBe(true);
    expect(await studio.text("file-name")).toBe(path.split("/").at(-1));
  }
});

test("compressed files open", async ({ studio }) => {
  const path = join(studio.folder, "spot.obj.gz");
  writeFileSync(path, gzipSync(readFileSync(data("sample/spot.obj"))));
  await studio.openFile(path);
  await expectNumbers(studio, 188, 372, 0, 1);
});

test("a file is dropped on the page", async ({ studio }) => {
  await studio.drop(data("meshes/quad/catmark_torus.obj"));
  await studio.until("the torus is open", () => studio.state(), (now) => now.mesh?.name === "catmark_torus.obj");
  const { mesh } = await studio.settled();
  await expectNumbers(studio, 32, 32, 0, 1);
  expect(mesh?.design.scheme).toBe("catmull-clark");
});

test("the command brings its file", async ({ open }) => {
  const studio = await open({ file: data("meshes/polygon/dodecahedron.obj") });
  await expectNumbers(studio, 20, 12, 0, 1);
  expect(await studio.text("file-name")).toBe("dodecahedron.obj");
});

test("names with spaces and letters of other languages come through", async ({ open }) => {
  const studio = await open();
  const path = join(studio.folder, "zwei Würfel.off");
  copyFileSync(data("meshes/odd/crlf.off"), path);
  const served = await open({ file: path });
  expect(await served.text("file-name")).toBe("zwei Würfel.off");
});

test("a file that is not understood says where, and what was open stays", async ({ studio }) => {
  await studio.choose(data("meshes/bad/index_out_of_range.obj"));
  await studio.control("message").waitFor();
  expect(await studio.text("message")).toContain("line 9");
  expect(await studio.text("message")).toContain("vertex 10");
  await studio.page.keyboard.press("Escape");
  await studio.control("message").waitFor({ state: "detached" });
  const { mesh } = await studio.settled();
  expect(mesh?.name).toBe("spot.obj");
  await expectNumbers(studio, 188, 372, 0, 1);
});

test("a mesh with faces turned over is mended by the step on offer", async ({ studio }) => {
  await studio.choose(data("meshes/bad/inconsistent_winding_cube.obj"));
  await studio.control("choice-0").waitFor();
  const message = await studio.text("message");
  expect(message).toMatch(/faces? \d+ and \d+ both run from vertex \d+ to vertex \d+/);
  expect(message).toMatch(/Repair: turn/);
  await studio.control("choice-0").click();
  const name = "inconsistent_winding_cube.obj";
  await studio.until("the cube is open", () => studio.state(), (now) => now.mesh?.name === name);
  const { mesh, fit } = await studio.settled();
  expect(mesh?.repairs).toContain("orient");
  expect(fit?.converged).toBe(true);
  await expectNumbers(studio, 8, 6, 0, 1);
  // What was mended stays mended, over undo and redo.
  await studio.control("edit.undo").click();
  expect((await studio.settled()).mesh?.name).toBe("spot.obj");
  await studio.control("edit.redo").click();
  await studio.settled();
  await expectNumbers(studio, 8, 6, 0, 1);
});

test("what no step mends is told, with nothing to press but closing", async ({ studio }) => {
  await studio.choose(data("meshes/bad/truncated.glb"));
  await studio.control("message").waitFor();
  expect(await studio.text("message")).toMatch(/truncated\.glb.*byte/s);
  expect(await studio.control("choice-0").count()).toBe(0);
  await studio.control("dismiss").click();
  expect((await studio.settled()).mesh?.name).toBe("spot.obj");
});
