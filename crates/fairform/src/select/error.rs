//! [`SelectError`] and the places it names.

use alloc::string::String;

/// What is wrong with a selection, and where in its text.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
#[error("column {column}: {message}; expected {expected}")]
#[non_exhaustive]
pub struct SelectError {
    /// Where in the text, in bytes from 0: at most its length, and never inside a character.
    pub at: usize,
    /// The same in characters from 1, as people count.
    pub column: usize,
    /// What is wrong, without a full stop.
    pub message: String,
    /// What would be right, as a phrase: `a number`, say.
    pub expected: String,
}

/// A place in the text of a selection.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    /// Bytes from 0.
    pub(super) at: usize,
    /// Characters from 1.
    pub(super) column: usize,
}

/// Where a thing is said is no part of what it says, so that selections compare by meaning.
impl PartialEq for Place {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl Place {
    pub(super) fn error(
        self,
        message: impl Into<String>,
        expected: impl Into<String>,
    ) -> SelectError {
        let Self { at, column } = self;
        SelectError { at, column, message: message.into(), expected: expected.into() }
    }
}
