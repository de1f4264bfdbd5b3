//! `cargo xtask studio`, and the tests of the page. Needs Node.js; the tests need Chromium too.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::command::{Result, cargo, output, root, step, succeeds};
use crate::wasm;

/// The oldest Node.js that the page's tools run on.
const NODE: (u32, u32) = (20, 19);

/// Where Chromium is looked for, unless `FAIRFORM_CHROMIUM` says where.
const BROWSERS: [&str; 4] = [
    "/usr/bin/chromium",
    "/usr/bin/chromium-browser",
    "/usr/bin/google-chrome",
    "/opt/google/chrome/chrome",
];

/// Builds the page into the command, and opens it.
pub(crate) fn run(args: &[&str]) -> Result {
    build()?;
    if args == ["--build"] {
        return Ok(());
    }
    let here = std::env::current_dir().map_err(|e| format!("no current folder: {e}"))?;
    let mut studio = cargo(&["run", "--release", "--quiet", "--package", "fairform-cli"]);
    studio.arg("--manifest-path").arg(root().join("Cargo.toml"));
    studio.args(["--", "studio"]).args(args).current_dir(here);
    step("the studio", &mut studio)
}

/// The kernel for the browser, and the page around it, in `studio/dist`.
pub(crate) fn build() -> Result {
    check_node()?;
    packages()?;
    wasm::run(true)?;
    step("the page of the studio", &mut npm(&["run", "build"]))
}

/// Everything that is tested of the page: its parts in Node.js, and the whole in a real browser, with the
/// command that was built last.
pub(crate) fn test() -> Result {
    step("tests of the page's parts", &mut npm(&["test"]))?;
    let mut tests = npm(&["run", "e2e"]);
    tests.env("FAIRFORM_CHROMIUM", browser()?);
    step("tests of the studio in a browser", &mut tests)
}

/// The page's packages, as the lock file has them.
fn packages() -> Result {
    let (lock, done) =
        (folder().join("package-lock.json"), folder().join("node_modules/.package-lock.json"));
    let time = |path: &Path| fs::metadata(path).and_then(|m| m.modified()).ok();
    if time(&done).is_some_and(|done| time(&lock).is_some_and(|lock| lock <= done)) {
        return Ok(());
    }
    step("packages of the page", &mut npm(&["ci", "--no-audit", "--no-fund"]))
}

fn check_node() -> Result {
    let advice = format!("install Node.js {}.{} or later from https://nodejs.org", NODE.0, NODE.1);
    let found = output(Command::new("node").arg("--version"))
        .map_err(|e| format!("the studio's page is built with Node.js: {e}; {advice}"))?;
    let mut numbers = found.trim().trim_start_matches('v').split('.').map(str::parse::<u32>);
    match (numbers.next(), numbers.next()) {
        (Some(Ok(major)), Some(Ok(minor))) if (major, minor) >= NODE => Ok(()),
        _ => {
            Err(format!("Node.js {} is too old to build the studio's page; {advice}", found.trim()))
        }
    }
}

/// A browser to test in; Debian's, installed if there is none and we may.
fn browser() -> Result<PathBuf> {
    let named = std::env::var_os("FAIRFORM_CHROMIUM").map(PathBuf::from);
    let found = || BROWSERS.iter().map(PathBuf::from).find(|path| path.exists());
    if let Some(path) = named.or_else(found) {
        return Ok(path);
    }
    let mut install = Command::new("apt-get");
    // With what it recommends: a page without fonts looks like none that people see.
    install.args(["install", "--yes", "--quiet", "chromium"]);
    install.env("DEBIAN_FRONTEND", "noninteractive");
    if succeeds(Command::new("apt-get").arg("--version")) && step("Chromium", &mut install).is_err()
    {
        // A machine that is new has no lists of packages yet.
        step("lists of packages", Command::new("apt-get").args(["update", "--quiet"]))?;
        step("Chromium", &mut install)?;
    }
    found().ok_or_else(|| {
        "the studio is tested in Chromium: install it, or say where it is with FAIRFORM_CHROMIUM".into()
    })
}

fn npm(args: &[&str]) -> Command {
    let mut command = Command::new(if cfg!(windows) { "npm.cmd" } else { "npm" });
    command.args(args).current_dir(folder());
    command
}

fn folder() -> PathBuf {
    root().join("studio")
}
