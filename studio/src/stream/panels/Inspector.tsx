// The panel on the right: the model, the selected tangent, and how it all becomes a surface.

import { useState } from "preact/hooks";
import type { Triple } from "../../kernel/api";
import { short } from "../../panels/Legend";
import { Look, SaveAs } from "../../panels/Look";
import { ActionButton, Button, Choice, NumberField, Section, Segmented, Slider, Switch } from "../../panels/controls";
import { settings, showStream } from "../../state/settings";
import { COLOURINGS, FORMATS, SWITCHES } from "../commands";
import { patchesOf, stitchOf, withStitch, type Patch, type PatchScheme, type Stitch } from "../model";
import type { StreamSession } from "../session";
import { LengthsSection } from "./Lengths";
import { InitialSection, StartSection } from "./Initial";

const SCHEMES: readonly (readonly [PatchScheme, string])[] = [
  ["doo-sabin", "Doo–Sabin (Chaikin)"],
  ["catmull-clark", "Catmull–Clark (cubic)"],
  ["kobbelt", "Kobbelt (four-point)"],
];

export function Inspector({ session }: { session: StreamSession }) {
  const patch = session.current.value;
  return (
    <aside class="inspector card" aria-label="Inspector" data-testid="inspector">
      <Trouble session={session} />
      {patch ? (
        <>
          <ModelSection session={session} />
          <TangentSection session={session} />
          <RefinementSection session={session} patch={patch} />
          <LengthsSection session={session} patch={patch} />
          <StartSection session={session} patch={patch} />
          <InitialSection session={session} patch={patch} />
          <ShowSection session={session} />
          <SaveSection />
        </>
      ) : (
        <p class="hint">Open a model (*.streamline.json), drop one anywhere, or choose a sample.</p>
      )}
    </aside>
  );
}

function Trouble({ session }: { session: StreamSession }) {
  const trouble = session.trouble.value;
  if (!trouble) return null;
  return (
    <div class="trouble" role="alert" data-testid="trouble">
      <strong>{trouble.message}</strong>
      {trouble.help && <p>{trouble.help}</p>}
      <div class="buttons">
        <ActionButton name="edit.undo" label="Undo" />
        <Button onClick={() => session.retry()} testid="retry">
          Try again
        </Button>
      </div>
    </div>
  );
}

function ModelSection({ session }: { session: StreamSession }) {
  const model = session.model.value;
  const infos = session.infos.value;
  const patch = session.patch.value;
  const info = infos[patch];
  const geometry = session.geometry.value;
  const stitch = stitchOf(model);
  return (
    <Section title="Model" id="model" open>
      {patchesOf(model).length > 1 && (
        <>
          <Choice
            label="Patch"
            testid="patch"
            value={String(patch)}
            options={infos.map((p, i) => [String(i), p.name])}
            onChange={(i) => session.select(session.place.peek(), Number(i))}
          />
          <Choice
            label="Joined"
            testid="stitch"
            value={String(stitch)}
            options={[
              ["false", "Not"],
              ["true", "Along a streamline"],
              ["smooth", "Smoothly"],
            ]}
            onChange={(value) => {
              const next: Stitch = value === "smooth" ? value : value === "true";
              session.commit(withStitch(model, next), "Joining of patches");
            }}
          />
        </>
      )}
      {info && (
        <dl class="numbers">
          <dt>Streamlines × tangents</dt>
          <dd data-testid="tangent-count">
            {info.rowCount} × {info.columnCount}
          </dd>
          <dt>Points of the surface</dt>
          <dd data-testid="point-count">
            {geometry ? `${geometry.rowCount} × ${geometry.columnCount}` : "–"}
          </dd>
        </dl>
      )}
      {info && info.warnings.length > 0 && (
        <ul class="notes" data-testid="warnings">
          {info.warnings.map((warning) => (
            <li key={warning}>{warning}</li>
          ))}
        </ul>
      )}
      <div class="grid-edit">
        <span>Streamline</span>
        <ActionButton name="model.insert-row" label="Insert" />
        <ActionButton name="model.delete-row" label="Delete" />
        <span>Tangents</span>
        <ActionButton name="model.insert-column" label="Insert" />
        <ActionButton name="model.delete-column" label="Delete" />
        <span>Mirror</span>
        <span class="buttons">
          <ActionButton name="model.mirror-x" label="x" />
          <ActionButton name="model.mirror-y" label="y" />
          <ActionButton name="model.mirror-z" label="z" />
        </span>
      </div>
    </Section>
  );
}

const AXES: Record<"x" | "y" | "z", Triple> = { x: [1, 0, 0], y: [0, 1, 0], z: [0, 0, 1] };
type AxisName = keyof typeof AXES | "own";

