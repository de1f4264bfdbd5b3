// Everything is in reach of the keyboard, and one sees where it is.

import pixelmatch from "pixelmatch";
import { PNG } from "pngjs";

import { expect, test, type Studio } from "./harness";

/** What has the focus: its test id, or else its name or tag. */
function focused(studio: Studio): Promise<string> {
  return studio.page.evaluate(`(() => {
    const e = document.activeElement;
    return e.dataset.testid ?? e.getAttribute("aria-label") ?? e.tagName;
  })()`);
}

/** Presses Tab until something has the focus. */
async function tabTo(studio: Studio, name: string, most = 80): Promise<void> {
  const passed = [];
  for (let i = 0; i < most; i += 1) {
    await studio.page.keyboard.press("Tab");
    const now = await focused(studio);
    if (now === name) return;
    passed.push(now);
  }
  throw new Error(`Tab does not lead to ${name}, but to ${passed.join(", ")}`);
}

test("from the samples to a tighter surface without a mouse", async ({ studio }) => {
  const { keyboard } = studio.page;
  await tabTo(studio, "file.gallery");
  await keyboard.press("Enter");
  await studio.control("gallery").waitFor();
  await tabTo(studio, "sample-spot-quads.obj");
  await keyboard.press("Enter");
  await studio.until("the cow of quads is open", () => studio.state(), (now) => now.mesh?.name === "spot-quads.obj");
  const opened = await studio.settled();
  expect(opened.fit?.converged).toBe(true);

  await tabTo(studio, "scheme");
  await keyboard.press("ArrowDown");
  const other = await studio.settled();
  expect(other.mesh?.design.scheme).toBe("doo-sabin");
  expect(other.fingerprint).not.toBe(opened.fingerprint);
  await keyboard.press("ArrowUp");
  expect((await studio.settled()).mesh?.design.scheme).toBe("catmull-clark");

  // Keys of commands go to the page, wherever the focus is that does not type.
  await keyboard.press("Shift+Tab");
  await keyboard.press("f");
  await keyboard.press("n");
  await keyboard.press("n");
  await keyboard.press("Shift+ArrowUp");
  const grown = await studio.until("faces are selected", () => studio.settled(), (now) => now.mesh!.faces.length > 1);
  expect(grown.mesh!.faces).toContain(1);
  await keyboard.press("Shift+ArrowRight");
  const tight = await studio.settled();
  expect(tight.mesh!.design.tensions.map(([face]) => face)).toEqual(grown.mesh!.faces);
  expect(tight.fingerprint).not.toBe(grown.fingerprint);
  await keyboard.press("t");
  await studio.control("legend").waitFor();
  await keyboard.press("Control+z");
  const undone = await studio.settled();
  expect(undone.mesh!.design.tensions).toEqual([]);
  expect(undone.fingerprint).toBe(grown.fingerprint);
  await keyboard.press("Control+Shift+z");
  expect((await studio.settled()).fingerprint).toBe(tight.fingerprint);
});

test("? lists all commands, finds and runs them", async ({ studio }) => {
  const { keyboard } = studio.page;
  await keyboard.press("?");
  await studio.control("help-dialog").waitFor();
  expect(await focused(studio)).toBe("help-search");
  const names = await studio.ask<string[]>("actions()");
  for (const name of names) expect(await studio.page.getByTestId(`command-${name}`).count(), name).toBe(1);
  await keyboard.type("zebra");
  await studio.until("only zebras", () => studio.page.getByTestId(/^command-/).count(), (count) => count === 1);
  await keyboard.press("Enter");
  await studio.control("help-dialog").waitFor({ state: "detached" });
  await studio.until("stripes", () => studio.state(), (now) => now.settings.shading === "zebra");

  await keyboard.press("?");
  await studio.control("help-dialog").waitFor();
  // The dialog keeps the focus, and the keys.
  const seen = new Set<string>();
  for (let i = 0; i < 12; i += 1) {
    await keyboard.press("Tab");
    const where = `(document.activeElement.closest("dialog") ?? document.activeElement).tagName`;
    seen.add(await studio.page.evaluate(where));
  }
  seen.delete("BODY");
  expect([...seen]).toEqual(["DIALOG"]);
  await keyboard.press("Escape");
  await studio.control("help-dialog").waitFor({ state: "detached" });
});

