// Faces are selected by pointing, and the surface is drawn tight there.

import { expect, test } from "./harness";

test("a brush paints a selection, and a slider tightens the surface there", async ({ studio }) => {
  await studio.openSample("spot-quads.obj");
  await studio.control("tool.brush").click();
  await studio.drag({ x: 480, y: 400 }, { x: 600, y: 420 }, 8);
  const { mesh, fingerprint } = await studio.settled();
  const painted = mesh!.faces;
  expect(painted.length).toBeGreaterThan(3);
  expect(painted.length).toBeLessThan(90);
  await studio.section("selection");
  expect(await studio.text("selection-count")).toBe(`${painted.length} faces`);

  await studio.section("tension");
  await studio.slide("tension", 0.02, 0.8);
  const tight = await studio.settled();
  expect(tight.fingerprint).not.toBe(fingerprint);
  expect(tight.fit?.converged).toBe(true);
  const { tensions, tension } = tight.mesh!.design;
  expect(tension).toBeNull();
  expect(tensions.map(([face]) => face)).toEqual(painted);
  expect(new Set(tensions.map(([, value]) => value)).size).toBe(1);
  expect(tensions[0]![1]).toBeGreaterThan(0.8);

  await studio.control("heat-map").check({ force: true });
  await studio.settled();
  await studio.control("legend").waitFor();
  expect(await studio.text("legend-label")).toBe("Shape parameter λ");
  expect(await studio.number("legend-low")).toBeCloseTo(0.5, 1);
  // Most of what there is: the few tightest points may be beyond.
  expect(await studio.number("legend-high")).toBeGreaterThan(0.6);
  expect(await studio.number("legend-high")).toBeLessThan(tensions[0]![1] + 0.01);

  // The whole slide is one step.
  await studio.control("edit.undo").click();
  const undone = await studio.settled();
  expect(undone.mesh!.design.tensions).toEqual([]);
  expect(undone.mesh!.faces).toEqual(painted);
  expect(undone.fingerprint).toBe(fingerprint);
  await studio.control("edit.redo").click();
  expect((await studio.settled()).fingerprint).toBe(tight.fingerprint);
});

test("clicks, boxes and lassos select; Shift adds and Ctrl takes away", async ({ studio }) => {
  const { keyboard, mouse } = studio.page;
  const faces = async () => (await studio.state()).mesh!.faces;
  await mouse.click(520, 480);
  const first = await faces();
  expect(first.length).toBe(1);
  await keyboard.down("Shift");
  await mouse.click(600, 400);
  await keyboard.up("Shift");
  const two = await faces();
  expect(two.length).toBe(2);
  expect(two).toContain(first[0]);
  await keyboard.down("Control");
  await mouse.click(520, 480);
  await keyboard.up("Control");
  expect(await faces()).toEqual(two.filter((face) => face !== first[0]));

  await studio.control("tool.box").click();
  await studio.drag({ x: 430, y: 380 }, { x: 560, y: 520 });
  const inBox = await faces();
  expect(inBox.length).toBeGreaterThan(3);
  await studio.control("tool.through").click();
  await studio.drag({ x: 430, y: 380 }, { x: 560, y: 520 });
  expect((await faces()).length).toBeGreaterThan(inBox.length);
  await studio.control("tool.through").click();

  await studio.control("tool.lasso").click();
  await mouse.move(430, 380);
  await mouse.down();
  for (const [x, y] of [[560, 380], [560, 520], [430, 520]] as const) await mouse.move(x, y, { steps: 3 });
  await mouse.up();
  expect(await faces()).toEqual(inBox);
  await keyboard.press("Escape");
  expect(await faces()).toEqual([]);
});

test("a falloff spreads the tension, and expressions select", async ({ studio }) => {
  await studio.section("selection");
  await studio.control("expression").fill("z>0.5");
  await studio.control("expression-go").click();
  const { mesh } = await studio.until("faces are selected", () => studio.state(), (now) => now.mesh!.faces.length > 0);
  const chosen = mesh!.faces;
  await studio.section("tension");
  await studio.slide("falloff", 0, 0.2);
  await studio.slide("tension", 0.02, 0.9);
  const isSpread = (now: Awaited<ReturnType<typeof studio.state>>) => now.mesh!.design.tensions.length > 0;
  const spread = await studio.until("it spreads", () => studio.settled(), isSpread);
  const { tensions } = spread.mesh!.design;
  expect(tensions.length).toBeGreaterThan(chosen.length);
  const most = Math.max(...tensions.map(([, value]) => value));
  expect(tensions.some(([, value]) => value > 0.5 && value < most)).toBe(true);

  await studio.control("expression").fill("z>>0.5");
  await studio.control("expression-go").click();
  await studio.control("expression-wrong").waitFor();
  expect((await studio.state()).mesh!.faces).toEqual(chosen);
});