function TangentSection({ session }: { session: StreamSession }) {
  const tangent = session.tangent.value;
  const { row, column } = session.place.value;
  const info = session.infos.value[session.patch.value];
  const control = session.control.value;
  const level = session.level.value;
  const levels = Array.from(
    { length: Math.min(info?.depth ?? 0, 6) + 1 },
    (_, i) => [String(i), i === 0 ? "Model" : String(i)] as const,
  );
  const details = session.current.value?.details ?? [];
  const [axisName, setAxisName] = useState<AxisName>("y");
  const [degrees, setDegrees] = useState(0);
  if (!tangent || !info) return null;
  const axis = axisName === "own" ? session.axis.value : AXES[axisName];
  return (
    <Section title="Tangent" id="tangent" open>
      {info.depth > 0 && (
        <Segmented
          label="Level of refinement"
          testid="level"
          value={String(level)}
          options={levels}
          onChange={(value) => session.setLevel(Number(value))}
        />
      )}
      {details.length > 0 && (
        <div class="buttons">
          {level > 0 && (
            <Button
              onClick={() => session.removeDetails(false)}
              disabled={!session.isDetail.value}
              testid="remove-detail"
            >
              Take back here
            </Button>
          )}
          <Button onClick={() => session.removeDetails(true)} testid="remove-details">
            Take back all finer ({details.length})
          </Button>
        </div>
      )}
      {session.owner.value === null && (
        <p class="hint" data-testid="follows">
          This streamline goes on smoothly from the patch before, and follows what is turned there.
        </p>
      )}
      <div class="place">
        <Stepper
          label="Streamline"
          testid="row"
          value={row}
          count={control?.rowCount ?? 1}
          onChange={(next) => session.select({ row: next, column })}
        />
        <Stepper
          label="Tangent"
          testid="column"
          value={column}
          count={control?.columnCount ?? 1}
          onChange={(next) => session.select({ row, column: next })}
        />
      </div>
      <div class="components">
        {(["x", "y", "z"] as const).map((name, i) => (
          <Slider
            key={name}
            label={name}
            testid={`tangent-${name}`}
            value={tangent[i]!}
            min={-1}
            max={1}
            step={0.001}
            format={(x) => x.toFixed(3)}
            disabled={session.owner.value === null}
            onInput={(value) => session.setComponent(i as 0 | 1 | 2, value)}
            onEnd={() => session.seal()}
          />
        ))}
      </div>
      <Segmented
        label="Turn about"
        testid="axis"
        value={axisName}
        options={[
          ["x", "x"],
          ["y", "y"],
          ["z", "z"],
          ["own", "Axis"],
        ]}
        onChange={(name) => {
          setAxisName(name);
          if (name !== "own") session.axis.value = AXES[name];
        }}
      />
      {axisName === "own" && (
        <div class="triple across">
          {["x", "y", "z"].map((name, i) => (
            <NumberField
              key={name}
              label={name}
              testid={`axis-${name}-number`}
              value={session.axis.value[i]!}
              onCommit={(value) => {
                const next = [...session.axis.peek()] as Triple;
                next[i] = value;
                session.axis.value = next;
              }}
            />
          ))}
        </div>
      )}
      <Slider
        label="Degrees"
        testid="degrees"
        value={degrees}
        min={-180}
        max={180}
        step={1}
        unit="degrees"
        format={(x) => String(+x.toFixed(3))}
        onInput={(value) => {
          setDegrees(value);
          session.rotate(axis, value);
        }}
        onEnd={() => {
          session.seal();
          setDegrees(0);
        }}
      />
    </Section>
  );
}

/** A number from 1 to `count`, with buttons for the one before and the next. */
function Stepper(props: {
  label: string;
  testid: string;
  value: number;
  count: number;
  onChange: (value: number) => void;
}) {
  const { label, testid, value, count, onChange } = props;
  return (
    <div class="stepper" role="group" aria-label={label}>
      <span>{label}</span>
      <Button
        onClick={() => onChange(value - 1)}
        disabled={value <= 0}
        testid={`${testid}-less`}
        title={`${label} before`}
      >
        ‹
      </Button>
      <select
        aria-label={label}
        value={String(value)}
        data-testid={testid}
        onChange={(e) => onChange(Number(e.currentTarget.value))}
      >
        {Array.from({ length: count }, (_, i) => (
          <option key={i} value={String(i)} selected={i === value}>
            {i + 1}
          </option>
        ))}
      </select>
      <Button
        onClick={() => onChange(value + 1)}
        disabled={value >= count - 1}
        testid={`${testid}-more`}
        title={`Next ${label.toLowerCase()}`}
      >
        ›
      </Button>
    </div>
  );
}

