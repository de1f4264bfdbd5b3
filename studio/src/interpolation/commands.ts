// Everything that can be done here by key, by button or from the list of commands.

import type { Action } from "../actions";
import { announce } from "../announce";
import type { Colouring, MeshFormat } from "../kernel/api";
import {
  colourCommands, presetCommands, shadingCommand, showCommands, turnCommands, upCommand,
} from "../scene/commands";
import { settings, show, type Shown } from "../state/settings";
import type { Gesture, Session, Target } from "./session";

export const SHOWN: readonly (readonly [keyof Shown, string, string])[] = [
  ["surface", "Surface", "1"],
  ["patches", "Mesh on the surface", "2"],
  ["points", "Vertices", "3"],
  ["boundary", "Boundary vertices", "4"],
  ["edges", "Given mesh", "5"],
  ["faces", "Faces of the given mesh", "6"],
  ["control", "Control mesh", "7"],
  ["surfaceEdges", "Edges of the surface", "8"],
  ["creases", "Creases", "9"],
];

export const COLOURINGS: readonly (readonly [Colouring, string])[] = [
  ["gaussian", "Gaussian curvature"],
  ["mean", "Mean curvature"],
  ["max-abs", "Largest curvature"],
  ["error", "Distance from the vertices"],
  ["tension", "Tension"],
  ["deviation", "Deviation from the mesh"],
];

export const FORMATS: readonly MeshFormat[] = ["obj", "ply", "stl", "glb", "off"];

