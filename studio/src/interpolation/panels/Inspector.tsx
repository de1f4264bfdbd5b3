// The panel on the right: everything about the mesh and its surface, in the order in which one meets it.

import { useState } from "preact/hooks";
import type { Design, Fineness, Method, Scheme } from "../../kernel/api";
import { problemOf, sentence } from "../../kernel/problem";
import { ActionButton, Button, Choice, NumberField, Section, Segmented, Slider, Switch } from "../../panels/controls";
import { short } from "../../panels/Legend";
import { Look, SaveAs } from "../../panels/Look";
import { change, settings, show } from "../../state/settings";
import { COLOURINGS, FORMATS, SHOWN } from "../commands";
import { counted, TENSIONS, type Session } from "../session";
import { Plot } from "./Plot";

const SCHEMES: readonly (readonly [Scheme, string])[] = [
  ["loop", "Loop"],
  ["catmull-clark", "Catmull–Clark"],
  ["doo-sabin", "Doo–Sabin"],
  ["butterfly", "Butterfly"],
  ["kobbelt", "Kobbelt"],
];

const METHODS: readonly (readonly [Method, string])[] = [
  ["auto", "Automatic"],
  ["plain", "Progressive"],
  ["weighted", "Weighted"],
  ["chebyshev", "Chebyshev"],
  ["cg", "Conjugate gradients"],
  ["one-pass", "One pass"],
];

export function Inspector({ session }: { session: Session }) {
  const mesh = session.mesh.value;
  const design = session.design.value;
  return (
    <aside class="inspector card" aria-label="Inspector" data-testid="inspector">
      {mesh?.compare && (
        <div class="sides">
          <Segmented
            label="Settings"
            hideLabel
            testid="side"
            value={session.side.value}
            options={[
              ["a", "A, left"],
              ["b", "B, right"],
            ]}
            onChange={(side) => void (session.side.value = side)}
          />
          <ActionButton name="compare.swap" label="Swap" />
        </div>
      )}
      <Trouble session={session} />
      {mesh && design ? (
        <>
          <MeshSection session={session} />
          <FitSection session={session} design={design} />
          <SurfaceSection session={session} fineness={mesh.fineness} />
          <ShowSection />
          <SelectionSection session={session} />
          <TensionSection session={session} design={design} />
          <VertexSection session={session} />
          <EdgeSection session={session} design={design} />
          <SaveSection />
        </>
      ) : (
        <p class="hint">Open a mesh, drop one anywhere, or choose a sample.</p>
      )}
    </aside>
  );
}

function Trouble({ session }: { session: Session }) {
  const pipeline = session.pipeline.value;
  const trouble = pipeline.trouble.value;
  if (pipeline.stopped.value) {
    return (
      <div class="trouble" role="alert" data-testid="stopped">
        <strong>The fit was stopped.</strong>
        <p>What you see belongs to the settings before.</p>
        <Button onClick={() => pipeline.retry()} testid="retry">
          Fit again
        </Button>
      </div>
    );
  }
  if (!trouble) return null;
  return (
    <div class="trouble" role="alert" data-testid="trouble">
      <strong>{sentence(trouble.message)}</strong>
      {trouble.help && <p>{sentence(trouble.help)}</p>}
      <Button onClick={() => pipeline.retry()} testid="retry">
        Try again
      </Button>
    </div>
  );
}

function MeshSection({ session }: { session: Session }) {
  const info = session.main.info.value;
  if (!info) return null;
  const size = info.max.map((x, i) => short(x - info.min[i]!)).join(" × ");
  return (
    <Section title="Mesh" id="mesh" open>
      <dl class="numbers" data-testid="mesh-numbers">
        <dt>Vertices</dt>
        <dd data-testid="vertex-count">{info.vertexCount.toLocaleString("en")}</dd>
        <dt>Faces</dt>
        <dd data-testid="face-count">{info.faceCount.toLocaleString("en")}</dd>
        <dt>Corners</dt>
        <dd>
          {info.leastCorners === info.mostCorners ? info.mostCorners : `${info.leastCorners} to ${info.mostCorners}`}
        </dd>
        <dt>Boundaries</dt>
        <dd>{info.boundaryLoopCount}</dd>
        <dt>Parts</dt>
        <dd>{info.componentCount}</dd>
        <dt>Size</dt>
        <dd>{size}</dd>
      </dl>
      {info.notes.length > 0 && (
        <ul class="notes">
          {info.notes.map((note) => (
            <li key={note}>{note}</li>
          ))}
        </ul>
      )}
    </Section>
  );
}

