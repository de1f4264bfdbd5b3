import { Legend as ColourLegend } from "../../panels/Legend";
import { settings } from "../../state/settings";
import type { Session } from "../session";

/** What the colours mean. */
export function Legend({ session }: { session: Session }) {
  const { colouring } = settings.value;
  const values = session.main.values.value;
  if (!colouring || !values) return null;
  return <ColourLegend colouring={colouring} label={values.label} low={values.low} high={values.high} />;
}
