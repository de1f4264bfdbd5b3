//! `cargo xtask wasm`: the kernel for the browser, as WebAssembly and the JavaScript around it.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::thread::sleep;
use std::time::{Duration, Instant};

use crate::command::{Result, cargo, output, root, step, succeeds};

const TARGET: &str = "wasm32-unknown-unknown";
const PLACE: &str = "studio/src/kernel/wasm";
/// For a download of some 30 MB.
const PATIENCE: Duration = Duration::from_mins(2);
/// Of the npm package with `wasm-opt`, where the studio has not installed one.
const BINARYEN: &str = "binaryen@132";

/// Builds everything. A `release` is also made smaller and faster by `wasm-opt`, if that can be had.
pub(crate) fn run(release: bool) -> Result {
    let mut build = compiler()?;
    build.args(["--profile", "wasm", "--target", TARGET, "--package", "fairform-wasm", "--locked"]);
    // All browsers have these since 2021; code for them is smaller, and copies are fast.
    build.env("RUSTFLAGS", "-Ctarget-feature=+simd128,+bulk-memory,+sign-ext,+nontrapping-fptoint");
    step("compiling the kernel to WebAssembly", &mut build)?;
    let built = format!("target/wasm/{TARGET}/wasm/fairform_wasm.wasm");
    // Another build of this very program, which has the generator of bindings in it.
    let mut bind =
        cargo(&["run", "--quiet", "--package", "xtask", "--features", "wasm", "--locked"]);
    bind.args(["--", "wasm-bindings", &built, PLACE]);
    step("writing the bindings", &mut bind)?;
    let wasm = root().join(PLACE).join("fairform_wasm_bg.wasm");
    if release {
        optimise(&wasm)?;
    }
    let size = fs::metadata(&wasm).map_err(|e| format!("{}: {e}", wasm.display()))?.len();
    eprintln!("\n{PLACE}: {:.2} MB of WebAssembly", size as f64 / 1e6);
    Ok(())
}

/// `cargo build` with a compiler that has a standard library for the target.
fn compiler() -> Result<Command> {
    let mut build = cargo(&["build"]);
    build.args(["--target-dir", "target/wasm"]);
    let fallback = root().join("target/tools/wasm-toolchain/rustc");
    let force = std::env::var_os("FAIRFORM_WASM_FALLBACK").is_some();
    if !force && has_target() {
        return Ok(build);
    }
    if !fallback.exists() {
        if !force && add_target() && has_target() {
            return Ok(build);
        }
        let mut make = Command::new("sh");
        make.args(["xtask/wasm-toolchain.sh", "target/tools/wasm-toolchain"]).current_dir(root());
        step(
            "a standard library for WebAssembly from Debian's, once, some five minutes",
            &mut make,
        )
        .map_err(|e| format!("{e}; `rustup target add {TARGET}` is the usual way"))?;
    }
    build.env("RUSTC", fallback);
    Ok(build)
}

/// Whether the compiler that we run with can make WebAssembly.
fn has_target() -> bool {
    let mut rustc = Command::new(std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into()));
    rustc.args(["--print", "target-libdir", "--target", TARGET]).current_dir(root());
    output(&mut rustc).is_ok_and(|place| Path::new(place.trim()).is_dir())
}

/// Asks rustup for the target. Where it reaches no server, it does not fail but waits, so it gets its time
/// and no more.
fn add_target() -> bool {
    eprintln!("\n── asking rustup for {TARGET}");
    let mut add = Command::new("rustup");
    let Ok(mut child) = add.args(["target", "add", TARGET]).current_dir(root()).spawn() else {
        return false;
    };
    let begin = Instant::now();
    while begin.elapsed() < PATIENCE {
        match child.try_wait() {
            Ok(None) => sleep(Duration::from_millis(200)),
            Ok(Some(status)) => return status.success(),
            Err(_) => break,
        }
    }
    // It may have ended just now.
    let _ = child.kill();
    let _ = child.wait();
    false
}

/// Smaller and faster, by `wasm-opt`; without it all works as well.
fn optimise(wasm: &Path) -> Result {
    let Some(tool) = wasm_opt() else {
        eprintln!(
            "\nskipped: wasm-opt, for lack of npm; `apt-get install npm` or put it on the path"
        );
        return Ok(());
    };
    let mut run = Command::new(tool);
    // What the module says it uses is what may be used.
    run.args(["-O3", "--strip-debug", "--strip-producers"]);
    step("wasm-opt", run.arg(wasm).arg("-o").arg(wasm))
}

/// A `wasm-opt`: that of the studio, one on the path, or one fetched for this checkout.
fn wasm_opt() -> Option<PathBuf> {
    let here = |place: &str| Some(root().join(place)).filter(|path| path.exists());
    let fetched = "target/tools/npm/node_modules/.bin/wasm-opt";
    here("studio/node_modules/.bin/wasm-opt").or_else(|| here(fetched)).or_else(|| {
        if succeeds(Command::new("wasm-opt").arg("--version")) {
            return Some("wasm-opt".into());
        }
        let mut npm = Command::new("npm");
        npm.args(["install", "--silent", "--prefix", "target/tools/npm", BINARYEN]);
        succeeds(npm.current_dir(root())).then(|| here(fetched)).flatten()
    })
}

/// The bindings of a WebAssembly module, for ES modules.
#[cfg(feature = "wasm")]
pub(crate) fn bindings(wasm: &str, place: &str) -> Result {
    let mut bindgen = wasm_bindgen_cli_support::Bindgen::new();
    bindgen
        .input_path(root().join(wasm))
        .typescript(true)
        .remove_name_section(true)
        .out_name("fairform_wasm");
    bindgen.web(true).map_err(|e| e.to_string())?;
    bindgen.generate(root().join(place)).map_err(|e| format!("{wasm}: {e:#}"))
}

/// The bindings are written by a build that can.
#[cfg(not(feature = "wasm"))]
pub(crate) fn bindings(_: &str, _: &str) -> Result {
    Err("build xtask with the feature `wasm` for that; `cargo xtask wasm` does".into())
}