test("the view turns, nears and goes to its sides by keys", async ({ studio }) => {
  const position = async () => (await studio.state()).camera!.position;
  const seen = [await position()];
  for (const key of ["ArrowLeft", "ArrowUp", "+", "Shift+F", "Shift+T", "Home"]) {
    await studio.page.keyboard.press(key);
    await studio.frame();
    seen.push(await position());
  }
  for (let i = 1; i < seen.length; i += 1) expect(seen[i], `step ${i}`).not.toEqual(seen[i - 1]);
});

test("streamlines are designed by keys", async ({ studio }) => {
  const { keyboard } = studio.page;
  await studio.openSample("streamline/car.streamline.json");
  const state = () => studio.ask<{ place: { row: number; column: number }; tangent: number[] }>("stream.state()");
  const before = await state();
  await keyboard.press("ArrowRight");
  await keyboard.press("ArrowDown");
  const moved = await state();
  expect(moved.place).toEqual({ row: before.place.row + 1, column: before.place.column + 1 });
  await keyboard.press("Alt+ArrowRight");
  await studio.settled();
  const turned = await state();
  const cosine = moved.tangent.reduce((sum, x, i) => sum + x * turned.tangent[i]!, 0);
  expect(cosine).toBeLessThan(1 - 1e-6);
  expect(Math.hypot(...turned.tangent)).toBeCloseTo(1, 12);
  await keyboard.press("Control+z");
  await studio.settled();
  expect((await state()).tangent).toEqual(moved.tangent);
});

/** Whether something around the focus looks different from how it looks without. */
async function isSeen(studio: Studio): Promise<boolean> {
  const box = await studio.page.evaluate<{ x: number; y: number; width: number; height: number }>(`(() => {
    const e = document.activeElement;
    // The marks of choices and switches are drawn beside what has the focus.
    const shown = e.matches("input[type=radio], input[type=checkbox]") ? e.closest("label") : e;
    shown.scrollIntoView({ block: "nearest" });
    const { x, y, width, height } = shown.getBoundingClientRect();
    return { x, y, width, height };
  })()`);
  const clip = {
    x: Math.max(0, box.x - 5),
    y: Math.max(0, box.y - 5),
    width: Math.min(1280 - Math.max(0, box.x - 5), box.width + 10),
    height: Math.min(800 - Math.max(0, box.y - 5), box.height + 10),
  };
  const shot = async () => PNG.sync.read(await studio.page.screenshot({ clip, caret: "hide" }));
  const on = await shot();
  await studio.page.evaluate("window.had = document.activeElement; window.had.blur()");
  const off = await shot();
  await studio.page.evaluate("window.had.focus({ focusVisible: true })");
  return pixelmatch(on.data, off.data, undefined, on.width, on.height, { threshold: 0.1 }) > 20;
}

test("one sees what has the focus", async ({ studio }) => {
  const hidden: string[] = [];
  const passed: string[] = [];
  // Through the bar, the tools and the panel, once around.
  await studio.page.evaluate("window.passed = new Set()");
  for (let i = 0; i < 90; i += 1) {
    await studio.page.keyboard.press("Tab");
    const isNew = await studio.page.evaluate<boolean>(`(() => {
      const e = document.activeElement;
      const isNew = e !== document.body && !window.passed.has(e);
      window.passed.add(e);
      return isNew;
    })()`);
    if (!isNew) break;
    const name = await focused(studio);
    passed.push(name);
    if (!(await isSeen(studio))) hidden.push(name);
  }
  expect(passed).toContain("replay");
  expect(passed.length).toBeGreaterThan(30);
  expect(hidden).toEqual([]);
});
