// The real studio in a real browser: `fairform studio` serves, Chromium clicks.

import { type ChildProcess, execFileSync, spawn } from "node:child_process";
import { existsSync, mkdirSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import { tmpdir } from "node:os";
import { basename, join } from "node:path";
import { createInterface } from "node:readline";
import { fileURLToPath } from "node:url";

import pixelmatch from "pixelmatch";
import { type Browser, type BrowserContext, type CDPSession, type Page, chromium } from "playwright-core";
import { PNG } from "pngjs";
import { expect, test as base } from "vitest";

import type { Snapshot } from "../src/testing";

const root = fileURLToPath(new URL("../..", import.meta.url));

/** Files of the repository. */
export const data = (path: string): string => join(root, "data", path);
export const guide = (path: string): string => join(root, "docs", "guide", path);

/** The command that is tested: the one that `FAIRFORM` names, or what was built last in this clone. */
export function command(): string {
  const built = ["debug", "release"].map((profile) => join(root, "target", profile, "fairform"));
  const found = process.env.FAIRFORM ?? built.find((path) => existsSync(path));
  if (!found) throw new Error("no fairform command: build it, or say where it is with FAIRFORM");
  return found;
}

/** Runs the command to its end; its standard output. */
export function fairform(args: string[], cwd = root): string {
  return execFileSync(command(), args, { cwd, encoding: "utf8", stdio: ["ignore", "pipe", "inherit"] });
}

const ARGS = [
  "--no-sandbox",
  "--use-gl=angle",
  "--use-angle=swiftshader",
  "--enable-unsafe-swiftshader",
  "--disable-quic",
  "--no-first-run",
  "--disable-background-networking",
  "--disable-component-update",
  "--disable-sync",
];

export function launch(): Promise<Browser> {
  const executablePath = process.env.FAIRFORM_CHROMIUM ?? "/usr/bin/chromium";
  return chromium.launch({ executablePath, headless: true, args: ARGS });
}

export interface Place {
  x: number;
  y: number;
}

export interface Options {
  /** What `fairform studio` is started with. */
  file?: string;
  size?: { width: number; height: number };
  touch?: boolean;
  /** A context that is kept over pages, to come back with what it has stored. */
  dark?: boolean;
}

/** A studio that runs, and a page that shows it. */
export class Studio {
  /** Requests to any other host, errors in the console, and exceptions: there are to be none. */
  readonly trouble: string[] = [];
  /** Where downloads and scratch files go; removed at the end. */
  readonly folder = mkdtempSync(join(tmpdir(), "fairform-studio-"));
  page!: Page;
  url = "";
  #server: ChildProcess | undefined;
  #context!: BrowserContext;
  #protocol: CDPSession | undefined;

  static async open(browser: Browser, options: Options = {}): Promise<Studio> {
    const studio = new Studio();
    await studio.#serve(options.file);
    studio.#context = await browser.newContext({
      viewport: options.size ?? { width: 1280, height: 800 },
      acceptDownloads: true,
      colorScheme: options.dark ? "dark" : "light",
      reducedMotion: "reduce",
      hasTouch: options.touch ?? false,
    });
    await studio.newPage();
    return studio;
  }

  async #serve(file?: string): Promise<void> {
    const args = ["studio", "--no-open", ...(file ? [file] : [])];
    const server = spawn(command(), args, { stdio: ["ignore", "pipe", "pipe"] });
    this.#server = server;
    let said = "";
    server.stderr.on("data", (text) => (said += text));
    this.url = await new Promise<string>((resolve, reject) => {
      createInterface({ input: server.stdout }).once("line", resolve);
      server.once("exit", (code) => reject(new Error(`fairform studio ended with ${code}: ${said}`)));
    });
  }

  /** Another page of the same browser, which has what an earlier one stored, in place of `page`. */
  async newPage(): Promise<void> {
    this.page = await this.#context.newPage();
    this.#protocol = undefined;
    this.page.setDefaultTimeout(60_000);
    this.watch(this.page);
    const response = await this.page.goto(this.url);
    const policy = response?.headers()["content-security-policy"] ?? "";
    if (!policy.includes("default-src 'none'")) this.trouble.push(`a page with the policy '${policy}'`);
    await this.ready();
  }

  /** The page again, as after F5. */
  async reload(): Promise<void> {
    await this.page.reload();
    await this.ready();
  }

  /** Whatever a page asks of other hosts, or complains about. */
  watch(page: Page): void {
    const own = new URL(this.url).origin;
    page.on("request", (request) => {
      const url = new URL(request.url());
      const local = url.protocol === "blob:" || url.protocol === "data:";
      if (!local && url.origin !== own) this.trouble.push(`asked ${request.url()}`);
    });
    page.on("pageerror", (error) => this.trouble.push(`threw ${error.message}`));
    page.on("console", (message) => {
      if (message.type() === "error") this.trouble.push(`said ${message.text()}`);
    });
  }

  // -------------------------------------------------------------- waiting

  /** Asks again and again, since the page's policy forbids what a browser's own waiting needs. */
  async until<T>(what: string, ask: () => Promise<T>, good: (answer: T) => boolean, seconds = 60): Promise<T> {
    const end = Date.now() + 1000 * seconds;
    for (;;) {
      const answer = await ask();
      if (good(answer)) return answer;
      if (Date.now() > end) throw new Error(`not within ${seconds} s: ${what}; it is ${JSON.stringify(answer)}`);
      await new Promise((resolve) => setTimeout(resolve, 30));
    }
  }

  /** Until something is on screen, and nothing is left to compute. */
  async ready(): Promise<void> {
    const ask = () => this.page.evaluate<boolean>("Boolean(window.fairform) && window.fairform.state().settled");
    await this.until("a page with something on it", ask, (is) => is);
    await this.settled();
  }

  /** Until the kernel has nothing left to do, and what it did is drawn. */
  async settled(): Promise<Snapshot> {
    await this.page.evaluate("window.fairform.idle()");
    await this.frame();
    await this.page.evaluate("window.fairform.idle()");
    return this.state();
  }

  /** Until the page has drawn. */
  async frame(): Promise<void> {
    await this.page.evaluate("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))");
  }

  // -------------------------------------------------------------- looking

  control(name: string) {
    // Some commands have two buttons, of which one is out of sight.
    return this.page.getByTestId(name).filter({ visible: true }).first();
  }

  text(name: string): Promise<string> {
    return this.control(name).innerText();
  }

  number(name: string): Promise<number> {
    return this.text(name).then((text) => Number(text.replaceAll(",", "")));
  }

  /** What the page says of itself, see src/testing.ts. */
  state(): Promise<Snapshot> {
    return this.page.evaluate("window.fairform.state()");
  }

  ask<T>(question: string): Promise<T> {
    return this.page.evaluate(`window.fairform.${question}`);
  }

  /** Where a vertex is on the page. */
  vertex(v: number): Promise<Place> {
    return this.ask(`screenOf(${v})`);
  }

  /** A vertex that is seen and that no panel covers, nearest to a place. */
  async vertexNear(place: Place): Promise<number> {
    const { info } = await this.state();
    const seen = await this.page.evaluate<(Place & { v: number })[]>(`(() => {
      const found = [];
      for (let v = 0; v < ${info!.vertexCount}; v += 1) {
        const at = window.fairform.screenOf(v);
        const isFree = document.elementFromPoint(at.x, at.y)?.tagName === "CANVAS";
        if (isFree && window.fairform.vertexAt(at.x, at.y) === v) found.push({ v, ...at });
      }
      return found;
    })()`);
    const away = ({ x, y }: Place) => Math.hypot(x - place.x, y - place.y);
    return seen.reduce((a, b) => (away(b) < away(a) ? b : a)).v;
  }

  // -------------------------------------------------------------- doing

  /** Chooses a file in the browser's dialog. */
  async choose(path: string): Promise<void> {
    const [chooser] = await Promise.all([this.page.waitForEvent("filechooser"), this.control("file.open").click()]);
    await chooser.setFiles(path);
  }

  /** Opens a file, and waits until its surface is there. */
  async openFile(path: string): Promise<Snapshot> {
    await this.choose(path);
    const name = basename(path);
    await this.until(`${name} is open`, () => this.state(), (now) => now.mesh?.name === name);
    return this.settled();
  }

  async openSample(file: string): Promise<Snapshot> {
    await this.control("file.gallery").click();
    await this.control(`sample-${file}`).click();
    await this.control("gallery").waitFor({ state: "detached" });
    return this.settled();
  }

  /** Lets a file fall on the page. */
  async drop(path: string, at: Place = { x: 400, y: 300 }): Promise<void> {
    const data = { items: [], files: [path], dragOperationsMask: 1 };
    for (const type of ["dragEnter", "dragOver", "drop"] as const) {
      await (await this.protocol()).send("Input.dispatchDragEvent", { type, ...at, data });
    }
  }

  /** Opens a part of the panel. */
  async section(id: string): Promise<void> {
    const section = this.control(`section-${id}`);
    if ((await section.getAttribute("open")) === null) await section.locator("summary").click();
  }

  /** Types a number or words into a field. */
  async type(name: string, text: string): Promise<void> {
    await this.control(name).fill(text);
    await this.control(name).press("Enter");
  }

  /** Drags a slider's handle from one share of its length to another. */
  async slide(name: string, from: number, to: number): Promise<void> {
    const slider = this.control(name);
    await slider.scrollIntoViewIfNeeded();
    const box = (await slider.boundingBox())!;
    const y = box.y + box.height / 2;
    // The handle's middle stays so far from the ends.
    const inset = 8;
    const at = (share: number) => ({ x: box.x + inset + share * (box.width - 2 * inset), y });
    await this.drag(at(from), at(to));
  }

  /** Drags with the first button; `on` is called at every step. */
  async drag(from: Place, to: Place, steps = 6, on: (step: number) => Promise<void> = async () => {}): Promise<void> {
    const { mouse } = this.page;
    // The gizmo wants to be pointed at before it is taken.
    await mouse.move(from.x - 1, from.y);
    await mouse.move(from.x, from.y);
    await mouse.down();
    for (let i = 1; i <= steps; i += 1) {
      const t = i / steps;
      await mouse.move(from.x + t * (to.x - from.x), from.y + t * (to.y - from.y));
      await on(i);
    }
    await mouse.up();
  }

  async protocol(): Promise<CDPSession> {
    this.#protocol ??= await this.#context.newCDPSession(this.page);
    return this.#protocol;
  }

  /** Does what starts a download; the path of what was downloaded, with the name that the page gave it. */
  async download(start: () => Promise<unknown>): Promise<string> {
    const [download] = await Promise.all([this.page.waitForEvent("download"), start()]);
    const path = join(this.folder, basename(download.suggestedFilename()));
    await download.saveAs(path);
    return path;
  }

  // -------------------------------------------------------------- judging

  /**
   * Compares the page with a picture of before, both at half the size; with `FAIRFORM_PICTURES=new` makes a new
   * one. `share` of its pixels may differ: numbers of milliseconds do, and edges on other machines.
   */
  async looksLike(name: string, share = 0.05): Promise<void> {
    const kept = fileURLToPath(new URL(`pictures/${name}.png`, import.meta.url));
    await this.frame();
    const shot = await this.page.screenshot({ caret: "hide" });
    const now = half(PNG.sync.read(shot));
    if (process.env.FAIRFORM_PICTURES === "new" || !existsSync(kept)) {
      mkdirSync(fileURLToPath(new URL("pictures", import.meta.url)), { recursive: true });
      writeFileSync(kept, PNG.sync.write(now, { colorType: 2, deflateLevel: 9 }));
      if (process.env.FAIRFORM_PICTURES !== "new") throw new Error(`${name}.png is new: look at it`);
      return;
    }
    const before = PNG.sync.read(readFileSync(kept));
    const { width, height } = before;
    if (now.width !== width || now.height !== height) throw new Error(`${name}.png has another size`);
    const difference = new PNG({ width, height });
    const count = pixelmatch(now.data, before.data, difference.data, width, height, { threshold: 0.15 });
    if (count > share * width * height) {
      writeFileSync(scratch(`${name}.png`), shot);
      writeFileSync(scratch(`${name}.difference.png`), PNG.sync.write(difference));
      const percent = ((100 * count) / (width * height)).toFixed(1);
      throw new Error(`${percent} % of ${name}.png is not as before: see target/studio/${name}*.png`);
    }
  }

  /** Writes a picture of the page into the documentation, if new ones are wanted. */
  async depict(path: string): Promise<void> {
    if (process.env.FAIRFORM_PICTURES === "new") writeFileSync(path, await this.page.screenshot({ caret: "hide" }));
  }

  /** What an accessibility checker finds on the page as it is now. */
  async barriers(): Promise<string[]> {
    const source = readFileSync(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8");
    // Through the protocol, since the page's policy allows no script of anybody else.
    await this.page.evaluate(source);
    const found = (await this.page.evaluate("axe.run()")) as {
      violations: { id: string; help: string; nodes: { html: string; failureSummary: string }[] }[];
    };
    return found.violations.map(
      ({ id, help, nodes }) =>
        `${id}: ${help}: ${nodes.map((node) => `${node.html} (${node.failureSummary})`).join("; ")}`,
    );
  }

  async close(): Promise<void> {
    await this.#context.close();
    this.#server?.removeAllListeners("exit");
    this.#server?.kill();
    rmSync(this.folder, { recursive: true, force: true });
  }
}

