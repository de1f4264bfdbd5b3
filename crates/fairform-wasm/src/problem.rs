//! [`Problem`]: what went wrong, for people.

use std::fmt::Display;

use fairform::repair::Soup;
use fairform_io::repair::remedy;
use fairform_io::{Error, MeshData, ParseError};
use serde::Serialize;

/// A message for people: what, where, and what to do.
#[derive(Clone, PartialEq, Debug, Default, Serialize)]
pub struct Problem {
    /// One sentence.
    pub message: String,
    /// What is known to help.
    pub help: Option<String>,
    /// Steps that would make the file usable, in the order in which to run them.
    pub repairs: Vec<Repair>,
    /// Whether somebody cancelled it, which is no error.
    pub cancelled: bool,
}

/// One repair step.
#[derive(Clone, PartialEq, Eq, Debug, Serialize)]
pub struct Repair {
    /// Its name, see [`fairform_io::repair::Steps::ask`].
    pub step: String,
    /// What it does, in words.
    pub says: String,
}

impl Problem {
    /// Only a message.
    pub fn new(message: impl Into<String>) -> Self {
        Self { message: message.into(), ..Self::default() }
    }

    /// With advice.
    #[must_use]
    pub fn help(self, help: impl Into<String>) -> Self {
        Self { help: Some(help.into()), ..self }
    }

    /// An error that names its own place.
    pub fn at(place: impl Display, error: impl Display) -> Self {
        Self::new(format!("{place}: {error}"))
    }

    /// A kernel error about the mesh of a file, with the repairs that help, made on trial.
    #[must_use]
    pub fn in_mesh(name: &str, error: &fairform::Error, data: &MeshData) -> Self {
        if !matches!(error, fairform::Error::NotManifold(_)) {
            return Self::at(name, error);
        }
        let problem = Self::new(format!("{name}: {error} [counted from 0]"));
        let Some(steps) = remedy(&data.positions, &data.faces, false) else { return problem };
        let mut soup = Soup::new(data.positions.clone(), data.faces.clone());
        let done = steps.run(&mut soup).unwrap_or_default();
        let repairs: Vec<Repair> = done
            .into_iter()
            .map(|done| Repair { step: done.step.into(), says: done.words })
            .collect();
        let help = "repair it: the steps below make a surface of it";
        Self { repairs, ..problem.help(help) }
    }
}

impl From<ParseError> for Problem {
    fn from(error: ParseError) -> Self {
        Self::new(error.to_string())
    }
}

impl From<Error> for Problem {
    fn from(error: Error) -> Self {
        Self::new(error.to_string())
    }
}

impl From<fairform::Error> for Problem {
    fn from(error: fairform::Error) -> Self {
        let cancelled = matches!(error, fairform::Error::Interrupted);
        Self { cancelled, ..Self::new(error.to_string()) }
    }
}

impl From<fairform::streamline::Error> for Problem {
    fn from(error: fairform::streamline::Error) -> Self {
        Self::new(error.to_string())
    }
}
