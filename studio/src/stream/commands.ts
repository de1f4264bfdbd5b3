// Everything that can be done here by key, by button or from the list of commands.

import type { Action } from "../actions";
import type { Colouring, MeshFormat, Triple } from "../kernel/api";
import {
  colourCommands, presetCommands, shadingCommand, showCommands, turnCommands, upCommand,
} from "../scene/commands";
import { settings, showStream } from "../state/settings";
import type { StreamSession } from "./session";
import type { StreamShown } from "./shown";

type Switches = { [K in keyof StreamShown]: StreamShown[K] extends boolean ? K : never }[keyof StreamShown];

export const SWITCHES: readonly (readonly [Switches, string, string])[] = [
  ["surface", "Surface", "1"],
  ["streamlines", "Streamlines", "2"],
  ["fine", "All refined streamlines", "3"],
  ["arrows", "Tangents", "4"],
  ["initial", "Initial curve", "5"],
  ["combs", "Curvature combs", "6"],
  ["arcs", "Great arcs on the sphere", "7"],
  ["curves", "Refined tangents on the sphere", "8"],
  ["wire", "Wire frame", "9"],
];

export const COLOURINGS: readonly (readonly [Colouring, string])[] = [
  ["gaussian", "Gaussian curvature"],
  ["mean", "Mean curvature"],
  ["max-abs", "Largest curvature"],
];

export const FORMATS: readonly MeshFormat[] = ["obj", "ply", "stl", "glb"];

/** Degrees by which a key turns a tangent. */
const STEP = 2;

export function commands(session: StreamSession): Action[] {
  const has = () => session.current.value !== null;
  const scene = () => session.scene.peek();

  const step = (name: string, label: string, key: string, rows: number, columns: number): Action => ({
    name: `tangent.${name}`,
    label,
    keys: [key],
    enabled: has,
    run: () => session.step(rows, columns),
  });
  /** About an axis of the screen, as it stands. */
  const turn = (name: string, label: string, key: string, axis: Triple, degrees: number): Action => ({
    name: `tangent.${name}`,
    label,
    keys: [key],
    enabled: has,
    run: () => {
      const about = scene()?.viewport.alongScreen(...axis);
      if (about) session.turn(about, degrees);
    },
  });
  const structure = (
    name: "insert-row" | "insert-column" | "delete-row" | "delete-column",
    label: string,
    key: string,
  ): Action => ({
    name: `model.${name}`,
    label,
    keys: [key],
    enabled: has,
    run: () => void session.changeGrid(name, label),
  });
  const mirror = (axis: string, normal: Triple): Action => ({
    name: `model.mirror-${axis}`,
    label: `Mirror in ${axis}`,
    enabled: has,
    run: () => void session.edit({ kind: "mirror", patch: session.patch.peek(), normal }, `Mirror in ${axis}`),
  });
  const sphere = (name: StreamShown["sphere"], label: string, key: string): Action => ({
    name: `sphere.${name}`,
    label,
    keys: [key],
    run: () => showStream({ sphere: name }),
    on: () => settings.value.stream.sphere === name,
  });

  return [
    ...presetCommands(scene),
    ...turnCommands(scene, "Shift+"),
    upCommand("The z axis points up"),

    shadingCommand("shaded", "Shaded", "S"),
    shadingCommand("zebra", "Zebra stripes", "Z"),
    shadingCommand("reflection", "Reflection lines", "R"),
    ...showCommands(
      SWITCHES,
      (name) => settings.value.stream[name],
      (name, on) => showStream({ [name]: on }),
    ),
    ...colourCommands(COLOURINGS, () => session.colouring.value, { none: "0" }),

    sphere("row", "Sphere: the streamline", "W"),
    sphere("column", "Sphere: across the streamlines", "X"),
    sphere("all", "Sphere: all tangents", "A"),
    {
      name: "sphere.linked",
      label: "Sphere and surface turn together",
      keys: ["L"],
      run: () => showStream({ linked: !settings.value.stream.linked }),
      on: () => settings.value.stream.linked,
    },

    step("next", "Next tangent of the streamline", "ArrowRight", 0, 1),
    step("previous", "Tangent before", "ArrowLeft", 0, -1),
    step("next-row", "Next streamline", "ArrowDown", 1, 0),
    step("previous-row", "Streamline before", "ArrowUp", -1, 0),
    turn("right", "Turn the tangent right", "Alt+ArrowRight", [0, 1, 0], STEP),
    turn("left", "Turn the tangent left", "Alt+ArrowLeft", [0, 1, 0], -STEP),
    turn("up", "Turn the tangent up", "Alt+ArrowUp", [1, 0, 0], -STEP),
    turn("down", "Turn the tangent down", "Alt+ArrowDown", [1, 0, 0], STEP),
    {
      name: "tangent.about",
      label: "Turn the tangent about the axis",
      keys: ["Alt+PageUp"],
      enabled: has,
      run: () => session.turn(session.axis.peek(), STEP),
    },
    {
      name: "tangent.about-back",
      label: "Turn the tangent back about the axis",
      keys: ["Alt+PageDown"],
      enabled: has,
      run: () => session.turn(session.axis.peek(), -STEP),
    },

    structure("insert-row", "Insert a streamline", "Insert"),
    structure("delete-row", "Delete the streamline", "Delete"),
    structure("insert-column", "Insert a tangent on every streamline", "Shift+Insert"),
    structure("delete-column", "Delete a tangent of every streamline", "Shift+Delete"),
    mirror("x", [1, 0, 0]),
    mirror("y", [0, 1, 0]),
    mirror("z", [0, 0, 1]),
    {
      name: "model.next-patch",
      label: "Next patch",
      keys: ["N"],
      enabled: () => session.patches.value.length > 1,
      run: () => session.select(session.place.peek(), (session.patch.peek() + 1) % session.patches.peek().length),
    },

    ...FORMATS.map(
      (format): Action => ({
        name: `file.surface-${format}`,
        label: `Save the surface as ${format.toUpperCase()}`,
        enabled: has,
        run: () => void session.save(format),
      }),
    ),
    {
      name: "file.model",
      label: "Save the model",
      keys: ["Mod+Shift+S"],
      enabled: has,
      run: () => void session.saveModel(),
    },
    {
      name: "file.to-mesh",
      label: "To the interpolation workspace",
      keys: ["Mod+Enter"],
      enabled: has,
      run: () => void session.toMesh(),
    },
    {
      name: "file.picture",
      label: "Save a picture",
      keys: ["Mod+P"],
      enabled: has,
      run: () => void session.savePicture(),
    },
  ];
}
