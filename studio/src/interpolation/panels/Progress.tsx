import * as actions from "../../actions";
import { Button } from "../../panels/controls";
import type { Session } from "../session";

/** What the kernel is doing, while it does. */
export function Progress({ session }: { session: Session }) {
  const pipeline = session.pipeline.value;
  const stage = pipeline.stage.value;
  const steps = pipeline.progress.value;
  const last = steps.at(-1);
  if (stage !== "fit" || !last) return null;
  return (
    <div class="progress card" data-testid="progress">
      <div class="bar" aria-hidden="true">
        <i />
      </div>
      <span>
        {last.stage}, update {last.iteration}: {last.max.toExponential(1)}
      </span>
      <Button onClick={() => actions.run("fit.cancel")} testid="cancel">
        Stop
      </Button>
    </div>
  );
}
