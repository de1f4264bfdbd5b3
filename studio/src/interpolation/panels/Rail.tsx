import { ActionButton } from "../../panels/controls";
import type { Session } from "../session";

/** The slim bar of tools on the left. */
export function Rail({ session }: { session: Session }) {
  const target = session.target.value;
  const gesture = session.gesture.value;
  return (
    <div class="rail card" role="toolbar" aria-label="Tools" aria-orientation="vertical">
      <ActionButton name="tool.faces" icon="faces" />
      <ActionButton name="tool.vertices" icon="vertices" />
      <ActionButton name="tool.edges" icon="edges" />
      <hr />
      {target !== "edges" && (
        <>
          <ActionButton name="tool.click" icon="click" />
          <ActionButton name="tool.box" icon="box" />
          <ActionButton name="tool.lasso" icon="lasso" />
          <ActionButton name="tool.brush" icon="brush" />
          {gesture !== "click" && <ActionButton name="tool.through" icon="through" />}
          <hr />
        </>
      )}
      <ActionButton name="show.shaded" icon="shaded" />
      <ActionButton name="show.wire" icon="wire" />
      <ActionButton name="show.zebra" icon="zebra" />
      <ActionButton name="show.reflection" icon="reflection" />
      <hr />
      <ActionButton name="view.fit" icon="fit" />
      <ActionButton name="compare.toggle" icon="compare" />
    </div>
  );
}