function FitSection({ session, design }: { session: Session; design: Design }) {
  const pipeline = session.pipeline.value;
  const fit = pipeline.fit.value;
  const history = pipeline.progress.value;
  const updates = fit?.history.at(-1)?.iteration ?? 0;
  const set = session.setDesign.bind(session);
  const info = session.main.info.value;
  const most = info?.mostCorners ?? 3;
  const hasQuadsOnly = most === 4 && info?.leastCorners === 4;
  const suits = (name: Scheme) =>
    name === "kobbelt" ? hasQuadsOnly : most === 3 || (name !== "loop" && name !== "butterfly");
  const iteration = session.iteration.value;
  const isMain = session.side.value === "a";
  return (
    <Section title="Interpolation" id="fit" open>
      <Choice
        label="Scheme"
        testid="scheme"
        value={design.scheme}
        options={SCHEMES.filter(([name]) => name === design.scheme || suits(name))}
        onChange={(scheme) => set({ scheme, tension: null, tensions: [] }, "Scheme")}
      />
      <Choice
        label="Method"
        testid="method"
        value={design.method}
        options={METHODS}
        onChange={(method) => set({ method }, "Method")}
      />
      <Slider
        label="Tolerance"
        testid="tolerance"
        value={design.tolerance}
        min={1e-14}
        max={1e-2}
        step={1e-14}
        scale="log"
        format={(x) => x.toExponential(1).replace(".0e", "e")}
        onInput={(tolerance) => set({ tolerance }, "Tolerance", "tolerance")}
        onEnd={() => session.seal()}
      />
      <NumberField
        label="Most updates"
        testid="iterations"
        value={design.iterations}
        min={1}
        max={1_000_000}
        onCommit={(x) => set({ iterations: Math.round(x) }, "Most updates")}
      />
      <Switch
        label="Exact, up to rounding"
        testid="exact"
        on={design.exact}
        onChange={(exact) => set({ exact }, exact ? "Exact" : "Not exact")}
      />
      <Switch
        label="Fair"
        testid="fair"
        on={design.fair !== null}
        onChange={(on) => set({ fair: on ? 0.5 : null }, on ? "Fair" : "Not fair")}
      />
      {design.fair !== null && (
        <Slider
          label="Fairness"
          testid="fairness"
          value={design.fair}
          min={0}
          max={1}
          step={0.01}
          onInput={(fair) => set({ fair }, "Fairness", "fair")}
          onEnd={() => session.seal()}
        />
      )}
      {(info?.boundaryLoopCount ?? 0) > 0 && (
        <>
          <Segmented
            label="Corners"
            testid="corners"
            value={design.corners}
            options={[
              ["smooth", "Smooth"],
              ["sharp", "Sharp"],
            ]}
            onChange={(corners) => set({ corners }, "Corners")}
          />
          {design.scheme === "doo-sabin" && (
            <Choice
              label="Border"
              testid="border"
              value={design.border}
              options={[
                ["bspline", "B-spline"],
                ["drop", "Dropped"],
                ["none", "None"],
              ]}
              onChange={(border) => set({ border }, "Border")}
            />
          )}
        </>
      )}
      {fit && (
        <>
          <dl class="numbers" data-testid="fit-numbers">
            <dt>Updates</dt>
            <dd data-testid="fit-iterations">{updates}</dd>
            <dt>Largest error</dt>
            <dd data-testid="fit-max">{fit.max.toExponential(2)}</dd>
            <dt>Mean error</dt>
            <dd data-testid="fit-mean">{fit.mean.toExponential(2)}</dd>
            <dt>Time</dt>
            <dd data-testid="fit-ms">{fit.milliseconds.toFixed(1)} ms</dd>
            <dt>Control mesh</dt>
            <dd>
              {fit.controlVertexCount.toLocaleString("en")} vertices
              {fit.controlLevel > 0 ? `, level ${fit.controlLevel}` : ""}
            </dd>
          </dl>
          {!fit.converged && (
            <p class="warning" data-testid="not-converged">
              It has not converged: raise the tolerance or allow more updates.
            </p>
          )}
          {fit.notes.map((note) => (
            <p class="hint" key={note}>
              {note}
            </p>
          ))}
        </>
      )}
      <Plot history={history} tolerance={design.tolerance} at={isMain ? iteration : null} />
      {isMain && fit && updates > 0 && (
        <Slider
          label="Replay"
          testid="replay"
          value={iteration ?? updates}
          min={0}
          max={updates}
          step={1}
          onInput={(at) => void (session.iteration.value = at >= updates ? null : at)}
        />
      )}
      <div class="buttons">
        <ActionButton name="compare.toggle" label={session.mesh.value?.compare ? "End the comparison" : "Compare…"} />
      </div>
    </Section>
  );
}

