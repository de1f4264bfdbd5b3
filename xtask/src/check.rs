//! `cargo xtask check`: all that a change must pass.

use crate::command::{Result, cargo, step};
use crate::test;

pub(crate) fn run() -> Result {
    step("formatting", &mut cargo(&["fmt", "--all", "--", "--check"]))?;
    step(
        "formatting of the fuzz targets",
        &mut cargo(&["fmt", "--manifest-path", "fuzz/Cargo.toml", "--", "--check"]),
    )?;
    step(
        "lints",
        &mut cargo(&["clippy", "--workspace", "--all-targets", "--", "--deny", "warnings"]),
    )?;
    step(
        "lints of the kernel and the files without threads",
        &mut cargo(&[
            "clippy",
            "--package=fairform",
            "--package=fairform-io",
            "--no-default-features",
            "--",
            "--deny",
            "warnings",
        ]),
    )?;
    step(
        "documentation",
        // Libraries only: the command and the kernel have one name.
        cargo(&["doc", "--workspace", "--lib", "--no-deps"]).env("RUSTDOCFLAGS", "-D warnings"),
    )?;
    test::run(true)?;
    eprintln!("\nall checks passed");
    Ok(())
}