export function commands(session: Session): Action[] {
  const has = () => session.mesh.value !== null;
  const hasFaces = () => (session.mesh.value?.faces.length ?? 0) > 0;
  const hasVertices = () => (session.mesh.value?.vertices.length ?? 0) > 0;
  const hasEdges = () => (session.mesh.value?.edges.length ?? 0) > 0;
  const scene = () => session.scene.peek();

  const target = (name: Target, key: string): Action => ({
    name: `tool.${name}`,
    label: `Select ${name}`,
    keys: [key],
    run: () => void (session.target.value = name),
    on: () => session.target.value === name,
  });
  const gesture = (name: Gesture, label: string, key: string): Action => ({
    name: `tool.${name}`,
    label,
    keys: [key],
    run: () => void (session.gesture.value = name),
    on: () => session.gesture.value === name,
  });
  const nudge = (name: string, label: string, key: string, right: number, up: number, near: number): Action => ({
    name: `vertex.${name}`,
    label,
    keys: [key],
    enabled: hasVertices,
    run: () => {
      const viewport = scene()?.viewport;
      if (!viewport) return;
      const step = viewport.radius * 0.01;
      session.nudge(viewport.alongScreen(right * step, up * step, near * step));
    },
  });

  return [
    ...presetCommands(scene),
    upCommand("z is up"),
    ...turnCommands(scene, ""),

    shadingCommand("shaded", "Shaded", "S"),
    shadingCommand("wire", "Wire frame", "W"),
    shadingCommand("zebra", "Zebra stripes", "Z"),
    shadingCommand("reflection", "Reflection lines", "R"),
    ...showCommands(
      SHOWN,
      (name) => settings.value.shown[name],
      (name, on) => show({ [name]: on }),
    ),
    ...colourCommands(COLOURINGS, () => settings.value.colouring, { none: "0", tension: "T" }),

    target("faces", "F"),
    target("vertices", "V"),
    target("edges", "E"),
    gesture("click", "Point at single things", "P"),
    gesture("box", "Select with a box", "B"),
    gesture("lasso", "Select with a lasso", "L"),
    gesture("brush", "Select with a brush", "U"),
    {
      name: "tool.through",
      label: "Select through the surface",
      keys: ["X"],
      run: () => void (session.through.value = !session.through.value),
      on: () => session.through.value,
    },
    {
      name: "tool.wider",
      label: "Wider brush",
      keys: ["]"],
      run: () => void (session.brushRadius.value = Math.min(200, session.brushRadius.value * 1.25)),
    },
    {
      name: "tool.narrower",
      label: "Narrower brush",
      keys: ["["],
      run: () => void (session.brushRadius.value = Math.max(4, session.brushRadius.value / 1.25)),
    },

    { name: "select.all", label: "Select all", keys: ["A", "Mod+A"], enabled: has, run: () => session.selectAll() },
    { name: "select.none", label: "Select nothing", keys: ["Escape"], enabled: has, run: () => session.selectNone() },
    {
      name: "select.invert",
      label: "Invert the selection of faces",
      keys: ["I"],
      enabled: has,
      run: () => session.ask({ kind: "invert" }),
    },
    {
      name: "select.grow",
      label: "Grow the selection of faces",
      keys: ["Shift+ArrowUp"],
      enabled: hasFaces,
      run: () => session.ask({ kind: "grow" }),
    },
    {
      name: "select.shrink",
      label: "Shrink the selection of faces",
      keys: ["Shift+ArrowDown"],
      enabled: hasFaces,
      run: () => session.ask({ kind: "shrink" }),
    },
    {
      name: "select.connected",
      label: "Select connected faces",
      keys: ["K"],
      enabled: hasFaces,
      run: () => session.ask({ kind: "connected" }),
    },
    {
      name: "select.next",
      label: "Select the next one",
      keys: ["N"],
      enabled: has,
      run: () => session.selectNext(1),
    },
    {
      name: "select.previous",
      label: "Select the one before",
      keys: ["Shift+N"],
      enabled: has,
      run: () => session.selectNext(-1),
    },

    {
      name: "tension.more",
      label: "Tighter",
      keys: ["Shift+ArrowRight"],
      enabled: has,
      run: () => session.stepTension(0.05),
    },
    {
      name: "tension.less",
      label: "Looser",
      keys: ["Shift+ArrowLeft"],
      enabled: has,
      run: () => session.stepTension(-0.05),
    },
    { name: "tension.reset", label: "Default tension", enabled: has, run: () => session.setTension(null, null) },

    nudge("right", "Move vertices right", "Alt+ArrowRight", 1, 0, 0),
    nudge("left", "Move vertices left", "Alt+ArrowLeft", -1, 0, 0),
    nudge("up", "Move vertices up", "Alt+ArrowUp", 0, 1, 0),
    nudge("down", "Move vertices down", "Alt+ArrowDown", 0, -1, 0),
    nudge("nearer", "Move vertices nearer", "Alt+PageDown", 0, 0, 1),
    nudge("farther", "Move vertices away", "Alt+PageUp", 0, 0, -1),
    { name: "vertex.reset", label: "Put vertices back", enabled: hasVertices, run: () => session.resetMoves() },

    {
      name: "edge.rim",
      label: "Select the edges around the selected faces",
      enabled: hasFaces,
      run: () => session.edgesAroundFaces(),
    },
    { name: "edge.crease", label: "Mark as crease", keys: ["M"], enabled: hasEdges, run: () => session.setSharpness(-1) },
    {
      name: "edge.smooth",
      label: "Unmark creases",
      keys: ["Shift+M"],
      enabled: hasEdges,
      run: () => session.setSharpness(0),
    },

    {
      name: "fit.cancel",
      label: "Stop fitting",
      keys: ["Mod+."],
      enabled: () => session.pipeline.value.stage.value === "fit",
      run: () => {
        void session.pipeline.value.cancel();
        announce("The fit was stopped");
      },
    },
    { name: "fit.again", label: "Fit again", keys: ["Enter"], enabled: has, run: () => session.pipeline.value.retry() },

    {
      name: "compare.toggle",
      label: "Compare two settings",
      keys: ["D"],
      enabled: has,
      run: () => session.compareWith(session.mesh.value?.compare ? null : (session.mesh.value?.design ?? null)),
      on: () => session.mesh.value?.compare != null,
    },
    {
      name: "compare.swap",
      label: "Swap the two settings",
      enabled: () => session.mesh.value?.compare != null,
      run: () => session.swapSides(),
    },

    ...(["surface", "control"] as const).flatMap((what) =>
      FORMATS.map(
        (format): Action => ({
          name: `file.${what}-${format}`,
          label: `Save the ${what === "surface" ? "surface" : "control mesh"} as ${format.toUpperCase()}`,
          enabled: has,
          run: () => void session.save(what, format),
        }),
      ),
    ),
    { name: "file.picture", label: "Save a picture", keys: ["Mod+P"], enabled: has, run: () => void session.savePicture() },
  ];
}
