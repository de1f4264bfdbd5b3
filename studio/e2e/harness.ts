// The real studio in a real browser: `fairform studio` serves, Chromium clicks.

import { type ChildProcess, execFileSync, spawn } from "node:child_process";
import { existsSync, mkdirSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import { tmpdir } from "node:os";
import { basename, join } from "node:path";
import { createInterface } from "node:readline";
import { fileURLToPath } from "node:url";

import pixelmatch from "pixelmatch";
import { type Browser, type Page, chromium } from "playwright-core";
import { PNG } from "pngjs";

const root = fileURLToPath(new URL("../..", import.meta.url));

/** Files of the repository. */
export const data = (path: string): string => join(root, "data", path);

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

/** A studio that runs, and a page that shows it. */
export class Studio {
  /** Requests to any other host, errors in the console, and exceptions: there are to be none. */
  readonly trouble: string[] = [];
  /** Where downloads and scratch files go; removed at the end. */
  readonly folder = mkdtempSync(join(tmpdir(), "fairform-studio-"));
  page!: Page;
  url = "";
  private server: ChildProcess | undefined;

  static async open(browser: Browser, file?: string, size = { width: 1280, height: 800 }): Promise<Studio> {
    const studio = new Studio();
    await studio.serve(file);
    const context = await browser.newContext({
      viewport: size,
      acceptDownloads: true,
      colorScheme: "light",
      reducedMotion: "reduce",
    });
    studio.page = await context.newPage();
    studio.watch(studio.page);
    await studio.page.goto(studio.url);
    return studio;
  }

  private async serve(file?: string): Promise<void> {
    const args = ["studio", "--no-open", ...(file ? [file] : [])];
    const server = spawn(command(), args, { stdio: ["ignore", "pipe", "inherit"] });
    this.server = server;
    this.url = await new Promise<string>((resolve, reject) => {
      createInterface({ input: server.stdout }).once("line", resolve);
      server.once("exit", (code) => reject(new Error(`fairform studio ended with ${code}`)));
    });
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

  control(name: string) {
    return this.page.getByTestId(name);
  }

  /** What the page says of its state, see `window.fairform` in src/. */
  state<T>(read: string): Promise<T> {
    return this.page.evaluate(`(() => { const studio = window.fairform; return ${read}; })()`) as Promise<T>;
  }

  /** Does what starts a download; the path of what was downloaded, with the name that the page gave it. */
  async download(start: () => Promise<unknown>): Promise<string> {
    const [download] = await Promise.all([this.page.waitForEvent("download"), start()]);
    const path = join(this.folder, basename(download.suggestedFilename()));
    await download.saveAs(path);
    return path;
  }

  /** Compares the page with a picture of before; with `FAIRFORM_PICTURES=new` makes a new one. */
  async looksLike(name: string, share = 0.02): Promise<void> {
    const kept = fileURLToPath(new URL(`pictures/${name}.png`, import.meta.url));
    const shot = await this.page.screenshot();
    if (process.env.FAIRFORM_PICTURES === "new" || !existsSync(kept)) {
      mkdirSync(fileURLToPath(new URL("pictures", import.meta.url)), { recursive: true });
      writeFileSync(kept, shot);
      if (process.env.FAIRFORM_PICTURES !== "new") throw new Error(`${name}.png is new: look at it`);
      return;
    }
    const [now, before] = [PNG.sync.read(shot), PNG.sync.read(readFileSync(kept))];
    const { width, height } = before;
    if (now.width !== width || now.height !== height) throw new Error(`${name}.png has another size`);
    const difference = new PNG({ width, height });
    const count = pixelmatch(now.data, before.data, difference.data, width, height, { threshold: 0.2 });
    if (count > share * width * height) {
      const folder = join(root, "target", "studio");
      mkdirSync(folder, { recursive: true });
      writeFileSync(join(folder, `${name}.png`), shot);
      writeFileSync(join(folder, `${name}.difference.png`), PNG.sync.write(difference));
      const percent = ((100 * count) / (width * height)).toFixed(1);
      throw new Error(`${percent} % of ${name}.png is not as before: see target/studio/${name}*.png`);
    }
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
    await this.page.context().close();
    this.server?.removeAllListeners("exit");
    this.server?.kill();
    rmSync(this.folder, { recursive: true, force: true });
  }
}