function RefinementSection({ session, patch }: { session: StreamSession; patch: Patch }) {
  // Stitched patches take these from the first.
  const isStitched = session.patches.value.length > 1 && stitchOf(session.model.value) !== false;
  const first = isStitched ? session.patches.value[0]! : patch;
  const set = (part: Partial<Patch>, label: string, key: string | null = null) =>
    isStitched ? session.changeAll(part, label, key) : session.change(part, label, key);
  const scheme = first.scheme ?? "kobbelt";
  return (
    <Section title="Refinement" id="refinement" open>
      <Choice
        label="Scheme"
        testid="scheme"
        value={scheme}
        options={SCHEMES}
        onChange={(next) => set({ scheme: next }, "Scheme")}
      />
      <Slider
        label="Depth"
        testid="depth"
        value={first.depth ?? 3}
        min={0}
        max={6}
        step={1}
        unit="steps"
        onInput={(x) => set({ depth: Math.round(x) }, "Depth", "depth")}
        onEnd={() => session.seal()}
      />
      {scheme === "kobbelt" ? (
        <Slider
          label="Weight w of the four-point rule"
          testid="w"
          value={first.w ?? 1}
          min={0}
          max={2.5}
          step={0.01}
          format={(x) => String(+x.toFixed(3))}
          onInput={(w) => set({ w }, "Weight", "w")}
          onEnd={() => session.seal()}
        />
      ) : (
        <Segmented
          label="Ends"
          testid="ends"
          value={first.ends ?? "natural"}
          options={[
            ["natural", "Natural"],
            ["clamped", "Clamped"],
          ]}
          onChange={(ends) => set({ ends }, "Ends")}
        />
      )}
      <Segmented
        label="Refine first"
        testid="order"
        value={first.order ?? "st"}
        options={[
          ["st", "Along streamlines"],
          ["ts", "Across"],
        ]}
        onChange={(order) => set({ order }, "Order")}
      />
      <Segmented
        label="Several directions become one"
        testid="blend"
        value={first.blend ?? "pairs"}
        options={[
          ["pairs", "In pairs"],
          ["mean", "Spherical mean"],
        ]}
        onChange={(blend) => set({ blend }, "Blend")}
      />
      <Segmented
        label="From tangents to points"
        testid="integration"
        value={first.integration ?? "midpoint"}
        options={[
          ["midpoint", "Midpoints"],
          ["arcs", "Circular arcs"],
        ]}
        onChange={(integration) => set({ integration }, "Integration")}
      />
    </Section>
  );
}

function ShowSection({ session }: { session: StreamSession }) {
  const { stream } = settings.value;
  return (
    <Section title="Show" id="show">
      <Look
        shadings={[
          ["shaded", "Shaded"],
          ["zebra", "Zebra"],
          ["reflection", "Lines"],
        ]}
        colourings={COLOURINGS}
        colouring={session.colouring.value}
      />
      <Segmented
        label="On the sphere"
        testid="sphere"
        value={stream.sphere}
        options={[
          ["row", "Streamline"],
          ["column", "Across"],
          ["all", "All"],
        ]}
        onChange={(sphere) => showStream({ sphere })}
      />
      <div class="switches">
        {SWITCHES.map(([name, label]) => (
          <Switch
            key={name}
            label={label}
            testid={`show-${name}`}
            on={stream[name]}
            onChange={(on) => showStream({ [name]: on })}
          />
        ))}
        <Switch
          label="Turn together"
          testid="show-linked"
          on={stream.linked}
          onChange={(linked) => showStream({ linked })}
        />
      </div>
      <Slider
        label="Length of the arrows"
        testid="arrow-size"
        value={stream.arrowSize}
        min={0.2}
        max={4}
        step={0.1}
        scale="log"
        format={(x) => String(+x.toFixed(2))}
        onInput={(arrowSize) => showStream({ arrowSize })}
      />
      {stream.combs && (
        <Slider
          label="Length of the combs"
          testid="comb-size"
          value={stream.combSize}
          min={0.05}
          max={20}
          step={0.1}
          scale="log"
          format={short}
          onInput={(combSize) => showStream({ combSize })}
        />
      )}
    </Section>
  );
}

function SaveSection() {
  return (
    <Section title="Save" id="save">
      <SaveAs what="surface" label="Surface" formats={FORMATS} />
      <div class="buttons">
        <ActionButton name="file.model" label="Model (JSON)" />
        <ActionButton name="file.picture" label="Picture (PNG)" />
        <ActionButton name="file.save" label="Project" />
        <ActionButton name="file.to-mesh" />
      </div>
    </Section>
  );
}
