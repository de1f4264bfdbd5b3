//! What can go wrong between bytes and a mesh.

use std::fmt;
use std::io;
use std::path::PathBuf;

/// Where in a file something is wrong.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[non_exhaustive]
pub enum Place {
    /// A line of a text, from 1.
    Line(u64),
    /// A character of a text: its line and its place in it, both from 1.
    Character {
        /// The line.
        line: u64,
        /// The place, in bytes.
        column: u64,
    },
    /// An offset into binary data, from 0.
    Byte(u64),
    /// The file as a whole.
    File,
}

/// Why bytes could not be read as a mesh.
#[derive(Clone, PartialEq, Eq, Debug)]
#[non_exhaustive]
pub struct ParseError {
    /// Where.
    pub place: Place,
    /// What was found there, or what is wrong.
    pub message: String,
    /// What should have been there, if that can be said.
    pub expected: Option<String>,
}

impl fmt::Display for ParseError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.place {
            Place::Line(line) => write!(f, "line {line}: ")?,
            Place::Character { line, column } => write!(f, "line {line}, column {column}: ")?,
            Place::Byte(byte) => write!(f, "byte {byte}: ")?,
            Place::File => {}
        }
        f.write_str(&self.message)?;
        match &self.expected {
            Some(expected) => write!(f, "; expected {expected}"),
            None => Ok(()),
        }
    }
}

impl std::error::Error for ParseError {}

impl ParseError {
    pub(crate) fn new(place: Place, message: impl Into<String>) -> Self {
        Self { place, message: message.into(), expected: None }
    }

    pub(crate) fn file(message: impl Into<String>) -> Self {
        Self::new(Place::File, message)
    }

    pub(crate) fn byte(at: usize, message: impl Into<String>) -> Self {
        Self::new(Place::Byte(at as u64), message)
    }

    pub(crate) fn expected(mut self, what: impl Into<String>) -> Self {
        self.expected = Some(what.into());
        self
    }
}

/// Why a file could not be read or written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The system could not open or read the file.
    #[error("cannot read {}", shown(path))]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// The system could not create or write the file.
    #[error("cannot write {}", shown(path))]
    Write {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// The file holds no mesh that we can read.
    #[error("{}: {source}", shown(path))]
    Parse {
        /// The file.
        path: PathBuf,
        /// Where and why.
        source: ParseError,
    },
    /// Neither the caller nor the name says which format the file has.
    #[error("{}: unknown format; known are {known}", shown(path), known = crate::Format::KNOWN)]
    UnknownFormat {
        /// The file.
        path: PathBuf,
    },
    /// A writer refused what [`encode`](crate::encode) gave it.
    #[error("cannot write the mesh")]
    Output(#[from] io::Error),
    /// The data do not fit together, or the format has no way to hold them.
    #[error("cannot write the mesh: {0}")]
    Unwritable(String),
}

/// A path as a user reads it.
fn shown(path: &std::path::Path) -> String {
    if path.as_os_str() == "-" {
        "standard input or output".into()
    } else {
        path.display().to_string()
    }
}
