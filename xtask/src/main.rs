//! The chores of the project: `cargo xtask help` lists them. Needs nothing but Rust.

use std::process::ExitCode;

mod bench;
mod check;
mod command;
mod fuzz;
mod guide;
mod machine;
mod new_user;
mod studio;
mod test;
mod wasm;

const HELP: &str = "\
cargo xtask test [--no-studio]      all tests: unit, integration, documentation, the kernel without
                                    threads, the main job as a new user does it, and the studio in a
                                    browser, for which Node.js is needed
cargo xtask check                   formatting, lints, documentation, and all tests
cargo xtask bench [--write]         how fast each step is on this machine, beside what its memory
                                    allows; --write makes docs/performance.md of it
cargo xtask bench streamlines [--write]
                                    the same of curves and surfaces of tangents;
                                    docs/performance-streamlines.md
cargo xtask bench peers [--write] [MESH...]
                                    the same work by other libraries, those that are installed, see
                                    benches/peers; docs/performance-peers.md
cargo xtask bench tessellation [--write]
                                    many refinement steps at once, to the limit;
                                    docs/performance-tessellation.md
cargo xtask bench io [--write]      the same of every file format; docs/performance-io.md
cargo xtask fuzz [SECONDS] [TARGET] every fuzz target, or one, for so long each [30]
cargo xtask studio [FILE]           builds the studio's page and opens it; --build only builds it
cargo xtask guide                   the pictures of the guide, anew
cargo xtask wasm [--release]        the kernel for the browser, into studio/src/kernel/wasm/; with
                                    --release also made smaller
cargo xtask help                    this";

fn main() -> ExitCode {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let args: Vec<&str> = args.iter().map(String::as_str).collect();
    let done = match args.as_slice() {
        ["test"] => test::run(true),
        ["test", "--no-studio"] => test::run(false),
        ["check"] => check::run(),
        ["bench"] => bench::run(&bench::MESHES, &[], false),
        ["bench", "--write"] => bench::run(&bench::MESHES, &[], true),
        ["bench", "streamlines"] => bench::run(&bench::STREAMLINES, &[], false),
        ["bench", "streamlines", "--write"] => bench::run(&bench::STREAMLINES, &[], true),
        ["bench", "peers", rest @ ..] => bench::run_peers(rest),
        ["bench", "tessellation"] => bench::run(&bench::TESSELLATION, &[], false),
        ["bench", "tessellation", "--write"] => bench::run(&bench::TESSELLATION, &[], true),
        ["bench", "io"] => bench::run(&bench::FILES, &[], false),
        ["bench", "io", "--write"] => bench::run(&bench::FILES, &[], true),
        ["fuzz", rest @ ..] => fuzz::run(rest),
        ["guide"] => guide::run(),
        ["studio", rest @ ..] => studio::run(rest),
        ["wasm"] => wasm::run(false),
        ["wasm", "--release"] => wasm::run(true),
        ["wasm-bindings", wasm, place] => wasm::bindings(wasm, place),
        [] | ["help" | "--help" | "-h"] => {
            println!("{HELP}");
            Ok(())
        }
        _ => Err(format!("no such task: {}\n\n{HELP}", args.join(" "))),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(why) => {
            eprintln!("\nfailed: {why}");
            ExitCode::FAILURE
        }
    }
}
