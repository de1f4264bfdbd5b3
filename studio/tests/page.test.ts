import { expect, test } from "vitest";
import { stem } from "../src/files";
import { insideLasso } from "../src/scene/gestures";
import { gradient, RAMPS, texels } from "../src/scene/ramps";
import { isServed, servedFile } from "../src/served";
import { lookOf } from "../src/theme";

test("a page is served if it says so", () => {
  const page = (found: boolean) => ({ querySelector: () => (found ? ({} as Element) : null) });
  expect(isServed(page(true))).toBe(true);
  expect(isServed(page(false))).toBe(false);
});

test("the server's file has the name of its header", async () => {
  const answer = new Response(Uint8Array.of(7, 8), { headers: { "X-File-Name": "K%C3%BChlturm%202.obj" } });
  const source = await servedFile(() => Promise.resolve(answer));
  expect(source).toEqual({ name: "Kühlturm 2.obj", bytes: Uint8Array.of(7, 8) });
  expect(await servedFile(() => Promise.resolve(new Response(null, { status: 204 })))).toBeNull();
  const broken = () => Promise.resolve(new Response(null, { status: 500, statusText: "Oops" }));
  await expect(servedFile(broken)).rejects.toThrow("500 Oops");
});

test("names of files that are saved", () => {
  expect(stem("dir/bunny.obj")).toBe("bunny");
  expect(stem("bunny.obj.gz")).toBe("bunny");
  expect(stem("my.work.fairform.json")).toBe("my.work");
  expect(stem("v2.1 final.ply")).toBe("v2.1 final");
});

test("a lasso is even-odd, like the shape on the screen", () => {
  const inside = insideLasso([{ x: 0, y: 0 }, { x: 10, y: 0 }, { x: 10, y: 10 }, { x: 5, y: 2 }, { x: 0, y: 10 }]);
  expect(inside(1, 4)).toBe(true);
  expect(inside(9, 4)).toBe(true);
  expect(inside(5, 6)).toBe(false);
  expect(inside(-1, 4)).toBe(false);
});

test("ramps begin and end with the published colours, and zero is white", () => {
  const viridis = texels(RAMPS.sequential);
  expect([...viridis.subarray(0, 3)]).toEqual([0x44, 0x01, 0x54]);
  expect([...viridis.subarray(1020, 1023)]).toEqual([0xfd, 0xe7, 0x25]);
  const middle = RAMPS.diverging[(RAMPS.diverging.length - 1) / 2]!;
  expect(Math.max(...middle) - Math.min(...middle)).toBe(0);
  expect(gradient(RAMPS.sequential)).toMatch(/^linear-gradient\(to right, rgb\(68 1 84\)/);
});

test("the look follows the system unless chosen", () => {
  expect(lookOf("auto", false, false)).toBe("light");
  expect(lookOf("auto", true, false)).toBe("dark");
  expect(lookOf("auto", true, true)).toBe("contrast");
  expect(lookOf("light", true, true)).toBe("light");
});
