// What the main views look like. After a change that is meant to be seen, FAIRFORM_PICTURES=new draws new ones,
// which are looked at before they are kept.

import { guide, test, type Studio } from "./harness";

/** Nothing is hovered or focused, and the samples at the bottom are away. */
async function calm(studio: Studio): Promise<void> {
  const close = studio.control("welcome-close");
  if ((await close.count()) > 0) await close.click();
  await studio.page.evaluate("document.activeElement?.blur()");
  await studio.page.mouse.move(640, 24);
  await studio.settled();
}

test("a mesh and its surface", async ({ studio }) => {
  await studio.looksLike("begin");
  await calm(studio);
  await studio.looksLike("interpolation");
});

test("a vertex is being moved", async ({ studio }) => {
  await studio.control("tool.vertices").click();
  const v = await studio.vertexNear({ x: 520, y: 440 });
  const from = await studio.vertex(v);
  await studio.page.mouse.click(from.x, from.y);
  await studio.drag(from, { x: from.x - 60, y: from.y + 30 });
  await calm(studio);
  await studio.looksLike("vertex");
  await studio.depict(guide("studio.png"));
});

test("curvature in colours", async ({ studio }) => {
  await studio.openSample("fandisk.off");
  await studio.ask('run("colour.gaussian")');
  await calm(studio);
  await studio.looksLike("curvature");
});

test("tension as a heat map", async ({ studio }) => {
  await studio.openSample("spot-quads.obj");
  await studio.section("selection");
  await studio.type("expression", "y>0.2");
  await studio.until("faces are selected", () => studio.state(), (now) => now.mesh!.faces.length > 0);
  await studio.section("tension");
  await studio.type("falloff-number", "3");
  await studio.type("tension-number", "0.95");
  await studio.until("they are tighter", () => studio.settled(), (now) => now.mesh!.design.tensions.length > 0);
  await studio.ask('run("select.none")');
  await studio.ask('run("colour.tension")');
  await calm(studio);
  await studio.looksLike("tension");
});

test("two settings side by side", async ({ studio }) => {
  await studio.openSample("spot-quads.obj");
  await studio.control("compare.toggle").click();
  await studio.control("scheme").selectOption("doo-sabin");
  await studio.ask('run("colour.mean")');
  await calm(studio);
  await studio.looksLike("compare");
});

test("streamlines", async ({ studio }) => {
  await studio.openSample("streamline/car.streamline.json");
  await calm(studio);
  await studio.looksLike("streamlines");
  await studio.depict(guide("studio-streamlines.png"));
});

test("the dark look, and high contrast", async ({ studio }) => {
  await studio.ask('run("theme.dark")');
  await calm(studio);
  await studio.looksLike("dark");
  await studio.ask('run("theme.contrast")');
  await calm(studio);
  await studio.looksLike("contrast");
});

test("streamlines in the dark", async ({ studio }) => {
  await studio.ask('run("theme.dark")');
  await studio.openSample("streamline/bottle.streamline.json");
  await calm(studio);
  await studio.looksLike("streamlines-dark");
});

test("the dialogs", async ({ studio }) => {
  await studio.control("file.gallery").click();
  await studio.control("gallery").waitFor();
  await studio.looksLike("samples");
  await studio.page.keyboard.press("Escape");
  await studio.control("help").click();
  await studio.control("help-dialog").waitFor();
  await studio.page.evaluate("document.activeElement?.blur()");
  await studio.looksLike("commands");
});

test("a phone", async ({ open }) => {
  const studio = await open({ touch: true, size: { width: 390, height: 780 } });
  await studio.looksLike("phone");
});
