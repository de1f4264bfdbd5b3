import { expect, test } from "vitest";
import { History } from "../src/state/history";

test("everything can be undone and redone, without limit", () => {
  const history = new History(0);
  for (let i = 1; i <= 5000; i += 1) history.commit(i, `step ${i}`);
  for (let i = 4999; i >= 0; i -= 1) {
    expect(history.undo()).toBe(`step ${i + 1}`);
    expect(history.present.value).toBe(i);
  }
  expect(history.undo()).toBeNull();
  for (let i = 1; i <= 5000; i += 1) history.redo();
  expect(history.present.value).toBe(5000);
  expect(history.redo()).toBeNull();
});

test("a slide is one step, and so is the next one", () => {
  const history = new History(0);
  history.commit(1, "slide", "s");
  history.commit(2, "slide", "s");
  history.commit(3, "slide", "s");
  history.seal();
  history.commit(4, "slide", "s");
  history.commit(5, "slide", "s");
  history.undo();
  expect(history.present.value).toBe(3);
  history.undo();
  expect(history.present.value).toBe(0);
});

test("slides of different things do not join", () => {
  const history = new History(0);
  history.commit(1, "a", "a");
  history.commit(2, "b", "b");
  history.undo();
  expect(history.present.value).toBe(1);
  history.undo();
  expect(history.present.value).toBe(0);
});

test("a change after undo forgets what was undone, also in a slide", () => {
  const history = new History(0);
  history.commit(1, "a", "a");
  history.undo();
  history.commit(2, "a", "a");
  expect(history.redoLabel).toBeNull();
  history.undo();
  expect(history.present.value).toBe(0);
});

test("the same state is no step", () => {
  const history = new History("x");
  history.commit("x", "nothing");
  expect(history.undoLabel).toBeNull();
});
