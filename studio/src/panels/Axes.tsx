import type { ReadonlySignal } from "@preact/signals";
import type { Triple } from "../kernel/api";
import { settings } from "../state/settings";
import type { Preset } from "../scene/viewport";

const AXES = [
  { name: "x", colour: "#e5484d", to: "right", from: "left" },
  { name: "y", colour: "#46a758", to: "top", from: "bottom" },
  { name: "z", colour: "#3e7bfa", to: "front", from: "back" },
] as const satisfies readonly { name: string; colour: string; to: Preset; from: Preset }[];

/** Which view looks along an axis when z is up. */
const WITH_Z_UP: Partial<Record<Preset, Preset>> = { top: "back", bottom: "front", front: "top", back: "bottom" };

/** Where x, y and z point; their ends are buttons that look along them. */
export function Axes(props: { turns: ReadonlySignal<readonly Triple[]>; onView: (preset: Preset) => void }) {
  const turns = props.turns.value;
  if (turns.length < 3) return null;
  const along = (preset: Preset) => (settings.value.up === "z" ? (WITH_Z_UP[preset] ?? preset) : preset);
  const ends = AXES.flatMap((axis, i) => {
    const [x, y, z] = turns[i]!;
    return [
      { axis, preset: along(axis.to), x: 42 + 30 * x, y: 42 - 30 * y, near: z, isFirst: true },
      { axis, preset: along(axis.from), x: 42 - 30 * x, y: 42 + 30 * y, near: -z, isFirst: false },
    ];
  }).sort((a, b) => a.near - b.near);
  const activate = (preset: Preset) => (e: KeyboardEvent) => {
    if (e.key !== "Enter" && e.key !== " ") return;
    e.preventDefault();
    e.stopPropagation();
    props.onView(preset);
  };
  return (
    <svg class="axes" viewBox="0 0 84 84" role="group" aria-label="Views along the axes" data-testid="axes">
      {ends.map(({ axis, preset, x, y, near, isFirst }) => (
        <g
          key={preset}
          role="button"
          tabIndex={0}
          aria-label={`View: ${preset}`}
          data-testid={`axis-${preset}`}
          opacity={0.62 + 0.38 * near}
          onClick={() => props.onView(preset)}
          onKeyDown={activate(preset)}
        >
          {isFirst && <line x1="42" y1="42" x2={x} y2={y} stroke={axis.colour} />}
          <circle cx={x} cy={y} r={isFirst ? 9 : 6.5} fill={axis.colour} fill-opacity={isFirst ? 1 : 0.35} />
          {isFirst && (
            <text x={x} y={y}>
              {axis.name}
            </text>
          )}
        </g>
      ))}
    </svg>
  );
}
