//! Running other programs.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// What went wrong, in words.
pub(crate) type Result<T = ()> = std::result::Result<T, String>;

/// The root of the repository.
pub(crate) fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("xtask lies in the repository")
}

/// The cargo that runs this.
pub(crate) fn cargo(args: &[&str]) -> Command {
    let cargo = std::env::var_os("CARGO").map_or_else(|| "cargo".into(), PathBuf::from);
    let mut command = Command::new(cargo);
    command.args(args).current_dir(root());
    command
}

/// The cargo of the nightly toolchain. Named through rustup, since the variables that cargo sets
/// for us would pin the toolchain that we are running on.
pub(crate) fn nightly_cargo(args: &[&str]) -> Command {
    let mut command = Command::new("rustup");
    command.args(["run", "nightly", "cargo"]).args(args).current_dir(root());
    command.env_remove("RUSTUP_TOOLCHAIN").env_remove("CARGO").env_remove("RUSTC");
    command
}

/// The `fairform` command, built from this tree, run in `place`.
pub(crate) fn fairform(profile: &str, place: &Path, args: &[&str]) -> Command {
    let mut command = cargo(&["run", "--quiet", "--profile", profile, "--package", "fairform-cli"]);
    command.arg("--manifest-path").arg(root().join("Cargo.toml")).arg("--").args(args);
    command.current_dir(place);
    command
}

/// Announces a step and runs it; its output is ours.
pub(crate) fn step(title: &str, command: &mut Command) -> Result {
    eprintln!("\n── {title}");
    let status = command.stdin(Stdio::null()).status().map_err(|e| cannot_run(command, &e))?;
    if status.success() { Ok(()) } else { Err(format!("{title} ({status})")) }
}

/// Whether a command runs and succeeds; its output is dropped.
pub(crate) fn succeeds(command: &mut Command) -> bool {
    let command = command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    command.status().is_ok_and(|status| status.success())
}

/// What a command prints on standard output.
pub(crate) fn output(command: &mut Command) -> Result<String> {
    let output = command
        .stdin(Stdio::null())
        .stderr(Stdio::inherit())
        .output()
        .map_err(|e| cannot_run(command, &e))?;
    if !output.status.success() {
        return Err(format!("{} ({})", name(command), output.status));
    }
    String::from_utf8(output.stdout).map_err(|_| format!("{} prints no text", name(command)))
}

fn name(command: &Command) -> String {
    let args = command.get_args().map(std::ffi::OsStr::to_string_lossy);
    let words = std::iter::once(command.get_program().to_string_lossy()).chain(args);
    words.collect::<Vec<_>>().join(" ")
}

fn cannot_run(command: &Command, error: &std::io::Error) -> String {
    format!("cannot run {}: {error}", name(command))
}
