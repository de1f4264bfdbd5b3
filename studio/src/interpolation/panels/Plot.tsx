import type { Progress } from "../../kernel/api";

const W = 264;
const H = 120;
const LEFT = 34;
const BOTTOM = 16;

/** Largest and mean error over the updates, on a logarithmic scale; a line where the replay stands. */
export function Plot(props: { history: readonly Progress[]; tolerance: number; at: number | null }) {
  const { history, tolerance, at } = props;
  if (history.length < 2) return null;
  const positive = history.flatMap((p) => [p.max, p.mean]).filter((x) => x > 0);
  const high = Math.ceil(Math.log10(Math.max(...positive, tolerance)));
  const low = Math.max(high - 18, Math.floor(Math.log10(Math.min(...positive, tolerance))));
  const updates = Math.max(1, history.at(-1)!.iteration);
  const x = (iteration: number) => LEFT + (iteration / updates) * (W - LEFT - 4);
  const y = (value: number) => {
    const t = (Math.log10(Math.max(value, 10 ** low)) - low) / Math.max(1, high - low);
    return 4 + (1 - t) * (H - BOTTOM - 4);
  };
  const line = (of: (p: Progress) => number) =>
    history.map((p, i) => `${i ? "L" : "M"}${x(p.iteration).toFixed(1)} ${y(of(p)).toFixed(1)}`).join("");
  const every = Math.max(1, Math.ceil((high - low) / 4));
  const ticks: number[] = [];
  for (let e = high; e >= low; e -= every) ticks.push(e);
  const last = history.at(-1)!;
  return (
    <svg
      class="plot"
      viewBox={`0 0 ${W} ${H}`}
      role="img"
      aria-label={`Error over ${updates} updates: largest ${last.max.toExponential(1)}, mean ${last.mean.toExponential(1)} at the end`}
      data-testid="plot"
    >
      {ticks.map((e) => (
        <g key={e}>
          <line class="grid" x1={LEFT} x2={W - 4} y1={y(10 ** e)} y2={y(10 ** e)} />
          <text x={LEFT - 5} y={y(10 ** e) + 3} text-anchor="end">
            1e{e}
          </text>
        </g>
      ))}
      <line class="goal" x1={LEFT} x2={W - 4} y1={y(tolerance)} y2={y(tolerance)} />
      <path class="mean" d={line((p) => p.mean)} />
      <path class="max" d={line((p) => p.max)} />
      {at !== null && <line class="now" x1={x(Math.min(at, updates))} x2={x(Math.min(at, updates))} y1={4} y2={H - BOTTOM} />}
      <text x={LEFT} y={H - 3}>
        0
      </text>
      <text x={W - 4} y={H - 3} text-anchor="end">
        {updates}
      </text>
      <text class="key max" x={W - 66} y={13}>
        max
      </text>
      <text class="key mean" x={W - 36} y={13}>
        mean
      </text>
    </svg>
  );
}
