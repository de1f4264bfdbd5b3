import { Button, Choice, NumberField, Section, Slider } from "../../panels/controls";
import { short } from "../../panels/Legend";
import {
  evenPart,
  lengthFunction,
  lengthOf,
  lengthPart,
  parametersOf,
  replaced,
  stepPart,
  type LengthFunction,
  type Patch,
} from "../model";
import type { StreamSession } from "../session";

/** Lengths: of the selected streamline, between its tangents, or as a function of t. */
export function LengthsSection({ session, patch }: { session: StreamSession; patch: Patch }) {
  const { row } = session.place.value;
  const s = parametersOf(patch)[row] ?? [];
  const length = lengthOf(patch, row);
  const range = session.size.value || 1;
  return (
    <Section title={`Lengths of streamline ${row + 1}`} id="lengths">
      <Slider
        label="Length"
        testid="row-length"
        value={length}
        min={range / 100}
        max={range * 10}
        step={0.1}
        scale="log"
        format={(x) => String(+x.toPrecision(5))}
        onInput={(x) => session.change(lengthPart(patch, row, x), "Length of a streamline", `length ${row}`)}
        onEnd={() => session.seal()}
      />
      <NumberField
        label="Parameter t"
        testid="row-t"
        value={patch.t[row] ?? 0}
        onCommit={(t) => session.change({ t: replaced(patch.t, row, t) }, "Parameter of a streamline")}
      />
      <div class="table" role="group" aria-label="From tangent to tangent" data-testid="steps">
        {s.slice(1).map((x, i) => (
          <NumberField
            key={i}
            label={`${i + 1} – ${i + 2}`}
            testid={`step-${i + 1}`}
            value={x - s[i]!}
            format={(x) => String(+x.toPrecision(4))}
            min={1e-12}
            onCommit={(step) => session.change(stepPart(patch, row, i + 1, step), "Distance of tangents")}
          />
        ))}
      </div>
      <div class="buttons">
        <Button onClick={() => session.change(evenPart(patch, row), "Even spacing")} disabled={!patch.s} testid="even">
          Space evenly
        </Button>
      </div>
      <LengthFunctionFields session={session} patch={patch} />
    </Section>
  );
}

function LengthFunctionFields({ session, patch }: { session: StreamSession; patch: Patch }) {
  const f = patch.length;
  const set = (length: LengthFunction | undefined, label = "Length function", key: string | null = null) =>
    session.change({ length }, label, key);
  return (
    <>
      <Choice
        label="As L(t)"
        testid="length-function"
        value={f?.type ?? "none"}
        options={[
          ["none", "As given above"],
          ["polyline", "Linear in between"],
          ["bspline", "B-spline"],
        ]}
        onChange={(type) => set(lengthFunction(patch, type))}
      />
      {f && (
        <>
          {f.type === "bspline" && (
            <NumberField
              label="Degree"
              testid="length-degree"
              value={f.degree}
              min={1}
              max={f.lengths.length - 1}
              onCommit={(degree) => set({ ...f, degree: Math.round(degree) })}
            />
          )}
          <div class="table" role="group" aria-label="Lengths">
            {f.lengths.map((x, i) => (
              <NumberField
                key={i}
                label={f.type === "polyline" ? `t = ${short(f.t[i] ?? 0)}` : `L ${i + 1}`}
                testid={`length-${i}`}
                value={x}
                min={1e-12}
                onCommit={(value) => set({ ...f, lengths: replaced(f.lengths, i, value) })}
              />
            ))}
          </div>
        </>
      )}
    </>
  );
}