function SurfaceSection({ session, fineness }: { session: Session; fineness: Fineness }) {
  const surface = session.main.surface.value;
  return (
    <Section title="Surface" id="surface" open>
      <Slider
        label="Levels"
        testid="levels"
        value={fineness.levels}
        min={0}
        max={6}
        step={1}
        onInput={(levels) => session.setFineness({ levels: Math.round(levels) }, "levels")}
        onEnd={() => session.seal()}
      />
      <Segmented
        label="Points"
        testid="points"
        value={fineness.limit ? "limit" : "polygon"}
        options={[
          ["limit", "Limit surface"],
          ["polygon", "Polygon mesh"],
        ]}
        onChange={(kind) => session.setFineness({ limit: kind === "limit" })}
      />
      {surface && (
        <p class="hint" data-testid="surface-numbers">
          {(surface.positions.length / 3).toLocaleString("en")} points,{" "}
          {(surface.triangles.length / 3).toLocaleString("en")} triangles
        </p>
      )}
    </Section>
  );
}

function ShowSection() {
  const { shown, colouring, up } = settings.value;
  return (
    <Section title="Show" id="show" open>
      <Look
        shadings={[
          ["shaded", "Shaded"],
          ["wire", "Wire"],
          ["zebra", "Zebra"],
          ["reflection", "Lines"],
        ]}
        colourings={COLOURINGS}
        colouring={colouring}
      />
      <div class="switches">
        {SHOWN.map(([name, label]) => (
          <Switch
            key={name}
            label={label}
            testid={`show-${name}`}
            on={shown[name]}
            onChange={(on) => show({ [name]: on })}
          />
        ))}
        <Switch label="z is up" testid="z-up" on={up === "z"} onChange={(on) => change({ up: on ? "z" : "y" })} />
      </div>
    </Section>
  );
}

function SelectionSection({ session }: { session: Session }) {
  const mesh = session.mesh.value!;
  const groups = session.main.info.value?.groups ?? [];
  const [text, setText] = useState("");
  const [wrong, setWrong] = useState("");
  const parts = (["faces", "vertices", "edges"] as const)
    .filter((kind) => mesh[kind].length > 0)
    .map((kind) => counted(mesh[kind].length, kind));
  const submit = (e: Event) => {
    e.preventDefault();
    setWrong("");
    session.query({ kind: "expression", text }).catch((error: unknown) => {
      const { message, help } = problemOf(error);
      setWrong(help ? `${message} ${help}` : message);
    });
  };
  return (
    <Section title="Selection" id="selection">
      <p class="hint" data-testid="selection-count">
        {parts.length > 0 ? parts.join(", ") : "Nothing is selected."}
      </p>
      <div class="buttons">
        <ActionButton name="select.all" label="All" />
        <ActionButton name="select.none" label="None" />
        <ActionButton name="select.invert" label="Invert" />
        <ActionButton name="select.grow" label="Grow" />
        <ActionButton name="select.shrink" label="Shrink" />
        <ActionButton name="select.connected" label="Connected" />
      </div>
      {groups.length > 0 && (
        <Choice
          label="Group"
          testid="group"
          value=""
          options={[
            ["", "Choose…"],
            ...groups.map((g, i) => [String(i), `${g.name || "(no name)"} · ${g.faceCount}`] as [string, string]),
          ]}
          onChange={(i) => {
            const group = groups[Number(i)];
            if (i !== "" && group) session.selectGroup(group.kind, group.name);
          }}
        />
      )}
      <form class="expression" onSubmit={submit}>
        <label class="field">
          <span>Expression</span>
          <input
            type="text"
            placeholder="z>0.5 and not boundary"
            value={text}
            spellcheck={false}
            aria-invalid={wrong !== ""}
            data-testid="expression"
            onInput={(e) => setText(e.currentTarget.value)}
          />
        </label>
        <button type="submit" class="button" data-testid="expression-go">
          Select
        </button>
      </form>
      {wrong && (
        <p class="warning" role="alert" data-testid="expression-wrong">
          {wrong}
        </p>
      )}
      <Slider
        label="Brush"
        testid="brush"
        value={Math.round(session.brushRadius.value)}
        min={4}
        max={200}
        step={1}
        unit="pixels"
        onInput={(r) => void (session.brushRadius.value = r)}
      />
      <Switch
        label="Through the surface"
        testid="through"
        on={session.through.value}
        onChange={(on) => void (session.through.value = on)}
      />
    </Section>
  );
}

