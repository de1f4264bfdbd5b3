// Fingers: one turns the view, two move it and zoom, a tap selects.

import { expect, test, type Place, type Studio } from "./harness";

async function touch(studio: Studio, type: "touchStart" | "touchMove" | "touchEnd", fingers: Place[]): Promise<void> {
  const touchPoints = fingers.map(({ x, y }, id) => ({ x, y, id }));
  await (await studio.protocol()).send("Input.dispatchTouchEvent", { type, touchPoints });
}

/** Fingers go from where they start to where they end. */
async function swipe(studio: Studio, from: Place[], to: Place[]): Promise<void> {
  await touch(studio, "touchStart", from);
  for (let i = 1; i <= 5; i += 1) {
    const at = from.map(({ x, y }, k) => ({ x: x + (i / 5) * (to[k]!.x - x), y: y + (i / 5) * (to[k]!.y - y) }));
    await touch(studio, "touchMove", at);
    await studio.frame();
  }
  await touch(studio, "touchEnd", []);
  await studio.frame();
}

async function view(studio: Studio): Promise<{ arm: number[]; distance: number; target: number[] }> {
  const { position, target } = (await studio.state()).camera!;
  const arm = position.map((x, i) => x - target[i]!);
  return { arm, distance: Math.hypot(...arm), target };
}

test("fingers turn, move and zoom the view", async ({ open }) => {
  const studio = await open({ touch: true });
  const before = await view(studio);
  await swipe(studio, [{ x: 300, y: 200 }], [{ x: 420, y: 240 }]);
  const turned = await view(studio);
  expect(turned.distance).toBeCloseTo(before.distance, 6);
  expect(Math.hypot(...turned.arm.map((x, i) => x - before.arm[i]!))).toBeGreaterThan(0.1 * before.distance);

  await swipe(studio, [{ x: 400, y: 300 }, { x: 500, y: 300 }], [{ x: 300, y: 300 }, { x: 600, y: 300 }]);
  const near = await view(studio);
  expect(near.distance).toBeLessThan(0.7 * turned.distance);

  await swipe(studio, [{ x: 400, y: 300 }, { x: 500, y: 300 }], [{ x: 460, y: 380 }, { x: 560, y: 380 }]);
  const moved = await view(studio);
  expect(moved.distance).toBeCloseTo(near.distance, 1);
  expect(Math.hypot(...moved.target.map((x, i) => x - near.target[i]!))).toBeGreaterThan(0.02);
  // None of that selected anything.
  expect((await studio.state()).mesh!.faces).toEqual([]);
});

test("a tap selects a face", async ({ open }) => {
  const studio = await open({ touch: true });
  await studio.page.touchscreen.tap(520, 480);
  expect((await studio.settled()).mesh!.faces.length).toBe(1);
});

test("it all fits on a phone", async ({ open }) => {
  const studio = await open({ touch: true, size: { width: 390, height: 780 } });
  const wide = await studio.page.evaluate<number>("document.documentElement.scrollWidth");
  expect(wide).toBeLessThanOrEqual(390);
  expect(await studio.barriers()).toEqual([]);
  await studio.page.touchscreen.tap(195, 240);
  expect((await studio.settled()).mesh!.faces.length).toBe(1);
});
