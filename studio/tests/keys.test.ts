import { afterEach, expect, test, vi } from "vitest";
import { list, press, register, run } from "../src/actions";
import { isTyping, keyLabel, keyOf } from "../src/keys";

const event = (key: string, more: Partial<KeyboardEvent> = {}) =>
  ({
    key,
    ctrlKey: false,
    metaKey: false,
    altKey: false,
    shiftKey: false,
    target: null,
    preventDefault: () => {},
    ...more,
  }) as KeyboardEvent;

let unregister = () => {};
afterEach(() => unregister());

test("keys have one name whatever the keyboard", () => {
  expect(keyOf(event("z", { ctrlKey: true }))).toBe("Mod+Z");
  expect(keyOf(event("Z", { metaKey: true, shiftKey: true }))).toBe("Mod+Shift+Z");
  expect(keyOf(event("?", { shiftKey: true }))).toBe("?");
  expect(keyOf(event(" "))).toBe("Space");
  expect(keyOf(event("ArrowUp", { shiftKey: true }))).toBe("Shift+ArrowUp");
});

test("keys as people read them", () => {
  expect(keyLabel("Mod+Shift+Z")).toBe("Ctrl+Shift+Z");
  expect(keyLabel("Mod+O", true)).toBe("⌘O");
  expect(keyLabel("Alt+ArrowLeft")).toBe("Alt+←");
});

test("typing belongs to the field, commands with Ctrl do not", () => {
  const input = { tagName: "INPUT", type: "text" } as unknown as EventTarget;
  expect(isTyping(input, "Z")).toBe(true);
  expect(isTyping(input, "Mod+S")).toBe(false);
  expect(isTyping(input, "Mod+Z")).toBe(true);
  const slider = { tagName: "INPUT", type: "range" } as unknown as EventTarget;
  expect(isTyping(slider, "ArrowLeft")).toBe(true);
  expect(isTyping(slider, "Mod+Z")).toBe(false);
  expect(isTyping(slider, "F")).toBe(false);
  expect(isTyping(null, "F")).toBe(false);
});

test("an action runs by its key and its name, but not while it makes no sense", () => {
  const work = vi.fn();
  let enabled = true;
  unregister = register([{ name: "t.work", label: "Work", keys: ["W"], run: work, enabled: () => enabled }]);
  expect(press(event("w"))).toBe(true);
  expect(run("t.work")).toBe(true);
  enabled = false;
  expect(press(event("w"))).toBe(false);
  expect(run("t.work")).toBe(false);
  expect(work).toHaveBeenCalledTimes(2);
});

test("two actions of one name are a mistake", () => {
  unregister = register([{ name: "t.a", label: "A", run: () => {} }]);
  expect(() => register([{ name: "t.a", label: "B", run: () => {} }])).toThrow("two actions t.a");
  expect(list()).toHaveLength(1);
});
