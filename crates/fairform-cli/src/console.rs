//! What a person sees: notes and progress on standard error, results on standard output.

use std::cell::RefCell;
use std::io::{self, Write};
use std::time::Duration;

use indicatif::{ProgressBar, ProgressStyle};
use serde_json::{Value, json};

use crate::failure::Failure;

/// Where a command speaks.
#[derive(Debug)]
pub(crate) struct Console {
    quiet: bool,
    verbose: bool,
    json: bool,
    /// The line of progress, over which nothing else is to be written.
    bar: RefCell<ProgressBar>,
}

impl Console {
    pub(crate) fn new(quiet: bool, verbose: bool, json: bool) -> Self {
        Self { quiet, verbose, json, bar: RefCell::new(ProgressBar::hidden()) }
    }

    /// Whether results are for machines.
    pub(crate) fn json(&self) -> bool {
        self.json
    }

    /// Something that the user should know.
    pub(crate) fn note(&self, text: impl AsRef<str>) {
        if !self.quiet {
            self.bar.borrow().suspend(|| eprintln!("{}", text.as_ref()));
        }
    }

    /// Something that the user may want to know.
    pub(crate) fn detail(&self, text: impl AsRef<str>) {
        if self.verbose {
            self.note(text);
        }
    }

    /// A result for machines, if they are meant.
    pub(crate) fn result(&self, value: &Value) -> Result<(), Failure> {
        if self.json { self.print(&format!("{value:#}\n")) } else { Ok(()) }
    }

    /// Text on standard output. A reader who has seen enough is no failure.
    #[expect(clippy::unused_self, reason = "only who holds the console prints")]
    pub(crate) fn print(&self, text: &str) -> Result<(), Failure> {
        match io::stdout().lock().write_all(text.as_bytes()).and_then(|()| io::stdout().flush()) {
            Err(e) if e.kind() != io::ErrorKind::BrokenPipe => {
                Err(Failure::new(format!("cannot write to standard output: {e}")))
            }
            _ => Ok(()),
        }
    }

    pub(crate) fn fail(&self, failure: &Failure) {
        if self.json {
            let value = json!({ "error": failure.message, "help": failure.help });
            let _ = self.print(&format!("{value:#}\n"));
        }
        eprintln!("error: {}", failure.message);
        if let Some(help) = &failure.help {
            eprintln!("help: {help}");
        }
    }

    /// A line that tells what is going on, on a terminal, until it is dropped.
    pub(crate) fn progress(&self) -> Progress {
        let bar = if self.quiet { ProgressBar::hidden() } else { ProgressBar::new_spinner() };
        if let Ok(style) = ProgressStyle::with_template("{spinner} {elapsed:>4}  {msg}") {
            bar.set_style(style);
        }
        bar.enable_steady_tick(Duration::from_millis(100));
        self.bar.replace(bar.clone());
        Progress(bar)
    }
}

/// A line of progress.
#[derive(Debug)]
pub(crate) struct Progress(ProgressBar);

impl Progress {
    pub(crate) fn say(&self, text: impl Into<String>) {
        self.0.set_message(text.into());
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}

/// A count with separated thousands.
pub(crate) fn count(n: usize) -> String {
    let digits = n.to_string();
    let mut text = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

#[cfg(test)]
mod tests {
    #[test]
    fn thousands_are_separated() {
        assert_eq!([0, 999, 1000, 1_234_567].map(super::count), ["0", "999", "1,000", "1,234,567"]);
    }
}
