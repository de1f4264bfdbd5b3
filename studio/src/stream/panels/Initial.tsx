import type { Triple } from "../../kernel/api";
import { Button, Choice, NumberField, Section, Segmented, Slider, Switch } from "../../panels/controls";
import { settings, showStream } from "../../state/settings";
import {
  converted,
  parametersOf,
  replaced,
  rowsOf,
  withRow,
  withRowDeleted,
  withRowInserted,
  type Initial,
  type InitialType,
  type Patch,
  type Start,
} from "../model";
import type { StreamSession } from "../session";

const TYPES: readonly (readonly [InitialType, string])[] = [
  ["polyline", "Polyline"],
  ["bspline", "B-spline"],
  ["nurbs", "NURBS"],
  ["qi", "QI curve"],
];

type StartKind = "min" | "max" | "value" | "fraction";

function startKind(start: Start): StartKind {
  if (start === "min" || start === "max") return start;
  return typeof start === "number" ? "value" : "fraction";
}

/** Where on the streamlines the initial curve lies. */
export function StartSection({ session, patch }: { session: StreamSession; patch: Patch }) {
  const start = patch.s0 ?? "min";
  const kind = startKind(start);
  const s = parametersOf(patch);
  const low = Math.min(...s.map((row) => row[0] ?? 0));
  const high = Math.max(...s.map((row) => row.at(-1) ?? 1));
  const set = (s0: Start, key: string | null = null) => session.change({ s0 }, "Where streamlines start", key);
  return (
    <Section title="Start" id="start">
      <Choice
        label="Curve lies at"
        testid="start"
        value={kind}
        options={[
          ["min", "The beginnings"],
          ["max", "The ends"],
          ["fraction", "A share of each"],
          ["value", "A value of s"],
        ]}
        onChange={(next: StartKind) =>
          set(next === "fraction" ? { fraction: 0.5 } : next === "value" ? (low + high) / 2 : next)
        }
      />
      {kind === "fraction" && typeof start === "object" && (
        <Slider
          label="Share"
          testid="start-fraction"
          value={start.fraction}
          min={0}
          max={1}
          step={0.01}
          format={(x) => String(+x.toFixed(4))}
          onInput={(fraction) => set({ fraction }, "start")}
          onEnd={() => session.seal()}
        />
      )}
      {typeof start === "number" && (
        <Slider
          label="s"
          testid="start-value"
          value={start}
          min={low}
          max={high}
          step={(high - low) / 200}
          format={(x) => String(+x.toPrecision(5))}
          onInput={(x) => set(x, "start")}
          onEnd={() => session.seal()}
        />
      )}
    </Section>
  );
}

/** The curve across the streamlines: its kind, and its points as a table. */
export function InitialSection({ session, patch }: { session: StreamSession; patch: Patch }) {
  const { initial } = patch;
  const rows = rowsOf(initial);
  const set = (next: Initial, label = "Initial curve", key: string | null = null) =>
    session.change({ initial: next }, label, key);
  const count = rows.length;
  const title = initial.type === "qi" ? "Tangents" : "Points";
  return (
    <Section title="Initial curve" id="initial">
      <Switch
        label="Show it, and drag its points"
        testid="initial-shown"
        on={settings.value.stream.initial}
        onChange={(on) => showStream({ initial: on })}
      />
      <Choice
        label="Kind"
        testid="initial-type"
        value={initial.type}
        options={TYPES}
        onChange={(type) => {
          set(converted(initial, type, session.startPlaces(), patch.t), "Kind of the initial curve");
        }}
      />
      {(initial.type === "bspline" || initial.type === "nurbs") && (
        <NumberField
          label="Degree"
          testid="initial-degree"
          value={initial.degree}
          min={1}
          max={count - 1}
          onCommit={(degree) => {
            const next = { ...initial, degree: Math.round(degree) };
            delete next.knots;
            set(next);
          }}
        />
      )}
      {initial.type === "qi" && (
        <>
          <NumberField
            label="Order"
            testid="initial-order"
            value={initial.order}
            min={1}
            max={count}
            onCommit={(order) => set({ ...initial, order: Math.round(order) })}
          />
          <NumberField
            label="Length"
            testid="initial-length"
            value={initial.length}
            min={1e-12}
            onCommit={(length) => set({ ...initial, length })}
          />
          <Segmented
            label="Knots"
            testid="initial-knots"
            value={initial.knots ?? "clamped"}
            options={[
              ["clamped", "Clamped"],
              ["uniform", "Uniform"],
            ]}
            onChange={(knots) => set({ ...initial, knots })}
          />
          <Row
            label="Start"
            testid="initial-start"
            value={initial.start ?? [0, 0, 0]}
            onChange={(start) => set({ ...initial, start })}
          />
        </>
      )}
      <div class="points" role="group" aria-label={title} data-testid="initial-points">
        <span class="points-title">{title}</span>
        {rows.map((row, i) => (
          <div class="points-row" key={i}>
            <Row
              label={String(i + 1)}
              testid={`initial-${i}`}
              value={row}
              onChange={(next) => set(withRow(initial, i, next), "Move the initial curve")}
            />
            {initial.type === "nurbs" && (
              <NumberField
                label={`Weight of point ${i + 1}`}
                hideLabel
                testid={`initial-weight-${i}`}
                value={initial.weights[i] ?? 1}
                min={1e-9}
                onCommit={(w) => set({ ...initial, weights: replaced(initial.weights, i, w) })}
              />
            )}
            {initial.type === "polyline" && (
              <NumberField
                label={`t of point ${i + 1}`}
                hideLabel
                testid={`initial-t-${i}`}
                value={initial.t[i] ?? 0}
                onCommit={(t) => set({ ...initial, t: replaced(initial.t, i, t) })}
              />
            )}
            <Button
              onClick={() => set(withRowInserted(initial, i), "Insert a point")}
              title={`Insert one beside ${i + 1}`}
              testid={`initial-insert-${i}`}
            >
              +
            </Button>
            <Button
              onClick={() => set(withRowDeleted(initial, i), "Delete a point")}
              disabled={withRowDeleted(initial, i) === initial}
              title={`Delete ${i + 1}`}
              testid={`initial-delete-${i}`}
            >
              −
            </Button>
          </div>
        ))}
      </div>
    </Section>
  );
}

/** Three numbers beside one another. */
function Row(props: { label: string; testid: string; value: Triple; onChange: (value: Triple) => void }) {
  return (
    <div class="triple across" role="group" aria-label={props.label}>
      <span class="row-name">{props.label}</span>
      {["x", "y", "z"].map((axis, i) => (
        <NumberField
          key={axis}
          label={`${props.label}, ${axis}`}
          hideLabel
          testid={`${props.testid}-${axis}`}
          value={props.value[i]!}
          format={(x) => String(+x.toPrecision(4))}
          onCommit={(x) => props.onChange(replaced(props.value, i, x) as Triple)}
        />
      ))}
    </div>
  );
}
