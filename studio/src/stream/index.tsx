import type { Studio } from "../studio";
import type { Workspace } from "../workspace";

export function StreamWorkspace({ studio }: { studio: Studio }) {
  void studio;
  return <main class="stage" data-testid="stream-workspace" />;
}

export function createStreamWorkspace(studio: Studio): Workspace {
  return {
    id: "streamline",
    title: "Streamlines",
    View: StreamWorkspace,
    actions: [],
    accept: ".streamline.json",
    opens: (name) => name.toLowerCase().endsWith(".streamline.json"),
    open: async ({ bytes, name }) => {
      const { model } = await studio.kernel.openModel(bytes.slice(), name);
      studio.history.commit({ ...studio.history.present.peek(), model }, `Open ${name}`);
    },
    camera: () => null,
    setCamera: () => {},
  };
}
