// What a checker of accessibility finds: nothing, in any view and any look.

import { data, expect, test } from "./harness";

for (const look of ["light", "dark", "contrast"]) {
  test(`no barriers in the look ${look}`, async ({ studio }) => {
    await studio.ask(`run("theme.${look}")`);
    expect(await studio.barriers(), "at the start").toEqual([]);

    for (const id of ["selection", "tension", "vertices", "edges", "save"]) await studio.section(id);
    await studio.ask('run("colour.tension")');
    await studio.ask('run("compare.toggle")');
    await studio.settled();
    expect(await studio.barriers(), "with everything open").toEqual([]);
    await studio.ask('run("compare.toggle")');
    await studio.settled();

    await studio.control("file.gallery").click();
    await studio.control("gallery").waitFor();
    expect(await studio.barriers(), "samples").toEqual([]);
    await studio.page.keyboard.press("Escape");
    await studio.control("help").click();
    await studio.control("help-dialog").waitFor();
    expect(await studio.barriers(), "commands").toEqual([]);
    await studio.page.keyboard.press("Escape");
    await studio.choose(data("meshes/bad/inconsistent_winding_cube.obj"));
    await studio.control("message").waitFor();
    expect(await studio.barriers(), "a message").toEqual([]);
    await studio.page.keyboard.press("Escape");

    await studio.control("workspace-streamline").click();
    await studio.control("streamline").waitFor();
    await studio.settled();
    expect(await studio.barriers(), "streamlines, empty").toEqual([]);
    await studio.openSample("streamline/bottle.streamline.json");
    for (const id of ["lengths", "start", "initial", "show", "save"]) {
      if ((await studio.control(`section-${id}`).count()) > 0) await studio.section(id);
    }
    await studio.ask('run("colour.gaussian")');
    await studio.settled();
    expect(await studio.barriers(), "streamlines").toEqual([]);
  });
}

test("the page follows the look of the system", async ({ open }) => {
  const studio = await open({ dark: true });
  expect(await studio.page.evaluate("document.documentElement.dataset.theme")).toBe("dark");
  await studio.page.emulateMedia({ colorScheme: "light" });
  const look = () => studio.page.evaluate("document.documentElement.dataset.theme");
  await studio.until("it is light", look, (name) => name === "light");
});
