// Dialogs: all commands, samples, messages; and the hidden panel of times.

import { useEffect, useRef, useState } from "preact/hooks";
import type { ComponentChildren } from "preact";
import * as actions from "../actions";
import { dismiss, message } from "../announce";
import { MODELS, openSample, SAMPLES, type Sample } from "../gallery";
import { keyLabel } from "../keys";
import { current } from "../workspace";
import { measured, MEASURES, panelOpen, summary } from "../perf";
import type { Studio } from "../studio";
import { Button } from "./controls";
import { Icon } from "./icons";

/** A modal dialog of the browser, which keeps the focus inside and closes with Esc. */
export function Dialog(props: { title: string; testid: string; onClose: () => void; children: ComponentChildren }) {
  const ref = useRef<HTMLDialogElement>(null);
  useEffect(() => {
    const dialog = ref.current!;
    dialog.showModal();
    return () => dialog.close();
  }, []);
  return (
    <dialog
      ref={ref}
      class="dialog"
      aria-label={props.title}
      data-testid={props.testid}
      onCancel={(e) => {
        e.preventDefault();
        props.onClose();
      }}
      onClick={(e) => {
        if (e.target === ref.current) props.onClose();
      }}
    >
      <div class="dialog-body">
        <header>
          <h2>{props.title}</h2>
          <button type="button" class="icon-button" aria-label="Close" onClick={props.onClose} data-testid="close">
            <Icon name="close" />
          </button>
        </header>
        {props.children}
      </div>
    </dialog>
  );
}

const GROUPS: Record<string, string> = {
  file: "Files",
  edit: "Editing",
  workspace: "Workspaces",
  view: "View",
  show: "Show",
  colour: "Colours",
  tangent: "Tangents",
  model: "Model",
  sphere: "Gaussian sphere",
  select: "Selecting",
  tool: "Tools",
  fit: "Fitting",
  vertex: "Vertices",
  edge: "Edges",
  tension: "Tension",
  compare: "Comparing",
  theme: "Look",
  help: "Help",
};

export function Help({ studio }: { studio: Studio }) {
  const [wanted, setWanted] = useState("");
  const close = () => void (studio.help.value = false);
  const words = wanted.toLowerCase().split(/\s+/).filter(Boolean);
  const found = actions
    .list()
    .filter((a) => words.every((w) => a.label.toLowerCase().includes(w) || a.name.includes(w)));
  const groups = new Map<string, actions.Action[]>();
  for (const action of found) {
    const group = GROUPS[actions.groupOf(action)] ?? actions.groupOf(action);
    groups.set(group, [...(groups.get(group) ?? []), action]);
  }
  const runAndClose = (action: actions.Action | undefined) => {
    if (!action || action.enabled?.() === false) return;
    close();
    // After the dialog gave the focus back.
    setTimeout(() => actions.run(action.name));
  };
  return (
    <Dialog title="Commands and keys" testid="help-dialog" onClose={close}>
      <input
        type="search"
        class="search"
        autofocus
        placeholder="Find a command"
        aria-label="Find a command"
        data-testid="help-search"
        value={wanted}
        onInput={(e) => setWanted(e.currentTarget.value)}
        onKeyDown={(e) => {
          if (e.key === "Enter") runAndClose(found[0]);
        }}
      />
      <div class="commands">
        {[...groups].map(([group, list]) => (
          <section key={group}>
            <h3>{group}</h3>
            <ul>
              {list.map((action) => (
                <li key={action.name}>
                  <button
                    type="button"
                    disabled={action.enabled?.() === false}
                    onClick={() => runAndClose(action)}
                    data-testid={`command-${action.name}`}
                  >
                    <span>{action.label}</span>
                    <span class="keys">
                      {action.keys?.map((key) => <kbd key={key}>{keyLabel(key)}</kbd>)}
                    </span>
                  </button>
                </li>
              ))}
            </ul>
          </section>
        ))}
        {found.length === 0 && <p>No command has these words.</p>}
      </div>
      <p class="hint">
        Drag turns the view, with the right button it moves, the wheel zooms. Click selects; Shift adds, Ctrl takes
        away. With a box, a lasso or a brush, hold Alt to turn the view.
      </p>
    </Dialog>
  );
}

