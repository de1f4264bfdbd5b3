import { Legend as ColourLegend } from "../../panels/Legend";
import type { StreamSession } from "../session";

/** What the colours mean. */
export function Legend({ session }: { session: StreamSession }) {
  const colouring = session.colouring.value;
  const label = session.values.value?.[0]?.label;
  const [low, high] = session.range.value;
  if (!colouring || label === undefined) return null;
  return <ColourLegend colouring={colouring} label={label} low={low} high={high} />;
}
