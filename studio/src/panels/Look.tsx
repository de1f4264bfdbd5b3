// Parts of the inspector that both workspaces have.

import type { Colouring, MeshFormat } from "../kernel/api";
import { change, settings, type Shading } from "../state/settings";
import { ActionButton, Choice, Segmented } from "./controls";

/** How surfaces are shaded and coloured. `colouring` are the colours that are seen now. */
export function Look(props: {
  shadings: readonly (readonly [Shading, string])[];
  colourings: readonly (readonly [Colouring, string])[];
  colouring: Colouring | null;
}) {
  return (
    <>
      <Segmented
        label="Shading"
        testid="shading"
        value={settings.value.shading}
        options={props.shadings}
        onChange={(shading) => change({ shading })}
      />
      <Choice
        label="Colours"
        testid="colouring"
        value={props.colouring ?? "none"}
        options={[["none", "None"], ...props.colourings]}
        onChange={(value) => change({ colouring: value === "none" ? null : value })}
      />
    </>
  );
}

/** Buttons for the formats in which something can be saved, by the actions `file.WHAT-FORMAT`. */
export function SaveAs(props: { what: string; label: string; formats: readonly MeshFormat[] }) {
  return (
    <div class="field row">
      <span>{props.label}</span>
      <div class="buttons">
        {props.formats.map((format) => (
          <ActionButton key={format} name={`file.${props.what}-${format}`} label={format.toUpperCase()} />
        ))}
      </div>
    </div>
  );
}