function open(studio: Studio, sample: Sample): void {
  openSample(sample).then(
    (source) => studio.open(source),
    (error: unknown) => studio.explain(`${sample.title} cannot be loaded`, error),
  );
}

/** The samples as a strip, for the first minute. */
export function Welcome(props: {
  studio: Studio;
  samples?: readonly Sample[];
  title?: string;
  says?: string;
  /** Null if there is nothing else to see, so that it stays. */
  onClose?: null;
}) {
  const { studio, samples = SAMPLES } = props;
  return (
    <nav class="welcome card" aria-label="Samples" data-testid="welcome">
      <div class="welcome-words">
        <strong>{props.title ?? "Smooth surfaces through exactly the points you give."}</strong>
        <span>{props.says ?? "Open a mesh of your own, drop one anywhere, or try another sample."}</span>
      </div>
      <div class="welcome-row">
        <button type="button" class="button primary" onClick={() => actions.run("file.open")}>
          Open…
        </button>
        {samples.map((sample) => (
          <button
            key={sample.file}
            type="button"
            class="thumb"
            title={sample.says}
            data-testid={`welcome-${sample.file}`}
            onClick={() => open(studio, sample)}
          >
            <img src={`./samples/${sample.file}.png`} alt="" width="72" height="52" />
            <span>{sample.title}</span>
          </button>
        ))}
        {props.onClose !== null && (
          <button
            type="button"
            class="icon-button"
            aria-label="Hide the samples"
            title="Hide the samples; G brings them back"
            onClick={() => void (studio.welcome.value = false)}
            data-testid="welcome-close"
          >
            <Icon name="close" />
          </button>
        )}
      </div>
    </nav>
  );
}

const GALLERY = [
  ["Meshes", SAMPLES],
  ["Models of streamlines", MODELS],
] as const;

export function Gallery({ studio }: { studio: Studio }) {
  const close = () => void (studio.gallery.value = false);
  return (
    <Dialog title="Samples" testid="gallery" onClose={close}>
      {(current.value === "streamline" ? GALLERY.toReversed() : GALLERY).map(([heading, samples]) => (
        <section key={heading}>
          <h3>{heading}</h3>
          <ul class="samples">
            {samples.map((sample) => (
              <li key={sample.file}>
                <button type="button" data-testid={`sample-${sample.file}`} onClick={() => open(studio, sample)}>
                  <img src={`./samples/${sample.file}.png`} alt="" loading="lazy" width="160" height="110" />
                  <strong>{sample.title}</strong>
                  <span>{sample.says}</span>
                </button>
              </li>
            ))}
          </ul>
        </section>
      ))}
      <p class="hint">
        Or drop a file anywhere: OBJ, OFF, PLY, STL, glTF, GLB, also with .gz; projects (*.fairform.json) and models
        of streamlines (*.streamline.json).
      </p>
    </Dialog>
  );
}

export function MessageDialog() {
  const open = message.value;
  if (!open) return null;
  return (
    <Dialog title={open.title} testid="message" onClose={dismiss}>
      <p class="message-text">{open.text}</p>
      {open.help && <p class="message-help">{open.help}</p>}
      <div class="message-choices">
        {open.choices.map((choice, i) => (
          <Button key={choice.label} kind={i === 0 ? "primary" : "quiet"} onClick={choice.run} testid={`choice-${i}`} autofocus={i === 0}>
            {choice.label}
          </Button>
        ))}
        <Button onClick={dismiss} testid="dismiss" kind={open.choices.length === 0 ? "primary" : "quiet"}>
          {open.choices.length > 0 ? "Leave it" : "Close"}
        </Button>
      </div>
    </Dialog>
  );
}

export function Performance() {
  if (!panelOpen.value) return null;
  void measured.value;
  return (
    <aside class="performance" aria-label="How long things take" data-testid="performance">
      <table>
        <thead>
          <tr>
            <th scope="col">ms</th>
            <th scope="col">median of 60</th>
            <th scope="col">last</th>
          </tr>
        </thead>
        <tbody>
          {MEASURES.map((what) => {
            const s = summary(what);
            return (
              <tr key={what}>
                <th scope="row">{what}</th>
                <td data-testid={`ms-${what}`}>{s ? s.median.toFixed(1) : "–"}</td>
                <td>{s ? s.last.toFixed(1) : "–"}</td>
              </tr>
            );
          })}
        </tbody>
      </table>
    </aside>
  );
}
