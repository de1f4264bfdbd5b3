import { ActionButton } from "../../panels/controls";

/** The slim bar of tools on the left. */
export function Rail() {
  return (
    <div class="rail card" role="toolbar" aria-label="Tools" aria-orientation="vertical">
      <ActionButton name="sphere.row" icon="streamline" />
      <ActionButton name="sphere.column" icon="across" />
      <ActionButton name="sphere.all" icon="tangents" />
      <hr />
      <ActionButton name="show.arrows" icon="arrow" />
      <ActionButton name="show.initial" icon="curve" />
      <ActionButton name="show.combs" icon="comb" />
      <hr />
      <ActionButton name="show.shaded" icon="shaded" />
      <ActionButton name="show.zebra" icon="zebra" />
      <ActionButton name="show.reflection" icon="reflection" />
      <hr />
      <ActionButton name="view.fit" icon="fit" />
      <ActionButton name="sphere.linked" icon="linked" />
    </div>
  );
}
