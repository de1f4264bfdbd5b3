//! `cargo xtask fuzz`: any bytes give an answer or an error, never a panic, a hang or a huge
//! allocation.

use std::fs;

use crate::command::{Result, cargo, nightly_cargo, root, step, succeeds};

const SECONDS: u32 = 30;

pub(crate) fn run(args: &[&str]) -> Result {
    let all = targets()?;
    let (mut seconds, mut chosen) = (SECONDS, all.clone());
    for &arg in args {
        if let Ok(number) = arg.parse() {
            seconds = number;
        } else if all.iter().any(|target| target == arg) {
            chosen = vec![arg.to_owned()];
        } else {
            return Err(format!("no fuzz target {arg}; there are {}", all.join(", ")));
        }
    }
    if !succeeds(&mut nightly_cargo(&["--version"])) {
        eprintln!("skipped: fuzzing needs a nightly toolchain; `rustup toolchain install nightly`");
        return Ok(());
    }
    if !succeeds(&mut nightly_cargo(&["fuzz", "--version"])) {
        step("installing cargo-fuzz", &mut cargo(&["install", "cargo-fuzz", "--locked"]))?;
    }
    for target in &chosen {
        let corpus = format!("fuzz/corpus/{target}");
        fs::create_dir_all(root().join(&corpus)).map_err(|e| format!("{corpus}: {e}"))?;
        // What is found goes to the first folder; the others are only read.
        let seeds = match target.as_str() {
            "streamline" => ["data/streamline", "data/golden/sphere"],
            _ => ["data/meshes/odd", "data/meshes/bad"],
        };
        let seconds = format!("-max_total_time={seconds}");
        let limits = ["-timeout=10", "-rss_limit_mb=2048", "-max_len=4096", "-print_final_stats=1"];
        let mut command = nightly_cargo(&["fuzz", "run", target, &corpus]);
        command.args(seeds).arg("--").arg(seconds).args(limits);
        step(&format!("fuzzing {target}"), &mut command)?;
    }
    Ok(())
}

/// The names of all targets, in order.
fn targets() -> Result<Vec<String>> {
    let place = root().join("fuzz/fuzz_targets");
    let entries = fs::read_dir(&place).map_err(|e| format!("{}: {e}", place.display()))?;
    let mut targets: Vec<String> = entries
        .filter_map(|entry| Some(entry.ok()?.file_name().to_str()?.strip_suffix(".rs")?.to_owned()))
        .collect();
    targets.sort();
    Ok(targets)
}
