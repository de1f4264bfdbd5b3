//! Why a command failed, and what to do about it.

use std::error::Error as _;
use std::fmt::Write as _;

use fairform::{Defect, Error};

/// An error for a person: what went wrong and, where there is one, the way out.
#[derive(Debug)]
pub(crate) struct Failure {
    pub(crate) message: String,
    pub(crate) help: Option<String>,
}

impl Failure {
    pub(crate) fn new(message: impl Into<String>) -> Self {
        Self { message: message.into(), help: None }
    }

    pub(crate) fn help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }
}

impl From<fairform_io::Error> for Failure {
    fn from(error: fairform_io::Error) -> Self {
        // The causes, unless the message quotes them already.
        let mut message = error.to_string();
        let mut cause = error.source();
        while let Some(one) = cause {
            let text = one.to_string();
            if !message.contains(&text) {
                let _ = write!(message, ": {text}");
            }
            cause = one.source();
        }
        Self::new(message)
    }
}

impl From<fairform_render::RenderError> for Failure {
    fn from(error: fairform_render::RenderError) -> Self {
        Self::new(format!("cannot draw: {error}"))
    }
}

/// A kernel error about the mesh of a file.
pub(crate) fn in_file(name: &str, error: &Error) -> Failure {
    let failure = Failure::new(format!("{name}: {error}"));
    let repair = |flags: &str| {
        failure_help(name, flags, "numbers in this message count from 0 in the order of the file")
    };
    match error {
        Error::NotManifold(defects) => {
            let mut flags: Vec<&str> = defects.0.iter().flat_map(remedies).copied().collect();
            flags.sort_by_key(|flag| ORDER.iter().position(|o| o == flag));
            flags.dedup();
            failure.help(repair(&flags.join(" ")))
        }
        Error::NotTriangles { .. } => failure.help(repair("--triangulate")),
        _ => failure,
    }
}

const ORDER: [&str; 5] =
    ["--drop-degenerate", "--drop-duplicates", "--orient", "--split", "--drop-isolated"];

fn remedies(defect: &Defect) -> &'static [&'static str] {
    match defect {
        Defect::NotFinite { .. } => &["--drop-degenerate", "--drop-isolated"],
        Defect::NoSuchVertex { .. }
        | Defect::TooFewCorners { .. }
        | Defect::RepeatedCorner { .. } => &["--drop-degenerate"],
        Defect::InconsistentOrientation { .. } => &["--drop-duplicates", "--orient"],
        Defect::NonManifoldEdge { .. } => &["--drop-duplicates", "--orient", "--split"],
        _ => &["--split"],
    }
}

fn failure_help(name: &str, flags: &str, note: &str) -> String {
    let file = if name == "standard input" { "-" } else { name };
    format!("fairform repair {file} -o repaired.obj {flags}\n      ({note})")
}
