// The commands that every workspace with a surface has: from where one looks, and how it looks.

import type { Action } from "../actions";
import type { Colouring } from "../kernel/api";
import { change, settings, type Shading } from "../state/settings";
import type { Preset, Viewport } from "./viewport";

interface Scene {
  readonly viewport: Viewport;
  show(preset?: Preset): void;
}

/** The directions that have a name, and all that is there. */
export function presetCommands(scene: () => Scene | null): Action[] {
  const view = (preset: Preset, key: string): Action => ({
    name: `view.${preset}`,
    label: `View: ${preset}`,
    keys: [key],
    run: () => scene()?.show(preset),
  });
  return [
    view("front", "Shift+F"),
    view("back", "Shift+B"),
    view("left", "Shift+L"),
    view("right", "Shift+R"),
    view("top", "Shift+T"),
    view("bottom", "Shift+U"),
    view("iso", "Home"),
    { name: "view.fit", label: "View: everything", keys: ["."], run: () => scene()?.show() },
  ];
}

/** Turns by the arrow keys, with `modifier` before them, and zooms. */
export function turnCommands(scene: () => Scene | null, modifier: "" | "Shift+"): Action[] {
  const turn = (name: string, label: string, key: string, right: number, up: number): Action => ({
    name: `view.${name}`,
    label,
    keys: [modifier + key],
    run: () => scene()?.viewport.turn(right, up),
  });
  return [
    turn("turn-left", "Turn the view left", "ArrowLeft", -10, 0),
    turn("turn-right", "Turn the view right", "ArrowRight", 10, 0),
    turn("turn-up", "Turn the view up", "ArrowUp", 0, 10),
    turn("turn-down", "Turn the view down", "ArrowDown", 0, -10),
    { name: "view.nearer", label: "Nearer", keys: ["+", "="], run: () => scene()?.viewport.zoom(1.15) },
    { name: "view.farther", label: "Farther", keys: ["-"], run: () => scene()?.viewport.zoom(1 / 1.15) },
  ];
}

export function upCommand(label: string): Action {
  return {
    name: "view.z-up",
    label,
    keys: ["Y"],
    run: () => change({ up: settings.value.up === "z" ? "y" : "z" }),
    on: () => settings.value.up === "z",
  };
}

export function shadingCommand(name: Shading, label: string, key: string): Action {
  return {
    name: `show.${name}`,
    label,
    keys: [key],
    run: () => change({ shading: name }),
    on: () => settings.value.shading === name,
  };
}

/** A switch for each thing that can be shown or hidden. */
export function showCommands<K extends string>(
  list: readonly (readonly [K, string, string])[],
  isOn: (name: K) => boolean,
  set: (name: K, on: boolean) => void,
): Action[] {
  return list.map(([name, label, key]) => ({
    name: `show.${name}`,
    label: `Show: ${label.toLowerCase()}`,
    keys: [key],
    run: () => set(name, !isOn(name)),
    on: () => isOn(name),
  }));
}

/** The colours to choose from, and the next of them. `current` are those that are seen now. */
export function colourCommands(
  list: readonly (readonly [Colouring, string])[],
  current: () => Colouring | null,
  keys: { readonly [name: string]: string },
): Action[] {
  const names = [null, ...list.map(([name]) => name)];
  return [
    ...[["none", "No colours"] as const, ...list].map(
      ([name, label]): Action => ({
        name: `colour.${name}`,
        label: name === "none" ? label : `Colours: ${label.toLowerCase()}`,
        run: () => change({ colouring: name === "none" ? null : name }),
        on: () => (current() ?? "none") === name,
        ...(keys[name] ? { keys: [keys[name]] } : {}),
      }),
    ),
    {
      name: "colour.next",
      label: "Next colours",
      keys: ["C"],
      run: () => change({ colouring: names[(names.indexOf(current()) + 1) % names.length] ?? null }),
    },
  ];
}
