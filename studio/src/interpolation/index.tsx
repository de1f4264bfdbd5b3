// The interpolation workspace: a mesh, and the surface through its vertices.

import { effect, signal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import { tell } from "../announce";
import { problemOf } from "../kernel/problem";
import type { Studio } from "../studio";
import type { Workspace } from "../workspace";
import { commands } from "./commands";
import { Axes } from "../panels/Axes";
import { Inspector } from "./panels/Inspector";
import { Legend } from "./panels/Legend";
import { Progress } from "./panels/Progress";
import { Rail } from "./panels/Rail";
import { MeshScene } from "./scene";
import { Session } from "./session";
import type { Insets } from "../scene/viewport";

export function createInterpolation(studio: Studio): { workspace: Workspace; session: Session } {
  const session = new Session(studio);
  const workspace: Workspace = {
    id: "interpolation",
    title: "Interpolation",
    View: () => <View session={session} />,
    actions: commands(session),
    accept: ".obj,.off,.ply,.stl,.gltf,.glb,.gz",
    opens: (name) => !name.toLowerCase().endsWith(".json"),
    open: (source) => session.open(source),
    camera: () => session.scene.peek()?.viewport.view ?? session.pendingCamera,
    setCamera: (camera) => {
      session.pendingCamera = camera;
    },
  };
  return { workspace, session };
}

const pageWidth = signal(globalThis.innerWidth ?? 1200);
globalThis.addEventListener?.("resize", () => void (pageWidth.value = innerWidth));

/** What the panels cover of a view of the given height. */
function insetsOf(session: Session, height: number): Insets {
  if (pageWidth.value <= 820) return { left: 56, right: 8, top: 8, bottom: 16 + 0.4 * (height || 600) };
  const hasOther = session.mesh.value?.compare != null;
  const bottom = session.studio.welcome.value ? 160 : 8;
  return { left: hasOther ? 28 : 56, right: hasOther ? 0 : 316, top: 8, bottom };
}

function View({ session }: { session: Session }) {
  const left = useRef<HTMLDivElement>(null);
  const right = useRef<HTMLDivElement>(null);
  useEffect(() => {
    try {
      const scene = new MeshScene(left.current!, session, insetsOf(session, left.current!.clientHeight));
      return () => scene.dispose();
    } catch (error) {
      const help = "Use a browser with WebGL 2, and allow it to use the graphics card.";
      tell({ kind: "error", title: "Nothing can be drawn", text: problemOf(error).message, help, choices: [] });
      return undefined;
    }
  }, [session]);
  const compares = session.other.value !== null && session.mesh.value?.compare != null;
  useEffect(() => {
    const scene = session.scene.peek();
    if (!scene) return;
    scene.setOther(compares ? right.current : null);
    return () => scene.setOther(null);
  }, [session, compares]);
  // At once, not after the next picture as with a hook for signals: whoever fits the view next counts on it.
  useEffect(
    () =>
      effect(() => {
        const scene = session.scene.value;
        if (scene) scene.insets = insetsOf(session, scene.viewport.canvas.clientHeight);
      }),
    [session],
  );
  const { main } = session;
  return (
    <main class={`stage ${compares ? "compares" : ""}`} data-testid="interpolation">
      <div class="views">
        <div class="view" ref={left}>
          {compares && <span class="view-label">A</span>}
        </div>
        {compares && (
          <div class="view" ref={right} data-testid="other-view">
            <span class="view-label">B</span>
          </div>
        )}
      </div>
      <Rail session={session} />
      <Axes turns={session.turns} onView={(preset) => session.scene.peek()?.show(preset)} />
      <Inspector session={session} />
      <div class="over-view">
        <Legend session={session} />
        <Progress session={session} />
      </div>
      {main.stage.value !== null && <div class="working" aria-hidden="true" />}
    </main>
  );
}
