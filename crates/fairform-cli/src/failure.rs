//! Why a command failed, and what to do about it.

use std::error::Error as _;
use std::fmt::Write as _;

use fairform::{Error, Faces, Vec3};
use fairform_io::repair;

use crate::input::Source;

/// An error for a person: what went wrong and, where there is one, the way out.
#[derive(Debug)]
pub(crate) struct Failure {
    pub(crate) message: String,
    pub(crate) help: Option<String>,
    /// 1, or 2 if the command line asks for what cannot be.
    pub(crate) code: u8,
}

impl Failure {
    pub(crate) fn new(message: impl Into<String>) -> Self {
        Self { message: message.into(), help: None, code: 1 }
    }

    /// The command line is wrong.
    pub(crate) fn usage(message: impl Into<String>) -> Self {
        Self { code: 2, ..Self::new(message) }
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

/// A kernel error about the mesh of a file, with the repair that helps.
pub(crate) fn in_mesh(
    source: &Source,
    error: &Error,
    positions: &[Vec3],
    faces: &Faces,
) -> Failure {
    let failure = Failure::new(format!("{source}: {error}"));
    if !matches!(error, Error::NotManifold(_) | Error::NotTriangles { .. }) {
        return failure;
    }
    let failure = Failure { message: format!("{} [counted from 0]", failure.message), ..failure };
    match repair::remedy(positions, faces, true) {
        Some(steps) => failure.help(source.repair(&steps)),
        None => failure,
    }
}
