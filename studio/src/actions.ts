// Every command of the studio: a name, words, keys. Menus, buttons, the keyboard and `?` all go through here.

import { signal } from "@preact/signals";
import { isTyping, keyOf } from "./keys";

export interface Action {
  /** Unique, like `select.grow`; what stands before the point is its group. */
  name: string;
  label: string;
  keys?: readonly string[];
  run: () => void;
  /** What it would do now, for its tool tip. */
  detail?: () => string | null;
  /** Whether it makes sense now; it always does if this is left out. */
  enabled?: () => boolean;
  /** For switches: whether it is on. */
  on?: () => boolean;
}

const registered = signal<readonly Action[]>([]);

/** Adds actions; the result takes them away again. A workspace does so while it is open. */
export function register(actions: readonly Action[]): () => void {
  for (const action of actions) {
    if (find(action.name)) throw new Error(`there are two actions ${action.name}`);
  }
  registered.value = [...registered.peek(), ...actions];
  return () => {
    registered.value = registered.peek().filter((action) => !actions.includes(action));
  };
}

export function list(): readonly Action[] {
  return registered.value;
}

export function find(name: string): Action | undefined {
  return registered.peek().find((action) => action.name === name);
}

/** Runs an action if it is there and makes sense now; says whether it did. */
export function run(name: string): boolean {
  const action = find(name);
  if (!action || action.enabled?.() === false) return false;
  action.run();
  return true;
}

export function groupOf(action: Action): string {
  return action.name.split(".")[0]!;
}

/** Answers a key; says whether some action took it. */
export function press(event: KeyboardEvent): boolean {
  const key = keyOf(event);
  if (isTyping(event.target, key)) return false;
  const action = registered
    .peek()
    .find((a) => a.keys?.includes(key) === true && a.enabled?.() !== false);
  if (!action) return false;
  event.preventDefault();
  action.run();
  return true;
}