function TensionSection({ session, design }: { session: Session; design: Design }) {
  const range = TENSIONS[design.scheme];
  const mesh = session.mesh.value!;
  if (!range) return null;
  const selected = mesh.faces.length;
  return (
    <Section title="Tension" id="tension">
      <Slider
        label={selected > 0 ? `Tension of ${counted(selected, "faces")}` : "Tension of all faces"}
        testid="tension"
        value={session.tension.value}
        min={range.min}
        max={range.max}
        step={0.01}
        format={(x) => String(+x.toFixed(3))}
        onInput={(value) => session.setTension(value)}
        onEnd={() => session.seal()}
      />
      <Slider
        label="Falloff"
        testid="falloff"
        value={session.falloff.value}
        min={0}
        max={12}
        step={0.25}
        unit="edges"
        onInput={(value) => session.setFalloff(value)}
        onEnd={() => session.seal()}
      />
      <Switch
        label="Heat map of the tension"
        testid="heat-map"
        on={settings.value.colouring === "tension"}
        onChange={(on) => change({ colouring: on ? "tension" : null })}
      />
      <div class="buttons">
        <ActionButton name="tension.reset" label="Default" />
      </div>
      {design.tensions.length > 0 && <p class="hint">{design.tensions.length} faces have their own.</p>}
    </Section>
  );
}

function VertexSection({ session }: { session: Session }) {
  const mesh = session.mesh.value!;
  const first = mesh.vertices[0];
  const place = first === undefined ? null : session.placeOf(first);
  return (
    <Section title="Vertices" id="vertices">
      {place ? (
        <>
          <p class="hint">
            {mesh.vertices.length === 1
              ? `Vertex ${first}`
              : `Vertex ${first}, and ${mesh.vertices.length - 1} that move with it`}
          </p>
          <div class="triple">
            {(["x", "y", "z"] as const).map((axis, i) => (
              <NumberField
                key={`${axis}${first}`}
                label={axis}
                testid={`vertex-${axis}`}
                value={place[i]!}
                onCommit={(value) => session.typeCoordinate(i as 0 | 1 | 2, value)}
              />
            ))}
          </div>
          <div class="buttons">
            <ActionButton name="vertex.reset" label="Put back" />
          </div>
        </>
      ) : (
        <p class="hint">
          Select vertices (key V), then drag the handles, press Alt and an arrow, or type where they shall be. The
          surface follows.
        </p>
      )}
    </Section>
  );
}

function EdgeSection({ session, design }: { session: Session; design: Design }) {
  const mesh = session.mesh.value!;
  const ends = session.main.given.value?.ends;
  const first = mesh.edges[0];
  let sharpness = 0;
  if (first !== undefined && ends) {
    const [a, b] = [ends[2 * first]!, ends[2 * first + 1]!];
    sharpness = design.creases.find(([p, q]) => (p === a && q === b) || (p === b && q === a))?.[2] ?? 0;
  }
  return (
    <Section title="Creases" id="edges">
      {mesh.edges.length > 0 ? (
        <>
          <Slider
            label={`Sharpness of ${counted(mesh.edges.length, "edges")}`}
            testid="sharpness"
            value={sharpness < 0 ? 10 : sharpness}
            min={0}
            max={10}
            step={0.1}
            format={(x) => (x >= 10 ? "∞" : String(+x.toFixed(2)))}
            onInput={(x) => session.setSharpness(x >= 10 ? -1 : x, "sharpness")}
            onEnd={() => session.seal()}
          />
          <div class="buttons">
            <ActionButton name="edge.crease" label="Crease" />
            <ActionButton name="edge.smooth" label="Smooth" />
          </div>
        </>
      ) : (
        <p class="hint">Select edges (key E), or take those around the selected faces.</p>
      )}
      <div class="buttons">
        <ActionButton name="edge.rim" label="Edges around the faces" />
      </div>
      {design.creases.length > 0 && <p class="hint">{design.creases.length} edges are creases.</p>}
    </Section>
  );
}

/** Those that have a button; OFF is among the commands. */
const SAVED = FORMATS.filter((format) => format !== "off");

function SaveSection() {
  return (
    <Section title="Save" id="save">
      <SaveAs what="surface" label="Surface" formats={SAVED} />
      <SaveAs what="control" label="Control mesh" formats={SAVED} />
      <div class="buttons">
        <ActionButton name="file.picture" label="Picture (PNG)" />
        <ActionButton name="file.save" label="Project" />
      </div>
    </Section>
  );
}
