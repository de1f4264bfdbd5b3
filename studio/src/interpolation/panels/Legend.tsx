import { gradient, isDiverging, RAMPS } from "../../scene/ramps";
import { settings } from "../../state/settings";
import type { Session } from "../session";

/** What the colours mean. */
export function Legend({ session }: { session: Session }) {
  const { colouring } = settings.value;
  const values = session.main.values.value;
  if (!colouring || !values) return null;
  const ramp = RAMPS[isDiverging(colouring) ? "diverging" : "sequential"];
  const middle = isDiverging(colouring) ? (values.low + values.high) / 2 : null;
  return (
    <figure class="legend card" data-testid="legend">
      <figcaption data-testid="legend-label">{values.label}</figcaption>
      <div class="legend-ramp" style={{ background: gradient(ramp) }} />
      <div class="legend-numbers">
        <span data-testid="legend-low">{short(values.low)}</span>
        {middle !== null && <span>{short(middle)}</span>}
        <span data-testid="legend-high">{short(values.high)}</span>
      </div>
    </figure>
  );
}

export function short(x: number): string {
  if (x === 0) return "0";
  const size = Math.abs(x);
  return size >= 1e4 || size < 1e-3 ? x.toExponential(1) : String(+x.toPrecision(3));
}
