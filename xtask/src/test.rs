//! `cargo xtask test`.

use crate::command::{Result, cargo, step, succeeds};
use crate::{new_user, studio};

pub(crate) fn run(with_studio: bool) -> Result {
    if with_studio {
        // First, so that the command that is tested carries the page.
        studio::build()?;
    }
    let runner: &[&str] = if succeeds(&mut cargo(&["nextest", "--version"])) {
        &["nextest", "run"]
    } else {
        // Documentation is tested in a step of its own.
        &["test", "--lib", "--bins", "--tests", "--examples"]
    };
    let tests = |more: &[&str]| cargo(&[runner, more].concat());
    step("tests", &mut tests(&["--workspace"]))?;
    step("tests in the documentation", &mut cargo(&["test", "--workspace", "--doc"]))?;
    step(
        "tests of the kernel without threads",
        &mut tests(&["--package", "fairform", "--no-default-features"]),
    )?;
    step(
        "tests of the files without threads",
        &mut tests(&["--package", "fairform-io", "--no-default-features", "--features", "files"]),
    )?;
    step(
        "tests of the direct solve",
        &mut tests(&[
            "--package",
            "fairform",
            "--features",
            "direct",
            "--test",
            "all",
            "--",
            "golden::",
            "fitting::",
            "exact::",
        ]),
    )?;
    new_user::run()?;
    if with_studio { studio::test() } else { Ok(()) }
}