/** A picture at half its size. */
function half(picture: PNG): PNG {
  const { width, height, data } = picture;
  const small = new PNG({ width: width >> 1, height: height >> 1 });
  small.data.forEach((_, i) => {
    const [channel, pixel] = [i % 4, i >> 2];
    const [x, y] = [2 * (pixel % small.width), 2 * Math.floor(pixel / small.width)];
    const at = (dx: number, dy: number) => data[4 * ((y + dy) * width + x + dx) + channel]!;
    small.data[i] = (at(0, 0) + at(1, 0) + at(0, 1) + at(1, 1) + 2) >> 2;
  });
  return small;
}

/** A file in target/studio, for who looks why a test failed. */
function scratch(name: string): string {
  const folder = join(root, "target", "studio");
  mkdirSync(folder, { recursive: true });
  return join(folder, name);
}

/**
 * A test with a studio. Whatever else it finds: at its end there were no requests to other hosts, no errors in
 * the console, and the page came with its policy.
 */
export const test = base
  .extend("browser", { scope: "file" }, async ({}, { onCleanup }) => {
    const browser = await launch();
    onCleanup(() => browser.close());
    return browser;
  })
  .extend("open", async ({ browser, task }, { onCleanup }) => {
    const studios: Studio[] = [];
    onCleanup(async () => {
      for (const studio of studios) {
        if (task.result?.state === "fail") {
          const name = task.name.replaceAll(/[^A-Za-z0-9]+/g, "-");
          await studio.page.screenshot({ path: scratch(`failed-${name}.png`) }).catch(() => {});
        }
        const { trouble } = studio;
        await studio.close();
        expect(trouble).toEqual([]);
      }
    });
    return async (options?: Options) => {
      const studio = await Studio.open(browser, options);
      studios.push(studio);
      return studio;
    };
  })
  .extend("studio", ({ open }) => open());

export { expect };

/** The vertices of an OBJ file. */
export function vertices(path: string): number[][] {
  const lines = readFileSync(path, "utf8").split("\n");
  return lines.filter((line) => line.startsWith("v ")).map((line) => line.split(/\s+/).slice(1, 4).map(Number));
}

/** The largest distance between points of the same number. */
export function gap(a: readonly (readonly number[])[], b: readonly (readonly number[])[]): number {
  expect(a.length).toBe(b.length);
  return Math.max(...a.map((p, i) => Math.hypot(...p.map((x, k) => x - b[i]![k]!))));
}

/** Triples of a flat list. */
export function triples(flat: readonly number[]): number[][] {
  return Array.from({ length: flat.length / 3 }, (_, i) => flat.slice(3 * i, 3 * i + 3));
}
