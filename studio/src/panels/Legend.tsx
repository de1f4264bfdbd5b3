import type { Colouring } from "../kernel/api";
import { gradient, isDiverging, RAMPS } from "../scene/ramps";

/** What colours mean, from the lowest value to the highest. */
export function Legend(props: { colouring: Colouring; label: string; low: number; high: number }) {
  const { colouring, label, low, high } = props;
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

export function short(x: number): string {
  if (x === 0) return "0";
  const size = Math.abs(x);
  return size >= 1e4 || size < 1e-3 ? x.toExponential(1) : String(+x.toPrecision(3));
}
