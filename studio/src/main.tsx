// The page: makes the studio, restores or begins, and shows it.

import { render } from "preact";
import { App } from "./panels/App";
import { press } from "./actions";
import { tell } from "./announce";
import { openSample, SAMPLES } from "./gallery";
import { createInterpolation } from "./interpolation";
import { createKernel } from "./kernel/client";
import { problemOf } from "./kernel/problem";
import { isServed, servedFile } from "./served";
import { createStreamWorkspace } from "./stream";
import { Studio } from "./studio";
import { offerTestHooks } from "./testing";
import { readFile } from "./files";
import "./style/base.css";
import "./style/studio.css";

async function begin(): Promise<void> {
  const studio = new Studio(createKernel);
  const { workspace, session } = createInterpolation(studio);
  const { workspace: streamlines, stream } = createStreamWorkspace(studio);
  studio.start([workspace, streamlines]);
  render(<App studio={studio} />, document.getElementById("app")!);
  offerTestHooks(studio, session, stream);

  addEventListener("keydown", (event) => {
    // A dialog keeps the keys to itself, apart from the key that opened it.
    if (!document.querySelector("dialog[open]")) press(event);
  });
  addEventListener("dragover", (event) => {
    event.preventDefault();
    document.body.classList.add("dropping");
  });
  addEventListener("dragleave", (event) => {
    if (event.relatedTarget === null) document.body.classList.remove("dropping");
  });
  addEventListener("drop", (event) => {
    event.preventDefault();
    document.body.classList.remove("dropping");
    const file = event.dataTransfer?.files[0];
    if (file) void readFile(file).then((source) => studio.open(source));
  });

  const served = isServed() ? await servedFile() : null;
  if (served) {
    await studio.open(served);
    // It is what one began with, and nothing to undo.
    studio.history.reset(studio.history.present.peek());
    return;
  }
  const isBack = await studio.restore().catch(() => false);
  if (isBack) return;
  try {
    studio.welcome.value = true;
    await session.open(await openSample(SAMPLES[0]!), [], true);
  } catch (error) {
    studio.explain("The sample cannot be shown", error);
  }
}

begin().catch((error: unknown) => {
  const { message, help } = problemOf(error);
  const app = document.getElementById("app")!;
  if (app.childElementCount > 0) tell({ kind: "error", title: "The studio", text: message, help, choices: [] });
  else app.textContent = `The studio could not start: ${message}`;
});
