import { useRef } from "preact/hooks";
import * as actions from "../actions";
import type { Studio } from "../studio";
import { settings, change, type Theme } from "../state/settings";
import { current } from "../workspace";
import { ActionButton, keyHint } from "./controls";
import { Icon } from "./icons";

const NEXT: Record<Theme, Theme> = { auto: "light", light: "dark", dark: "contrast", contrast: "auto" };
const LOOKS: Record<Theme, string> = {
  auto: "as the system",
  light: "light",
  dark: "dark",
  contrast: "high contrast",
};

/** Everything that the open workspace can save: its actions whose names begin with `file.`. */
function SaveMenu() {
  const ref = useRef<HTMLDetailsElement>(null);
  const close = () => {
    if (ref.current) ref.current.open = false;
  };
  const elsewhere = new Set(["file.open", "file.gallery"]);
  const saving = actions.list().filter((a) => actions.groupOf(a) === "file" && !elsewhere.has(a.name));
  return (
    <details
      ref={ref}
      class="menu"
      onFocusOut={(e) => {
        if (!e.currentTarget.contains(e.relatedTarget as Node | null)) close();
      }}
      onKeyDown={(e) => {
        if (e.key !== "Escape" || !ref.current?.open) return;
        e.stopPropagation();
        close();
        ref.current.querySelector("summary")?.focus();
      }}
    >
      <summary class="icon-button" aria-label="Save" title="Save" data-testid="save-menu">
        <Icon name="save" />
      </summary>
      <ul class="menu-list">
        {saving.map((action) => (
          <li key={action.name}>
            <button
              type="button"
              disabled={action.enabled?.() === false}
              data-testid={`menu-${action.name}`}
              onClick={() => {
                close();
                actions.run(action.name);
              }}
            >
              <span>{action.label}</span>
              {action.keys && <kbd>{keyHint(action.keys)}</kbd>}
            </button>
          </li>
        ))}
      </ul>
    </details>
  );
}

export function TopBar({ studio }: { studio: Studio }) {
  const { theme } = settings.value;
  const undo = studio.history.undoLabel;
  return (
    <header class="top-bar">
      <h1 class="brand">
        <img src="./icon.svg" alt="" width="22" height="22" />
        <span>fairform</span>
      </h1>
      <nav class="workspaces" aria-label="Workspaces">
        {studio.workspaces.map((w) => (
          <button
            key={w.id}
            type="button"
            aria-current={current.value === w.id ? "page" : undefined}
            data-testid={`workspace-${w.id}`}
            onClick={() => studio.enter(w.id)}
          >
            {w.title}
          </button>
        ))}
      </nav>
      <div class="bar-group">
        <ActionButton name="file.open" icon="open" />
        <ActionButton name="file.gallery" icon="gallery" />
        <SaveMenu />
        <span class="bar-rule" />
        <ActionButton name="edit.undo" icon="undo" />
        <ActionButton name="edit.redo" icon="redo" />
        <span class="unseen" data-testid="undo-label">
          {undo ?? ""}
        </span>
      </div>
      <div class="bar-file" data-testid="file-name">
        {studio.title}
      </div>
      <div class="bar-group">
        <button
          type="button"
          class="icon-button"
          aria-label={`Look: ${LOOKS[theme]}. Change it`}
          title={`Look: ${LOOKS[theme]}`}
          data-testid="theme"
          onClick={() => change({ theme: NEXT[theme] })}
        >
          <Icon name="look" />
        </button>
        <button
          type="button"
          class="icon-button"
          aria-label="All commands and keys"
          title="All commands and keys (?)"
          data-testid="help"
          onClick={() => actions.run("help.commands")}
        >
          <Icon name="help" />
        </button>
      </div>
    </header>
  );
}
