import { short } from "../../interpolation/panels/Legend";
import { gradient, isDiverging, RAMPS } from "../../scene/ramps";
import type { StreamSession } from "../session";

/** What the colours mean. */
export function Legend({ session }: { session: StreamSession }) {
  const colouring = session.colouring.value;
  const label = session.values.value?.[0]?.label;
  const [low, high] = session.range.value;
  if (!colouring || label === undefined) return null;
  const signed = isDiverging(colouring);
  return (
    <figure class="legend card" data-testid="legend">
      <figcaption data-testid="legend-label">{label}</figcaption>
      <div class="legend-ramp" style={{ background: gradient(RAMPS[signed ? "diverging" : "sequential"]) }} />
      <div class="legend-numbers">
        <span data-testid="legend-low">{short(low)}</span>
        {signed && <span>{short((low + high) / 2)}</span>}
        <span data-testid="legend-high">{short(high)}</span>
      </div>
    </figure>
  );
}
