import type { Studio } from "../studio";
import { message, status } from "../announce";
import { Gallery, Help, MessageDialog, Performance, Welcome } from "./dialogs";
import { TopBar } from "./TopBar";

/** The frame around the workspaces. */
export function App({ studio }: { studio: Studio }) {
  const { View } = studio.workspace;
  return (
    <div class="app">
      <TopBar studio={studio} />
      <View key={studio.workspace.id} studio={studio} />
      <footer class="status-line">
        <span role="status" aria-live="polite" data-testid="status">
          {status.value}
        </span>
      </footer>
      {studio.welcome.value && <Welcome studio={studio} />}
      <Performance />
      {studio.gallery.value && <Gallery studio={studio} />}
      {studio.help.value && <Help studio={studio} />}
      {message.value && <MessageDialog key={message.value.title + message.value.text} />}
      <div class="drop-hint" aria-hidden="true">
        Drop a mesh, a model or a project
      </div>
    </div>
  );
}
