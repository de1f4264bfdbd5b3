// The streamline workspace: a grid of unit tangents, and the surface that they integrate to.

import { useEffect, useRef } from "preact/hooks";
import { MODELS } from "../gallery";
import { Welcome } from "../panels/dialogs";
import type { Studio } from "../studio";
import type { Workspace } from "../workspace";
import { commands } from "./commands";
import { Inspector } from "./panels/Inspector";
import { Legend } from "./panels/Legend";
import { Rail } from "./panels/Rail";
import { StreamScene } from "./scene";
import { StreamSession } from "./session";
import "./stream.css";

export function createStreamWorkspace(studio: Studio): { workspace: Workspace; stream: StreamSession } {
  const stream = new StreamSession(studio);
  const workspace: Workspace = {
    id: "streamline",
    title: "Streamlines",
    View: () => <StreamWorkspace session={stream} />,
    actions: commands(stream),
    accept: ".streamline.json",
    opens: (name) => name.toLowerCase().endsWith(".streamline.json"),
    open: (source) => stream.open(source),
    camera: () => stream.scene.peek()?.viewport.view ?? stream.pendingCamera,
    setCamera: (camera) => {
      stream.pendingCamera = camera;
    },
  };
  return { workspace, stream };
}

function StreamWorkspace({ session }: { session: StreamSession }) {
  const main = useRef<HTMLDivElement>(null);
  const ball = useRef<HTMLDivElement>(null);
  useEffect(() => {
    session.warm();
    const scene = new StreamScene(main.current!, ball.current!, session);
    scene.insets = { left: innerWidth > 820 ? 56 : 0, right: 0, top: 8, bottom: 8 };
    return () => scene.dispose();
  }, [session]);
  return (
    <main class="stage stream" data-testid="streamline">
      <div class="views">
        <div class="view" ref={main} />
        <div class="view ball" ref={ball} data-testid="sphere-view">
          <span class="view-label">Gaussian sphere</span>
        </div>
      </div>
      <Rail />
      <Inspector session={session} />
      <div class="over-view">
        <Legend session={session} />
      </div>
      {session.patches.value.length === 0 && (
        <Welcome
          studio={session.studio}
          samples={MODELS}
          title="Surfaces from directions."
          says="Open a model of streamlines, drop one anywhere, or begin with one of these."
          onClose={null}
        />
      )}
      {session.busy.value && <div class="working" aria-hidden="true" />}
    </main>
  );
}
